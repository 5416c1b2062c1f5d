"""Progress: a bar on a terminal, lines elsewhere, and those of long work only."""

import io
import sys

import pytest

from tablegen.tasks import progress


class Screen(io.StringIO):
    """Standard error that is a terminal."""

    def isatty(self):
        return True


def work(shown=True, steps=3):
    with progress.bar(shown, "piece", total=steps, desc="fitting") as bar:
        for _ in range(steps):
            bar.update()


def test_short_work_says_nothing_in_a_log(capsys):
    work()
    assert capsys.readouterr().err == ""


def test_long_work_says_lines_in_a_log(capsys, monkeypatch):
    monkeypatch.setattr(progress, "INTERVAL", 0.0)
    work()
    said = capsys.readouterr().err
    lines = said.splitlines()
    assert all(line.startswith("tablegen: fitting: ") for line in lines)
    assert any("1 of 3 pieces" in line for line in lines)
    assert "3 of 3 pieces" in lines[-1]
    assert "\r" not in said


def test_a_terminal_gets_a_bar_at_once(monkeypatch):
    screen = Screen()
    monkeypatch.setattr(sys, "stderr", screen)
    work()
    assert "\r" in screen.getvalue()
    assert "100%" in screen.getvalue()
    assert "tablegen:" not in screen.getvalue()


@pytest.mark.parametrize("file", [io.StringIO, Screen])
def test_quiet_says_nothing(file, monkeypatch):
    errors = file()
    monkeypatch.setattr(sys, "stderr", errors)
    monkeypatch.setattr(progress, "INTERVAL", 0.0)
    work(shown=False)
    assert errors.getvalue() == ""
