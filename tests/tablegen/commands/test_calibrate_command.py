"""``tablegen calibrate``: files, verdicts, an option with several names, refusals."""

import json

import pytest
from command_line import DONE, MISSED
from synthetic_measurements import small_pair

from tablegen.commands.calibrate import calibrate as command
from tablegen.measured import fits, smoothest

DATA = """\
# title: made up
alpha_deg,speed,e_n,e_t,count,source
20,100,0.6,0.7,,nobody
45,100,0.45,0.6,,nobody
70,100,0.4,0.75,,nobody
"""
WORDS = ["calibrate", "my.csv", "--output", "fitted.toml", "--quiet"]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(fits, "_MOST_REBOUNDS", 600)
    monkeypatch.setattr(smoothest, "_SAMPLES", 20)
    (tmp_path / "my.csv").write_text(DATA)
    (tmp_path / "start.toml").write_text(small_pair().text)
    return tmp_path


def test_means_that_are_held(folder, run):
    pytest.importorskip("matplotlib")
    ended = run(*WORDS, "--grains", "rounded", "--json", "fit.json", "--picture", "fit.svg")
    assert (ended.status, ended.err) == (DONE, "")
    assert ended.out.endswith("next: tablegen generate fitted.toml --output fitted.h5\n")
    record = json.loads((folder / "fit.json").read_text())
    assert [fit["grains"] for fit in record["fits"]] == ["rounded"]
    assert len(record["fits"][0]["parameters"]) == 14
    assert (folder / "fit.svg").read_text().startswith("<?xml")
    assert "made up" in (folder / "fitted.toml").read_text()


@pytest.mark.usefixtures("folder")
def test_means_that_a_form_misses(run):
    flags = ["--pair", "start.toml", "--free", "pair.restitution.value"]
    ended = run(*WORDS, *flags)
    assert (ended.status, ended.err) == (MISSED, "")
    assert "next:" not in ended.out


def test_a_flag_takes_several_names(folder):
    words = ["--free", "pair.a", "+pair.b", "--free", "any", "--grains", "rounded"]
    values = command.make_context("calibrate", [*WORDS[1:], *words]).params
    assert values["free"] == ("pair.a", "+pair.b", "any")
    assert values["grains"] == "rounded"


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize(
    ("flags", "message"),
    [
        (["--pair", "start.toml", "--free", "pair.x"], "free: got 'pair.x'"),
        (["--picture", "fit.txt"], "--picture: got fit.txt"),
        (["--output", "fitted.h5"], "--output: got fitted.h5"),
        (["--grains", "round"], "--grains: got 'round'"),
    ],
)
def test_refusals(refused, flags, message):
    words = WORDS[:2] if "--output" in flags else WORDS
    assert message in refused(*words, *flags)
