"""Estimated cost: counts are exact, times are those of the first node and trial."""

from types import SimpleNamespace

import pytest
from command_line import config_file
from tiny_tables import GENERATE, ROUGH

from tablegen.tables.cost import cost_text, estimate, time_text

NODE, TRIAL = 3.0, 1.0


class Cache:
    """Nodes and trials that take a known time."""

    def __init__(self, config):
        self.config, self.runner = config, SimpleNamespace(seconds={"fit": 0.0})

    def fit(self, size, conditions):
        self.runner.seconds["fit"] += NODE * len(conditions)

    def errors(self, size, places, error):
        self.runner.seconds["fit"] += TRIAL * len(places)


def test_named_nodes_are_counted():
    cost = estimate(Cache(ROUGH))
    assert cost.first == cost.most == (2, 2)
    assert cost.seconds == (4 * NODE, 4 * NODE)
    assert estimate(Cache(ROUGH), 5).seconds == (4 * NODE + 10 * TRIAL,) * 2


def test_open_grid_is_counted_as_it_is_and_halved_once():
    cost = estimate(Cache(ROUGH.with_changes({"table": {"speed_nodes": None}})))
    assert "nodes at first, up to about 2 x " in cost_text(cost, 2)
    speeds = cost.first[1]
    assert cost.most == (2, 2 * speeds - 1)
    trials = speeds + 2 * (speeds - 1) + (speeds - 1)
    assert cost.seconds[0] == 2 * speeds * NODE + trials * TRIAL
    assert cost.seconds[1] > cost.seconds[0] + 2 * (speeds - 1) * NODE


@pytest.mark.parametrize(
    ("ends", "text"),
    [
        ((0.2, 0.9), "1 seconds"),
        ((100.0, 7000.0), "1.7 to 120 minutes"),
        ((3600.0, 36000.0), "1 to 10 hours"),
    ],
)
def test_units_of_time(ends, text):
    assert time_text(*ends) == text


def test_is_printed_before_the_table_is_made(run, tmp_path, monkeypatch):
    def stop(*arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr(GENERATE, "refine_grid", stop)
    words = ("--output", tmp_path / "t.h5", "--workers", 3)
    ended = run("generate", config_file(tmp_path), *words)
    assert ended.err.splitlines()[0].startswith("tablegen: note: 2 x 2 nodes; about ")
    quiet = run("generate", config_file(tmp_path), *words, "--quiet", "--discard")
    assert "note" not in quiet.err
