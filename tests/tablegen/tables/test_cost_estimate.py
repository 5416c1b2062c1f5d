"""What `tablegen generate` says beforehand: counts are exact, times hold what was measured."""

import re
from pathlib import Path

import pytest
from command_line import config_file
from tablegen.tables.cost_estimate import cost_text, estimate, rebound_seconds
from tiny_tables import GENERATE, ROUGH

from tablegen.config.config import load_config
from tablegen.config.defaults import GENERATE_CONDITIONS as CONDITIONS
from tablegen.tables import cost_estimate as module

EXPERIMENTS = Path(module.__file__).parents[1] / "fitting" / "EXPERIMENTS.md"

#: Seconds of a rebound on the machine of that page: 301 s of simulation for the standard preset.
THERE = 1.15e-6

#: Its tables cover only the speeds that were measured, and particles without spin.
OF_THEM = {"spin": False, "domain": {"speed": [50.0, 300.0]}}


def documented():
    """Preset, angles, speeds and worker seconds of the whole tables of EXPERIMENTS.md."""
    rows = re.findall(
        r"^\| (compact|standard|fine), ?.*?\| (\d+) × (\d+) \|[^|]+\|[^|]+\| ([\d,]+) \|"
        r"|^\| (compact|standard) \| (\d+) × (\d+) \|[^|]+\|[^|]+\| ([\d,]+) \|",
        EXPERIMENTS.read_text(encoding="utf-8"),
        re.M,
    )
    for row in rows:
        name, alphas, speeds, seconds = (cell for cell in row if cell)
        yield name, int(alphas), int(speeds), float(seconds.replace(",", ""))


def test_holds_for_the_tables_that_were_made():
    found = list(documented())
    assert {row[0] for row in found} == {"compact", "standard", "fine"}
    for preset, alphas, speeds, seconds in found:
        name = "corundum-steel" if preset == "standard" else f"corundum-steel-{preset}"
        config = load_config(name)
        # the fine scene says so itself, with its nodes, which would not outlive a change of range
        cost = estimate(config.with_changes(OF_THEM) if config.spin else config, THERE, 24)
        assert cost.first[0] <= alphas <= cost.most[0]
        assert cost.first[1] <= speeds <= cost.most[1]
        assert cost.least_seconds <= seconds <= cost.most_seconds
        assert cost.most_seconds < 10.0 * cost.least_seconds


def test_nodes_that_are_named_are_counted():
    cost = estimate(ROUGH, THERE)
    assert cost.first == cost.most == (2, 2)
    one = estimate(ROUGH.with_changes({"table": {"speed_nodes": [60.0, 150.0, 300.0]}}), THERE)
    assert one.most == (2, 3)
    assert one.least_seconds / cost.least_seconds == pytest.approx(1.5)


def test_grows_with_what_is_asked_for():
    plain = estimate(ROUGH, THERE, CONDITIONS)
    for changes in (
        {"table": {"samples_per_node": 100_000}},
        {"table": {"components": 1000, "samples_per_node": 10_000}},
        {"accuracy": {"ks": 0.001}},
    ):
        assert estimate(ROUGH.with_changes(changes), THERE, CONDITIONS)[3] > plain.most_seconds
    assert estimate(ROUGH, 100.0 * THERE, CONDITIONS).least_seconds > plain.least_seconds
    assert estimate(ROUGH, THERE, 2 * CONDITIONS).least_seconds > plain.least_seconds


def test_time_of_a_rebound_is_measured_here_and_warm(monkeypatch):
    """The first run of each angle, which compiles, does not count."""
    clock, calls = [0.0], []

    def simulate(config, alpha1, speed, count, *, seed, threads):
        calls.append(alpha1)
        clock[0] += 50.0 if len(calls) % 2 else 1e-6 * count * len(calls)

    monkeypatch.setattr(module, "simulate", simulate)
    monkeypatch.setattr(module.time, "process_time", lambda: clock[0])
    assert rebound_seconds(ROUGH) == pytest.approx(4e-6)
    assert len(set(calls)) == 3


@pytest.mark.parametrize(
    ("workers", "parts"),
    [
        (1, ("16 x 5 nodes at first, more", "up to about 28 x 12", " of one processor; ")),
        (2, (" of one processor, ", " on 2; up to ")),
        (None, (" of one processor; ", " GB of memory a process")),
    ],
)
def test_words(workers, parts):
    line = cost_text(estimate(load_config("corundum-steel"), THERE), workers)
    assert all(part in line for part in parts)
    assert "\n" not in line


@pytest.mark.parametrize(
    ("ends", "text"),
    [
        ((0.2, 0.9), "1 seconds"),
        ((30.0, 100.0), "30 to 100 seconds"),
        ((100.0, 7000.0), "1.7 to 120 minutes"),
        ((3600.0, 36000.0), "1 to 10 hours"),
    ],
)
def test_units_of_time(ends, text):
    assert module._time_text(*ends) == text


def test_is_said_before_any_piece_is_made(run, tmp_path, monkeypatch):
    def stop(*arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr(GENERATE, "refine_grid", stop)
    words = ("--output", tmp_path / "t.h5", "--workers", 3)
    ended = run("generate", config_file(tmp_path), *words)
    first = ended.err.splitlines()[0]
    assert first.startswith("tablegen: note: 2 x 2 nodes; about ")
    assert " on 3; up to 0." in first
    quiet = run("generate", config_file(tmp_path), *words, "--quiet")
    assert "note" not in quiet.err
