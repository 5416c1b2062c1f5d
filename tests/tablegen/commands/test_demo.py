"""The demonstration: with a smaller scene in ordinary tests, as it is in the study."""

import sys
import time
from functools import partial

import numpy as np
import pytest
from tiny_tables import ROUGH, TINY

import sampler
from tablegen.accuracy.validate import validate
from tablegen.commands import demo_run as demo
from tablegen.config.config import load_config

#: Steps of the demonstration, in the order in which it speaks of them.
STEPS = ("1. Generating ", "2. Drawing 1,000,000 rebounds", "3. Validating", "The table is in ")


def assert_told(said):
    text = "\n".join(said)
    positions = [text.index(step) for step in STEPS]
    assert positions == sorted(positions)
    return text


def assert_left(folder, *names):
    assert {path.name for path in folder.iterdir()} == set(names)
    for picture in folder.glob("*.png"):
        assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.fixture
def small_demo(monkeypatch, quick_measurement, quick_classifier):
    """Runs the demonstration on another scene, with a short validation; returns what it says."""

    def run(config, output):
        monkeypatch.setattr(demo, "load_config", lambda name: {"demo": config}[name])
        monkeypatch.setattr(demo, "validate", partial(validate, samples=4000))
        monkeypatch.setattr(demo, "_REPEATS", 1)
        said = []
        return demo.run_demo(output, said.append, progress=False), said

    return run


def test_generates_draws_and_validates(small_demo, tmp_path):
    output = tmp_path / "demo.h5"
    result, said = small_demo(TINY, output)
    text = assert_told(said)
    assert "synthetic corundum on steel St3, 35 to 45 degrees, 60 to 300 m/s" in text
    assert "at 35 degrees and 130 m/s" in text
    assert " times faster" in text
    assert "omega_z" in text
    assert result.holds
    assert "The declared accuracy holds at every condition." in text
    assert f"The table is in {output}" in text
    assert len(result.comparisons) == 6
    # The table is left behind, with its picture, and can be used.
    assert_left(tmp_path, "demo.h5", "demo.png")
    state = sampler.load(output).sample(0.7, 100.0, seed=1, index=range(10))
    assert state.shape == (10, 6)


def test_says_that_the_accuracy_is_missed(small_demo, tmp_path):
    config = ROUGH.with_changes({"accuracy": {"auc": 0.5}})
    result, said = small_demo(config, tmp_path / "demo.h5")
    assert not result.holds
    assert "The declared accuracy is missed:" in assert_told(said)


def test_without_matplotlib_one_line_says_how_to_get_it(small_demo, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    result, said = small_demo(TINY, tmp_path / "demo.h5")
    assert result.holds
    (line,) = (line for line in assert_told(said).splitlines() if "needs matplotlib" in line)
    assert line.strip() == (
        "no picture: needs matplotlib, which is not installed, allowed: "
        "pip install 'rebound-tables[plot]'"
    )
    assert_left(tmp_path, "demo.h5")


def test_time_of_a_draw_is_the_median_of_warm_runs(monkeypatch):
    """The first run is cold, and another meets a busy machine."""
    clock, costs = [0.0], iter([100.0, 3.0, 1.0, 50.0, 2.0, 2.0])
    monkeypatch.setattr(demo.time, "process_time", lambda: clock[0])

    def work():
        clock[0] += next(costs)

    assert demo._median_seconds(work) == 2.0


@pytest.mark.parametrize(
    ("table", "picture"), [("demo.h5", "demo.png"), ("demo", "demo.png"), ("a.png", "a.png.png")]
)
def test_picture_never_takes_the_place_of_the_table(table, picture, tmp_path):
    state = np.random.default_rng(1).uniform(size=(1000, 6))
    text = demo._picture_text(state, state, tmp_path / table)
    assert str(tmp_path / picture) in text
    assert_left(tmp_path, picture)


def test_scene_covers_the_condition_of_the_example():
    domain = load_config("demo").domain
    assert domain.alpha_deg[0] < demo._ALPHA_DEG < domain.alpha_deg[1]
    assert domain.speed[0] < demo._SPEED < domain.speed[1]


@pytest.mark.study
def test_the_real_one_holds_its_accuracy_in_three_minutes(tmp_path):
    begin, said = time.perf_counter(), []
    result = demo.run_demo(tmp_path / "demo.h5", said.append, progress=False)
    assert time.perf_counter() - begin < 180.0
    assert result.holds, result.missed
    assert_told(said)
    assert_left(tmp_path, "demo.h5", "demo.png")
