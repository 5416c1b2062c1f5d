"""Where accuracy is measured: evenly over angle, speed and spin, never at a node."""

from types import SimpleNamespace

import numpy as np
import pytest
from grids import grid_table
from scipy.stats import kstest

from sampler.errors import InputError
from tablegen.accuracy.conditions import (
    Place,
    check_conditions,
    pick_conditions,
    pick_spin_conditions,
)
from tablegen.config.config import load_config

CONFIG = load_config("corundum-steel")


@pytest.fixture(scope="module")
def table():
    return grid_table([1.0, 2.0, 30.0, 90.0], [50.0, 90.0, 100.0, 200.0, 300.0])


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
    """Not over the numbers of the nodes: two thirds of these cells lie below 30 degrees."""
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
    spinning = pick_spin_conditions(CONFIG, 5, 1)
    assert spinning == sorted(spinning) == pick_spin_conditions(CONFIG, 5, 1)
    assert spinning != pick_spin_conditions(CONFIG, 5, 2)


def test_axis_of_one_node_has_only_that():
    alpha, speed = picked(grid_table([40.0], [50.0, 300.0]), 4, 1)
    assert alpha.tolist() == [40.0] * 4
    assert len(set(speed)) == 4


def spinning_columns(config, count, seed):
    return np.array(
        [(c.alpha_deg, c.speed, *c.spin) for c in pick_spin_conditions(config, count, seed)]
    )


def test_spinning_conditions_are_even_over_angle_speed_size_and_direction():
    """A Latin hypercube is closer to even than chance: KS of 1 / n at most, and rounding."""
    found, most = spinning_columns(CONFIG, 200, 7), 1 / 200 + 1e-12
    size = np.linalg.norm(found[:, 2:], axis=1)
    turn = np.arctan2(found[:, 4], found[:, 2]) % (2.0 * np.pi)
    for values, low, width in (
        (found[:, 0], 5.0, 80.0),
        (found[:, 1], 50.0, 250.0),
        (size, 0.0, 2.0),
        (found[:, 3] / size, -1.0, 2.0),
        (turn, 0.0, 2.0 * np.pi),
    ):
        assert kstest(values, "uniform", (low, width)).statistic <= most


def test_spinning_conditions_stay_within_the_table():
    domain = {"alpha_deg": [20.0, 89.0], "speed": [5.0, 120.0], "extrapolate": True}
    found = spinning_columns(CONFIG.with_changes({"domain": domain}), 50, 1)
    assert 20.0 <= found[:, 0].min() <= found[:, 0].max() <= 85.0
    assert 50.0 <= found[:, 1].min() <= found[:, 1].max() <= 120.0


#: A table with a spin law, as far as the check of conditions looks at it.
SPINNING = SimpleNamespace(
    has_spin=True,
    contents={"spin/alpha_range_deg": np.array([0.5, 90.0]), "spin/speed_range": [50.0, 600.0]},
)


@pytest.mark.parametrize(
    ("place", "line"),
    [
        (Place(0.5, 100.0), "alpha: got 0.5 degrees, allowed: 1 to 90 degrees"),
        (Place(90.0000001, 100.0), "alpha: got 90.0000001 degrees, allowed: 1 to 90 degrees"),
        (Place(30.0, 310.0), "speed: got 310 m/s, allowed: 50 to 300 m/s, which the table"),
        (Place(float("nan"), 100.0), "alpha: got nan degrees, allowed: 1 to 90 degrees"),
        (Place(0.1, 100.0, (0, 0, 1)), "alpha: got 0.1 degrees, allowed: 0.5 to 90 degrees"),
        (Place(45.0, 30.0, (0, 0, 0)), "speed with the spin's energy: got 30 m/s, allowed: 50 to"),
        (Place(45.0, 100.0, (0, np.nan, 0)), "spin: got (0, nan, 0), allowed: three finite"),
        (Place(45.0, 100.0, (0, 0)), "spin: got (0, 0), allowed: three finite numbers"),
    ],
)
def test_conditions_outside_of_the_table_are_refused(table, place, line):
    with pytest.raises(InputError) as caught:
        check_conditions(SPINNING if place.spin else table, [place])
    assert str(caught.value).startswith(line)


def test_ends_of_the_table_are_allowed(table):
    assert check_conditions(table, [Place(90, 50)]) == [(90.0, 50.0, None)]
    # a slow particle that spins fast has the energy
    assert check_conditions(SPINNING, [Place(45.0, 30.0, (0.0, 0.0, -2.0))])
    with pytest.raises(InputError, match="at: got no condition, allowed: one or more"):
        check_conditions(table, [])
