"""``tablegen demo``, with a small scene and a short validation."""

import sys
from functools import partial

import numpy as np
import pytest
from command_line import DONE, MISSED
from tiny_tables import ROUGH, TINY

import sampler
from tablegen.accuracy.validate import validate
from tablegen.commands.demo import demo as command

demo = sys.modules[command.callback.__module__]


@pytest.fixture
def small_demo(run, monkeypatch, tmp_path, quick_measurement, quick_classifier):
    """Run the demonstration on another scene, with a short validation."""

    def small(config):
        monkeypatch.setattr("tablegen.config.config.load_config", lambda name: config)
        short = partial(validate, samples=4000)
        monkeypatch.setattr(demo, "_CONDITIONS", 2)
        monkeypatch.setattr(sys.modules[validate.__module__], "validate", short)
        return run("demo", "--output", tmp_path / "demo.h5", "--quiet")

    return small


def test_generates_draws_and_validates(small_demo, tmp_path):
    ended = small_demo(TINY)
    assert (ended.status, ended.err) == (DONE, "")
    steps = [line[:2] for line in ended.out.splitlines() if line[1:2] == "."]
    assert steps == ["1.", "2.", "3."]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["demo.h5", "demo.png"]
    assert (tmp_path / "demo.png").read_bytes().startswith(b"\x89PNG")
    assert sampler.load(tmp_path / "demo.h5").sample(0.7, 100.0, seed=1, index=[1]).shape == (1, 6)


def test_missed_accuracy_is_status_1_and_needs_no_matplotlib(small_demo, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    ended = small_demo(ROUGH.with_changes({"accuracy": {"auc": 0.5}}))
    assert ended.status == MISSED
    assert "no picture: matplotlib is not installed" in ended.out
    assert [path.name for path in tmp_path.iterdir()] == ["demo.h5"]


@pytest.mark.parametrize(
    ("table", "picture"), [("demo.h5", "demo.png"), ("demo", "demo.png"), ("a.png", "a.png.png")]
)
def test_picture_never_replaces_the_table(table, picture, tmp_path):
    state = np.random.default_rng(1).uniform(size=(1000, 6))
    assert str(tmp_path / picture) in demo._picture_text(state, state, tmp_path / table)
    assert [path.name for path in tmp_path.iterdir()] == [picture]
