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

    def errors(self, size, places):
        self.runner.seconds["fit"] += TRIAL * len(places)


def test_named_nodes_are_counted():
    cost = estimate(Cache(ROUGH))
    assert cost.first == cost.most == (2, 2)
    assert cost.seconds == (4 * NODE, 4 * NODE)
    low, high = estimate(Cache(ROUGH), 5).seconds
    assert 4 * NODE + 3 * TRIAL < low < 4 * NODE + 5 * TRIAL < 4 * NODE + 15 * TRIAL < high


def test_open_grid_is_counted_at_first_and_at_most():
    cost = estimate(Cache(ROUGH.with_changes({"table": {"speed_nodes": None}})))
    assert "nodes at first, at most 2 x " in cost_text(cost, 2)
    speeds, most = cost.first[1], cost.most[1]
    assert most == 3 * speeds - 2
    low, high = (2 * n * NODE + k * (4 * n - 3) * TRIAL for n, k in ((speeds, 1), (most, 2)))
    assert cost.seconds == (low, high)


def test_pieces_of_an_interrupted_run_do_not_cost_again():
    cost = estimate(Cache(ROUGH), 0, 3 * NODE)
    assert cost.seconds == (NODE, NODE)
    assert "about 3 seconds of one processor beside the 9 seconds that are done" in cost_text(
        cost, 1
    )


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
