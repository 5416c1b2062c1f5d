"""Conditions of a measurement are spread evenly over angle and speed, and never at a node."""

from types import SimpleNamespace

import numpy as np
import pytest
from refusals import refused

from tablegen.accuracy.conditions import (
    ComparedCondition,
    check_conditions,
    pick_conditions,
    pick_own_conditions,
)


def grid(alpha_deg, speed):
    nodes = {"alpha_nodes_deg": np.array(alpha_deg), "speed_nodes": np.array(speed)}
    return SimpleNamespace(**nodes, speed_independent=False)


@pytest.fixture
def table():
    return grid([1.0, 2.0, 30.0, 90.0], [50.0, 90.0, 100.0, 200.0, 300.0])


def picked(table, count, seed):
    return np.array([place[:2] for place in pick_conditions(table, count, seed)]).T


@pytest.mark.parametrize("count", [1, 7, 300])
def test_conditions_lie_well_between_nodes(table, count):
    alpha, speed = picked(table, count, 1)
    for values, nodes in ((alpha, table.alpha_nodes_deg), (speed, table.speed_nodes)):
        assert len(values) == count
        cell = np.searchsorted(nodes, values) - 1
        share = (values - nodes[cell]) / np.diff(nodes)[cell]
        assert 0.2 - 1e-12 <= share.min() <= share.max() <= 0.8 + 1e-12


def test_conditions_spread_evenly_over_degrees_and_speeds(table):
    """They are not spread evenly over cells, of which two thirds lie below 30 degrees."""
    alpha, speed = picked(table, 60, 2)
    # margins keep a condition in its cell; each end of a cell may cut one of 60 equal parts
    shares = np.histogram(alpha, table.alpha_nodes_deg)[0] / 60
    np.testing.assert_allclose(shares, np.diff(table.alpha_nodes_deg) / 89.0, atol=2.01 / 60)
    shares = np.histogram(speed, table.speed_nodes)[0] / 60
    np.testing.assert_allclose(shares, np.diff(table.speed_nodes) / 250.0, atol=2.01 / 60)


def test_conditions_are_a_function_of_the_seed(table):
    first = pick_conditions(table, 5, seed=1)
    assert first == sorted(first) == pick_conditions(table, 5, seed=1)
    assert first != pick_conditions(table, 5, seed=2)
    own = pick_own_conditions(table, 5, seed=1)
    assert own == pick_own_conditions(table, 5, seed=1)
    assert all(place.own for place in own)
    assert [place.alpha_deg for place in own[-2:]] == pytest.approx([86.4, 89.1])
    assert pick_own_conditions(table, 0, seed=1) == []


def test_axis_of_one_node_has_only_that():
    alpha, speed = picked(grid([40.0], [50.0, 300.0]), 4, 1)
    assert alpha.tolist() == [40.0] * 4
    assert len(set(speed)) == 4


def test_conditions_outside_of_the_table_are_refused(table):
    for alpha in (0.5, 90.0000001, float("nan")):
        refused("alpha", check_conditions, table, [ComparedCondition(alpha, 100.0)])
    refused("speed", check_conditions, table, [ComparedCondition(30.0, 310.0)])
    refused("at", check_conditions, table, [])
    assert check_conditions(table, [ComparedCondition(90, 50)]) == [(90.0, 50.0, False)]
