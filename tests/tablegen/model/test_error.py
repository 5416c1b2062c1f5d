"""Numerical parameters: the errors that they leave.

Two settings are compared on the same particles, so the differences below hold no sampling noise.
"""

import numpy as np
import pytest
from motion_fixtures import PAIR, POPULATION

from tablegen.simulation.simulate import (
    CONTACT_RESOLUTION,
    TOLERANCE,
    make_condition,
    simulate_condition,
)

COUNT = 30_000

#: Ellipsoids near normal impact have the longest chains of small bounces.
CASES = [("ellipsoid", 90.0), ("ellipsoid", 60.0), ("tetrahedron", 90.0), ("mixture", 45.0)]


def run(shape, alpha_deg, resolution=CONTACT_RESOLUTION, tolerance=TOLERANCE):
    condition = make_condition(
        np.radians(alpha_deg), 200.0, resolution=resolution, tolerance=tolerance
    )
    return simulate_condition(PAIR, POPULATION.restricted_to(shape), condition, COUNT, seed=51)


def mean_change(one, other):
    return np.abs(one.state.mean(axis=0) - other.state.mean(axis=0)).max()


def largest_change(one, other):
    """Largest change of each particle's state, (n,)."""
    return np.abs(one.state - other.state).max(axis=1)


@pytest.mark.parametrize(("shape", "alpha_deg"), CASES)
def test_contact_resolution_leaves_little(shape, alpha_deg):
    default, fine = run(shape, alpha_deg), run(shape, alpha_deg, resolution=1e-4)
    assert mean_change(default, fine) < 5e-5
    change = largest_change(default, fine)
    # only particles in sustained contact feel it, and those by some resolutions
    assert np.mean(change > 1e-6) < 0.05
    assert change.max() < 30.0 * CONTACT_RESOLUTION


def test_contact_resolution_converges_at_first_order():
    coarse, middle, fine = (run("ellipsoid", 90.0, resolution=r) for r in (1e-2, 1e-3, 1e-4))
    ratio = np.mean(largest_change(coarse, middle)) / np.mean(largest_change(middle, fine))
    assert 4.0 < ratio < 40.0


def test_a_coarse_contact_resolution_is_seen():
    # the comparison of means is able to fail: a resolution of 0.1 is too coarse
    default = run("ellipsoid", 90.0)
    assert mean_change(default, run("ellipsoid", 90.0, resolution=0.1)) > 5e-4


@pytest.mark.parametrize(("shape", "alpha_deg"), CASES)
def test_flight_tolerance_leaves_nothing(shape, alpha_deg):
    default, fine = run(shape, alpha_deg), run(shape, alpha_deg, tolerance=1e-13)
    assert mean_change(default, fine) < 1e-10
    assert largest_change(default, fine).max() < 1e-6
    np.testing.assert_array_equal(default.collisions, fine.collisions)


def test_a_coarse_flight_tolerance_is_seen():
    default, coarse = run("mixture", 45.0), run("mixture", 45.0, tolerance=1e-4)
    assert mean_change(default, coarse) > 1e-10
    assert largest_change(default, coarse).max() > 1e-6


@pytest.mark.parametrize("alpha_deg", [0.01, 0.05, 0.5])
def test_a_grazing_sphere_rebounds_by_the_law(alpha_deg):
    # one collision of a sphere: v+ = a_nc sin(alpha1), far below the resolution at 0.01 degrees
    condition = make_condition(np.radians(alpha_deg), 200.0)
    made = simulate_condition(PAIR, POPULATION.restricted_to("sphere"), condition, 10, seed=52)
    sine = np.sin(np.radians(alpha_deg))
    a_nc = 1.0 + np.expm1(-0.1 * 200.0**0.61) * sine
    np.testing.assert_allclose(made.state[:, 1], a_nc * sine, rtol=1e-12)
    assert 0.5 * sine < CONTACT_RESOLUTION or alpha_deg == 0.5
