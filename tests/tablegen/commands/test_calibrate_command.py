"""Command ``tablegen calibrate``: files, several values of a flag, and refusals of one line."""

import json

import pytest
from command_line import MISSED
from synthetic_measurements import shorten_searches, small_pair

from tablegen.commands.calibrate import calibrate as command

DATA = """\
# title: made up
alpha_deg,speed,e_n,e_t,count,source
20,100,0.6,0.8,500,nobody
45,100,0.5,0.7,500,nobody
70,100,0.45,0.75,500,nobody
"""
WORDS = ["calibrate", "my.csv", "--pair", "start.toml", "--output", "fitted.toml", "--quiet"]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my.csv").write_text(DATA)
    (tmp_path / "start.toml").write_text(small_pair().text)
    return tmp_path


def test_files(folder, run, monkeypatch):
    pytest.importorskip("matplotlib")
    shorten_searches(monkeypatch)
    flags = ["--count", "200", "--free", "pair.restitution.value", "pair.resistance.value"]
    flags += ["--hold-out", "45", "--json", "fit.json", "--picture", "fit.svg"]
    ended = run(*WORDS, *flags)
    assert (ended.status, ended.err) == (MISSED, "")
    assert ended.out.startswith(
        "means: constant restitution and constant resistance miss 3 of 4: e_n "
    )
    assert "\nspreads: not used\n" in ended.out
    assert "fitted.toml: the fitted pair fitted; " in ended.out
    assert ended.out.endswith("next: tablegen generate fitted.toml --output fitted.h5\n")
    assert "largest residual of e_n" in ended.out
    found = json.loads((folder / "fit.json").read_text())
    names = [one["name"] for one in found["parameters"]]
    assert names == ["pair.restitution.value", "pair.resistance.value"]
    assert sum(one["held_out"] for one in found["numbers"]) == 2
    assert (folder / "fit.svg").read_text().startswith("<?xml")
    assert "made up" in (folder / "fitted.toml").read_text()


def test_a_flag_takes_several_values(folder):
    words = ["--hold-out", "45", "60.5", "--free", "pair.a", "wall_tilt_deg", "--free", "any"]
    found = command.make_context("calibrate", [*WORDS[1:], *words]).params
    assert found["free"] == ("pair.a", "wall_tilt_deg", "any")
    assert found["hold_out"] == (45.0, 60.5)


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize(
    ("flags", "said"),
    [
        (["--free", "pair.wrong"], "free: got 'pair.wrong', allowed: pair.restitution.value, "),
        (["--output", "my.csv"], "--output: got my.csv, the same file as "),
        (["--picture", "fit.txt"], "--picture: got fit.txt, allowed: a name in .png"),
    ],
)
def test_refusals(refused, flags, said):
    assert said in refused(*WORDS, *flags)
