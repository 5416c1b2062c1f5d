"""Estimated cost: the time of one node and of one leaf, times their numbers."""

from types import SimpleNamespace

import numpy as np
import pytest
from command_line import config_file
from tiny_tables import GENERATE, ROUGH

from tablegen.tables import cost as module
from tablegen.tables.cost import cost_text, estimate, time_text
from tablegen.tables.plan import make_plan

NODE, LEAF = 3.0, 5.0


class Runner:
    """Tasks that take a known time."""

    def __init__(self):
        self.seconds = 0.0

    def run(self, title, tasks, stored):
        return {key: {"seconds_of_leaf": np.array(LEAF)} for key in tasks}


class Cache:
    """Nodes that take a known time."""

    def __init__(self):
        self.runner = Runner()

    def fit(self, size, conditions):
        self.runner.seconds += NODE * len(conditions)


def test_nodes_and_leaves_are_counted():
    plan = make_plan(ROUGH)
    assert plan.first == plan.most == (2, 2)
    assert estimate(plan, Cache(), 0.0).seconds == 4 * NODE
    spinning = make_plan(ROUGH.with_changes({"spin": True, "table": {"spin_leaves": 7}}))
    assert estimate(spinning, Cache(), 0.0).seconds == 4 * NODE + spinning.leaves * LEAF
    assert spinning.leaves >= 4 * 7


def test_an_open_grid_is_counted_with_all_nodes_that_it_may_get():
    plan = make_plan(ROUGH.with_changes({"table": {"speed_nodes": None}}))
    assert plan.most[1] == 3 * plan.first[1] - 2
    cost = estimate(plan, Cache(), 0.0)
    assert "nodes at first, at most 2 x " in cost_text(cost, 2)
    assert cost.seconds == 2 * plan.most[1] * NODE


def test_pieces_of_an_interrupted_run_do_not_cost_again():
    cost = estimate(make_plan(ROUGH), Cache(), 3 * NODE)
    assert cost.seconds == pytest.approx(NODE)
    assert "about 3 seconds of one processor after the 9 seconds" in cost_text(cost, 1)


def test_a_leaf_is_timed_at_its_full_size(monkeypatch):
    sizes = SimpleNamespace(rebounds=5, _replace=lambda **changes: SimpleNamespace(**changes))
    fitted = []
    shape = SimpleNamespace(leaf_conditions=lambda number: number)
    monkeypatch.setattr(module, "conditions_task", lambda *_: {})
    monkeypatch.setattr(module, "ShapeConditions", lambda: shape)
    monkeypatch.setattr(module, "leaf_task", lambda *given: fitted.append(given[3].rebounds))
    assert module._fit_one_leaf(ROUGH, 0, sizes)["seconds_of_leaf"] >= 0.0
    assert fitted == [module._TO_COMPILE, 5]


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
    quiet = run("generate", config_file(tmp_path), *words, "--quiet")
    assert "note" not in quiet.err
