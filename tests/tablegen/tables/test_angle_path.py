"""The coordinate between two angles follows the means of rebounds, in units of their spreads."""

import numpy as np
import pytest

from tablegen.config.config import load_config
from tablegen.simulation.simulate import simulate
from tablegen.tables.angle_path import path_index

ROUND = load_config("forder-1998").with_changes(
    {
        "population": {
            "aspect": {
                "distribution": "truncated-normal",
                "mean": 0.95,
                "standard_deviation": 0.05,
                "range": [0.5, 1.0],
            }
        }
    }
)

#: Angles [degrees] of two nodes, and one between them.
LOW, MIDDLE, HIGH = 75.0, 83.0, 90.0


def tangential(alpha_deg):
    """Mean and spread of u at an angle, from particles of another stream than the path's."""
    state = simulate(ROUND, np.radians(alpha_deg), 100.0, 20_000, seed=5, threads=1).state
    return state[:, 0].mean(), state[:, 0].std()


def test_narrow_variables_have_the_right_mean_between_nodes():
    (low, _), (mean, spread), (high, _) = (tangential(a) for a in (LOW, MIDDLE, HIGH - 1e-3))
    t = float(np.interp(MIDDLE, *path_index(ROUND, np.array([LOW, HIGH]))))
    assert (1.0 - t) * low + t * high == pytest.approx(mean, abs=0.3 * spread)
    # Refused: weights that follow the square root of the angle.
    r = (np.sqrt(MIDDLE) - np.sqrt(LOW)) / (np.sqrt(HIGH) - np.sqrt(LOW))
    assert abs((1.0 - r) * low + r * high - mean) > 2.0 * spread


def test_a_cell_is_the_same_in_every_grid():
    whole = path_index(ROUND, np.array([10.0, 30.0, 60.0]))
    part = path_index(ROUND, np.array([30.0, 60.0]))
    angles = np.linspace(30.0, 60.0, 20)
    np.testing.assert_allclose(
        np.interp(angles, *whole), 1.0 + np.interp(angles, *part), rtol=1e-12
    )


@pytest.mark.parametrize("nodes", [[0.05, 90.0], [40.0, 40.1, 90.0], [1e-6, 1e-5, 1.0]])
def test_index_grows_and_is_whole_at_nodes(nodes):
    angles, index = path_index(ROUND, np.array(nodes))
    assert (np.diff(angles) > 0.0).all()
    assert (np.diff(index) > 0.0).all()
    np.testing.assert_array_equal(np.interp(nodes, angles, index), range(len(nodes)))


def test_one_angle_has_one_index():
    angles, index = path_index(ROUND, np.array([35.0]))
    assert (angles.tolist(), index.tolist()) == ([35.0], [0.0])
