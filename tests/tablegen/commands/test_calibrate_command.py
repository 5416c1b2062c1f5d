"""``tablegen calibrate``: files, several values of a flag, and refusals of one line."""

import json
import subprocess

import pytest
from command_line import BAD_INPUT, DONE
from processes import TABLEGEN

from tablegen.commands.calibrate import calibrate as command
from tablegen.commands.main import main

DATA = """\
# title: made up
alpha_deg,speed,e_n,e_t,count,source
20,100,0.6,0.8,500,nobody
45,100,0.5,0.7,500,nobody
70,100,0.45,0.75,500,nobody
"""
PAIR = """\
name = "start"
[pair]
particle = "p"
wall = "w"
[pair.restitution]
law = "constant"
value = 0.5
source = "none"
[pair.resistance]
law = "constant"
value = 0.4
source = "none"
[population.shapes]
ellipsoid = 1.0
[population.aspect]
distribution = "fixed"
values = [0.9, 0.8]
[domain]
alpha_deg = [10.0, 90.0]
speed = [100.0, 100.0]
extrapolate = true
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my.csv").write_text(DATA)
    (tmp_path / "start.toml").write_text(PAIR)
    return tmp_path


WORDS = ["calibrate", "my.csv", "--pair", "start.toml", "--output", "fitted.toml", "--quiet"]


def test_files(folder, capsys):
    flags = ["--count", "200", "--free", "pair.restitution.value", "pair.resistance.value"]
    flags += ["--hold-out", "45", "--json", "fit.json", "--picture", "fit.svg"]
    assert main([*WORDS, *flags]) == DONE
    out, err = capsys.readouterr()
    assert err == ""
    assert "fitted.toml: the fitted pair fitted" in out
    assert "largest residual of e_n" in out
    found = json.loads((folder / "fit.json").read_text())
    assert [one["name"] for one in found["parameters"]] == [
        "pair.restitution.value",
        "pair.resistance.value",
    ]
    assert sum(one["held_out"] for one in found["numbers"]) == 2
    assert (folder / "fit.svg").read_text().startswith("<?xml")
    assert "made up" in (folder / "fitted.toml").read_text()
    assert main(["inspect", "fitted.toml", "--config"]) in (DONE, BAD_INPUT)


@pytest.mark.parametrize(
    ("words", "free", "hold_out"),
    [
        (["--free", "pair.a", "population.b", "--seed", "1"], ("pair.a", "population.b"), ()),
        (["--free", "pair.a", "--free", "wall_tilt_deg"], ("pair.a", "wall_tilt_deg"), ()),
        (["--hold-out", "45", "60.5", "--free", "pair.a"], ("pair.a",), (45.0, 60.5)),
    ],
)
def test_a_flag_takes_several_values(folder, words, free, hold_out):
    context = command.make_context("calibrate", [*WORDS[1:], *words])
    assert context.params["free"] == free
    assert context.params["hold_out"] == hold_out


@pytest.mark.parametrize(
    ("flags", "said"),
    [
        (["--free", "pair.wrong"], "free: got 'pair.wrong', allowed: pair.restitution.value, "),
        (["--hold-out", "50"], "hold_out: got 50 degrees, allowed: 20, 45, 70"),
        (["--output", "my.csv"], "--output: got my.csv, the same file as "),
        (["--output", "start.toml"], "--output: got start.toml, the same file as "),
        (["--picture", "fit.txt"], "--picture: got fit.txt, allowed: a name in .png"),
        (["--resume", "--discard"], "--discard: got it with --resume, allowed: one of the two"),
        (["--count", "10"], "count: got 10, allowed: 200 or more"),
    ],
)
def test_refusals(folder, capsys, flags, said):
    before = sorted(path.name for path in folder.iterdir())
    assert main([*WORDS, *flags]) == BAD_INPUT
    err = capsys.readouterr().err
    assert said in err
    assert err.count("\n") == 1
    assert sorted(path.name for path in folder.iterdir()) == before


def test_ctrl_c_says_how_to_go_on(folder, monkeypatch):
    import time

    words = [*TABLEGEN, *WORDS, "--count", "2000000"]
    with subprocess.Popen(words, cwd=folder, stderr=subprocess.PIPE, text=True) as process:
        deadline = time.monotonic() + 60.0
        while not list(folder.glob("fitted.toml.parts/piece-*")) and time.monotonic() < deadline:
            time.sleep(0.1)
        process.send_signal(2)
        _, err = process.communicate(timeout=20)
    assert process.returncode == 130
    assert "the same command with --resume continues from fitted.toml.parts" in err
    assert not (folder / "fitted.toml").exists()
