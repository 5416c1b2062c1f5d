"""How programs end: 1 says that an accuracy was missed, and nothing else ends so."""

import errno
import os
import subprocess
import sys
from importlib import import_module

import click
import pytest
from sampler.options import BAD_INPUT, DONE, FAILED, Program, run_program

from sampler.errors import InputError

FULL = "/dev/full"
needs_full_device = pytest.mark.skipif(not os.path.exists(FULL), reason="needs a full device")


def _run(work, capsys):
    """Run a program of one command; status and standard error."""
    program = Program("prog", commands=[click.Command("work", callback=work)])
    status = run_program(program, ["work"])
    return status, capsys.readouterr().err


def _raising(error):
    def work():
        raise error

    return work


DISK_FULL = OSError(errno.ENOSPC, "No space left on device", "a.npz")


@pytest.mark.parametrize(
    ("error", "status", "line"),
    [
        (InputError("x: got 1, allowed: 2"), BAD_INPUT, "error: x: got 1, allowed: 2"),
        (click.UsageError("no such thing"), BAD_INPUT, "error: no such thing"),
        (MemoryError(), BAD_INPUT, "error: not enough memory, allowed: a smaller count"),
        (KeyboardInterrupt(), 130, "interrupted"),
        (DISK_FULL, FAILED, "error: [Errno 28] No space left on device: 'a.npz'"),
        (BrokenPipeError(errno.EPIPE, "Broken pipe"), FAILED, ""),
    ],
)
def test_what_users_can_cause_is_one_line(capsys, error, status, line):
    ended, told = _run(_raising(error), capsys)
    assert ended == status
    assert told.strip().startswith(f"prog: {line}" if line else "")
    assert told.strip().count("\n") == 0


@pytest.mark.parametrize("error", [RuntimeError("odd"), RecursionError("deep"), ValueError("a\nb")])
def test_a_defect_keeps_its_traceback_and_is_no_missed_accuracy(capsys, error):
    status, told = _run(_raising(error), capsys)
    assert status == FAILED == 3
    *traceback, line = told.splitlines()
    assert traceback[0].startswith("Traceback")
    said = " ".join(str(error).split())
    assert line == (
        "prog: error: a defect of the program, please report it with the lines above; "
        f"{type(error).__name__}: {said}"
    )


def test_interruption_before_any_command_is_no_traceback(capsys):
    def start(words, call):
        raise KeyboardInterrupt

    assert run_program(Program("prog"), [], start) == 130
    assert capsys.readouterr().err == "prog: interrupted\n"


def test_lines_are_short_and_obey_no_terminal(capsys):
    error = InputError("pair: got '\x1b[2J\x07evil\x85\u2028name" + 10**6 * "x" + "'")
    status, told = _run(_raising(error), capsys)
    assert status == BAD_INPUT
    assert told.startswith("prog: error: pair: got '\\x1b[2J\\x07evil name")
    assert len(told) < 5000
    assert told.endswith(" ...\n")
    assert all(c.isprintable() for c in told[:-1])


def _process(program, *words, **streams):
    process = [sys.executable, "-m", program, *words]
    return subprocess.run(process, text=True, timeout=100, **streams)


@needs_full_device
@pytest.mark.parametrize(
    ("program", "words"),
    [
        ("tablegen", ("inspect", "corundum-steel")),
        ("tablegen", ("--help",)),
        ("tablegen", ()),
        ("sampler", ("list",)),
    ],
)
def test_full_standard_output_is_one_line(program, words):
    with open(FULL, "w") as full:
        ended = _process(program, *words, stdout=full, stderr=subprocess.PIPE)
    assert ended.returncode == FAILED
    assert ended.stderr == f"{program}: error: [Errno 28] No space left on device\n"


@needs_full_device
def test_full_standard_error_keeps_the_status():
    with open(FULL, "w") as full:
        ended = _process("sampler", "lost", stdout=subprocess.PIPE, stderr=full)
    assert (ended.returncode, ended.stdout) == (BAD_INPUT, "")


@pytest.mark.parametrize("words", [("inspect", "corundum-steel"), ("--help",)])
def test_a_reader_that_went_away_is_no_missed_accuracy(words):
    reading, writing = os.pipe()
    os.close(reading)
    try:
        ended = _process("tablegen", *words, stdout=writing, stderr=subprocess.PIPE)
    finally:
        os.close(writing)
    assert (ended.returncode, ended.stderr) == (FAILED, "")


@pytest.mark.parametrize("program", ["sampler", "tablegen"])
def test_statuses_are_documented(program, capsys):
    assert import_module(f"{program}.commands.main").main(["--help"]) == DONE
    page = " ".join(capsys.readouterr().out.split())
    assert "2 bad input, 3 any other failure, 130 interrupted, 143 terminated." in page
