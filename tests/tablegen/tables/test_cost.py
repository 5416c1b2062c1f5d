"""Estimated cost: counts are exact, times are those of the first node."""

from types import SimpleNamespace

import pytest
from command_line import config_file
from tiny_tables import GENERATE, ROUGH

from tablegen.accuracy.measure import sample_size
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
    assert cost.seconds == pytest.approx(4 * NODE)
    assert estimate(plan, Cache(), 5, 0.0).seconds > 5 * NODE


def test_open_grid_costs_more_than_its_first_nodes_and_less_than_all_of_them():
    plan = make_plan(ROUGH.with_changes({"table": {"speed_nodes": None}}))
    assert plan.most[1] == 3 * plan.first[1] - 2
    cost = estimate(plan, Cache(), 0, 0.0)
    assert "nodes at first, at most 2 x " in cost_text(cost, 2)
    nodes, states = 2 * plan.most[1] * NODE, sample_size(ROUGH.accuracy, 25_000)
    assert 2 * plan.first[1] * NODE < cost.seconds
    trials = 3 * plan.most[1] * NODE * (2.0 * states / plan.sizes[0].samples)
    classifiers = NODE * 1e6 / plan.sizes[0].samples
    assert cost.seconds < nodes + trials + classifiers


def test_pieces_of_an_interrupted_run_do_not_cost_again():
    cost = estimate(make_plan(ROUGH), Cache(), 0, 3 * NODE)
    assert cost.seconds == pytest.approx(NODE)
    assert "about 3 seconds of one processor after the 9 seconds" in cost_text(cost, 1)


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.9, "1 seconds"), (100.0, "100 seconds"), (7000.0, "120 minutes"), (36000.0, "10 hours")],
)
def test_units_of_time(seconds, text):
    assert time_text(seconds) == text


def test_is_printed_before_the_table_is_made(run, tmp_path, monkeypatch):
    def stop(*arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr(GENERATE, "refine_grid", stop)
    words = ("--output", tmp_path / "t.h5", "--workers", 3)
    ended = run("generate", config_file(tmp_path), *words)
    assert "tablegen: note: 2 x 2 nodes; about " in ended.err
    quiet = run("generate", config_file(tmp_path), *words, "--quiet", "--discard")
    assert "note" not in quiet.err
