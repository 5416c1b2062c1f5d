"""Estimated cost: counts are exact, times are those of the first node."""

from types import SimpleNamespace

import pytest
from command_line import config_file
from tiny_tables import GENERATE, ROUGH

from tablegen.tables.cost import cost_text, estimate, time_text
from tablegen.tables.plan import make_plan

NODE = 3.0


class Cache:
    """Nodes that take a known time."""

    def __init__(self):
        self.runner = SimpleNamespace(seconds=0.0)

    def fit(self, size, conditions):
        self.runner.seconds += NODE * len(conditions)


def test_named_nodes_are_counted():
    plan = make_plan(ROUGH)
    cost = estimate(plan, Cache(), 0, 0.0)
    assert plan.first == plan.most == (2, 2)
    assert cost.seconds == (4 * NODE, 4 * NODE)
    low, high = estimate(plan, Cache(), 5, 0.0).seconds
    assert 4 * NODE < low == high


def test_open_grid_is_counted_at_first_and_at_most():
    plan = make_plan(ROUGH.with_changes({"table": {"speed_nodes": None}}))
    cost = estimate(plan, Cache(), 0, 0.0)
    assert "nodes at first, at most 2 x " in cost_text(cost, 2)
    assert plan.most[1] == 3 * plan.first[1] - 2
    low, high = cost.seconds
    assert low > 2 * plan.first[1] * NODE
    assert high > max(low, 2 * plan.most[1] * NODE)


def test_pieces_of_an_interrupted_run_do_not_cost_again():
    cost = estimate(make_plan(ROUGH), Cache(), 0, 3 * NODE)
    assert cost.seconds == (NODE, NODE)
    assert "about 3 seconds of one processor after the 9 seconds" in cost_text(cost, 1)


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
    assert "tablegen: note: 2 x 2 nodes; about " in ended.err
    quiet = run("generate", config_file(tmp_path), *words, "--quiet", "--discard")
    assert "note" not in quiet.err
