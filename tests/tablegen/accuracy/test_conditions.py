"""Where accuracy is measured: evenly over angle and speed, never at a node."""

import numpy as np
import pytest
from grids import grid_table
from scipy.stats import qmc

from sampler.errors import InputError
from tablegen.accuracy.conditions import check_conditions, pick_conditions


@pytest.fixture(scope="module")
def table():
    return grid_table([1.0, 2.0, 30.0, 90.0], [50.0, 90.0, 100.0, 200.0, 300.0])


def cell_fraction(values, nodes):
    """Where values lie in their cells, from 0 to 1."""
    cell = np.searchsorted(nodes, values) - 1
    return (values - nodes[cell]) / np.diff(nodes)[cell]


@pytest.mark.parametrize("count", [1, 7, 300])
def test_lie_well_between_nodes(table, count):
    alpha, speed = np.array(pick_conditions(table, count, seed=1)).T
    assert len(alpha) == count
    for values, nodes in ((alpha, table.alpha_nodes_deg), (speed, table.speed_nodes)):
        fraction = cell_fraction(values, nodes)
        assert fraction.min() >= 0.2 - 1e-12
        assert fraction.max() <= 0.8 + 1e-12


def test_spread_evenly_over_degrees_and_speeds(table):
    """Not over the numbers of the nodes: two thirds of these cells lie below 30 degrees."""
    alpha, speed = np.array(pick_conditions(table, 60, seed=2)).T
    # margins keep a condition in its cell; each end of a cell may cut one of 60 equal parts
    shares = np.histogram(alpha, table.alpha_nodes_deg)[0] / 60
    np.testing.assert_allclose(shares, np.diff(table.alpha_nodes_deg) / 89.0, atol=2.01 / 60)
    shares = np.histogram(speed, table.speed_nodes)[0] / 60
    np.testing.assert_allclose(shares, np.diff(table.speed_nodes) / 250.0, atol=2.01 / 60)


@pytest.mark.parametrize("count", [8, 24])
def test_fill_the_plane_better_than_chance(count):
    table = grid_table([1.0, 90.0], [50.0, 300.0])

    def discrepancy(seed):
        alpha, speed = np.array(pick_conditions(table, count, seed)).T
        # undo the margins of the one cell
        unit = np.column_stack(((alpha - 1.0) / 89.0, (speed - 50.0) / 250.0))
        return qmc.discrepancy((unit - 0.2) / 0.6)

    rng = np.random.default_rng(3)
    by_chance = [qmc.discrepancy(rng.random((count, 2))) for _ in range(200)]
    assert max(discrepancy(seed) for seed in range(5)) < np.quantile(by_chance, 0.05)


def test_are_a_function_of_the_seed(table):
    first = pick_conditions(table, 5, seed=1)
    assert first == pick_conditions(table, 5, seed=1)
    assert first != pick_conditions(table, 5, seed=2)
    assert first == sorted(first)
    assert all(type(value) is float for pair in first for value in pair)
    assert pick_conditions(table, 0, seed=1) == []
    assert len(pick_conditions(table, 3, seed=2**64 - 1)) == 3


def test_axis_of_one_node_has_only_that():
    table = grid_table([40.0], [50.0, 300.0])
    conditions = pick_conditions(table, 4, seed=1)
    assert [alpha for alpha, _ in conditions] == [40.0] * 4
    assert len({speed for _, speed in conditions}) == 4


@pytest.mark.parametrize(
    ("conditions", "line"),
    [
        ([], "at: got no condition, allowed: one or more"),
        (
            [(30.0, 100.0), (0.5, 100.0)],
            "alpha: got 0.5 degrees, allowed: 1 to 90 degrees, which the table covers",
        ),
        (
            [(90.0000001, 100.0)],
            "alpha: got 90.0000001 degrees, allowed: 1 to 90 degrees, which the table covers",
        ),
        ([(30.0, 310.0)], "speed: got 310 m/s, allowed: 50 to 300 m/s, which the table covers"),
        (
            [(float("nan"), 100.0)],
            "alpha: got nan degrees, allowed: 1 to 90 degrees, which the table covers",
        ),
    ],
)
def test_conditions_outside_of_the_table_are_refused(table, conditions, line):
    with pytest.raises(InputError) as caught:
        check_conditions(table, conditions)
    assert str(caught.value) == line


def test_ends_of_the_table_are_allowed(table):
    assert check_conditions(table, [(90, 50)]) == [(90.0, 50.0)]
