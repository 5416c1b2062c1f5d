"""The rule of deposits, and the roughness of profiles."""

import math

import numpy as np
import pytest
from refusals import refused

import sampler
from sampler.arguments import MAX_ROUGHNESS

#: Silica on steel: density [kg/m3], moduli [Pa] and Poisson's ratios.
MATERIALS = (2200.0, 7e10, 0.17, 2.1e11, 0.3)


def test_deposits_by_the_normal_speed():
    normal, wall = np.array([0.0, 2.0, 0.0]), np.array([5.0, 1.0, 0.0])
    velocity = wall + np.array([[9.0, -0.49, 1.0], [9.0, -0.51, 1.0], [9.0, 0.2, 1.0], [9, 0, 1]])
    stays = sampler.deposits(velocity, normal, 0.5, wall_velocity=wall)
    np.testing.assert_array_equal(stays, [True, False, False, False])
    assert sampler.deposits(velocity[0] - wall, normal, [0.4, 0.5]).tolist() == [False, True]


def test_the_critical_speed_is_that_of_brach_and_dunn():
    """Computed by hand, k = 4.4157e-12 + 1.3794e-12 1/Pa, E = 4.4038e-07."""
    d = np.array([1e-6, 1e-5])
    speeds = sampler.critical_speed(d, *MATERIALS)
    np.testing.assert_allclose(speeds, (2.0 * 4.4038e-7 / d) ** (10.0 / 7.0), rtol=1e-4)


def test_wrong_arguments_are_refused():
    refused("wall_poisson", sampler.critical_speed, 5e-5, *MATERIALS[:4], [0.7])
    refused("normal", sampler.deposits, [1.0, -1.0, 0.0], [0.0, 0.0, 0.0], 0.5)
    refused("rq", sampler.wall_tilt, [1.0, 2.0], [1.0, 2.0, 3.0], 100.0, 1.0)


def test_results_that_are_no_numbers_are_refused():
    """Arguments may be finite, and their products not."""
    names = "diameter, density, young, poisson, wall_young, wall_poisson"
    line = refused(names, sampler.critical_speed, [5e-5, 1e-320], *MATERIALS)
    assert "at index 1" in line
    names = "omega, diameter, density, viscosity, gas_rotation"
    refused(names, sampler.gas_torque, [1e300, 0.0, 0.0], 1e300, 1.2, 1.8e-5)


def test_no_particles_have_no_results():
    empty = np.empty((0, 3))
    assert sampler.gas_torque(empty, 5e-5, 1.2, 1.8e-5).shape == (0, 3)
    assert sampler.critical_speed(empty[:, 0], *MATERIALS).shape == (0,)
    assert sampler.deposits(empty, [0.0, 1.0, 0.0], 0.1).shape == (0,)


def test_small_particles_meet_flanks_and_large_ones_the_whole_profile():
    """Ra 2, Rq 3, RSm 20 micrometres: flanks of 11.3 degrees, met below 102 micrometres."""
    border = 20.0 / math.sin(math.atan(0.2))
    assert border == pytest.approx(102.0, abs=0.1)
    tilts = sampler.wall_tilt(2e-6, 3e-6, 20e-6, np.array([[1e-6, 101e-6], [103e-6, 1.0]]))
    expected = [[math.atan(0.2)] * 2, [math.atan(0.3)] * 2]
    np.testing.assert_allclose(tilts, expected, rtol=1e-14)


def test_only_the_tilts_of_the_particles_at_hand_count():
    """The whole profile of a cast wall is too steep for a large particle, which is refused."""
    with pytest.raises(sampler.InputError, match=r"got 2, 6, 10, 200, allowed: tilts up to 0.5"):
        sampler.wall_tilt(2.0, 6.0, 10.0, [5.0, 200.0])
    assert sampler.wall_tilt(2.0, 6.0, 10.0, 5.0) == pytest.approx(math.atan(0.4))
    rsm = 2.0 / math.tan(MAX_ROUGHNESS)
    assert sampler.wall_tilt(1.0, 1.0, rsm * (1.0 + 1e-12), 1.0) <= MAX_ROUGHNESS


@pytest.mark.parametrize(
    ("field", "lengths"),
    [
        ("ra", (-1.0, 1.0, 1.0, 1.0)),
        ("rq", ([0.1, 25e-6], [0.1, 1e-6], 1.0, 1.0)),  # no profile has Rq below Ra
        *(("rq", (0.1, rq, 1.0, 1.0)) for rq in (np.nan, "rough")),
        *(("rsm", (0.1, 0.1, rsm, 1.0)) for rsm in (0.0, np.inf)),
        *(("diameter", (0.1, 0.1, 1.0, diameter)) for diameter in (0.0, [1.0, -2.0])),
    ],
)
def test_wrong_lengths_are_refused(field, lengths):
    refused(field, sampler.wall_tilt, *lengths)
