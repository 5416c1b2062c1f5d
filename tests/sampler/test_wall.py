"""Sizes of grains, the rule of deposits, and the roughness of profiles."""

import math

import numpy as np
import pytest
from scipy.spatial import ConvexHull

import sampler
from sampler.arguments import MAX_ROUGHNESS
from tablegen.config.population import Population
from tablegen.model.shapes import place_vertices

D = 50e-6
#: Silica on steel: density [kg/m3], moduli [Pa] and Poisson's ratios.
MATERIALS = (2200.0, 7e10, 0.17, 2.1e11, 0.3)


@pytest.mark.parametrize("shape", [0, 1, 2, 3])
def test_a_grain_has_the_volume_of_the_sphere(shape):
    ratios, corners = (0.7, 0.9), np.zeros((24, 3))
    b, c = ratios[0], ratios[0] * ratios[1]
    n, _ = place_vertices(shape, b, c, Population.model_fields["truncation"].default, corners)
    volume = ConvexHull(corners[:n]).volume if n else 4.0 / 3.0 * np.pi * b * c
    a = sampler.half_size(D, shape, ratios)
    assert volume * a**3 == pytest.approx(np.pi / 6.0 * D**3, rel=1e-12)


def test_names_arrays_and_spheres():
    names = ["ellipsoid", "prism", "truncated-prism", "tetrahedron"]
    found = [float(sampler.half_size(1.0, name, (0.8, 0.8))) for name in names]
    np.testing.assert_allclose(found, [0.62, 0.50, 0.51, 0.73], atol=0.005)
    each = sampler.half_size([1.0, 2.0, 1.0, 1.0], range(4), np.full((4, 2), 0.8))
    np.testing.assert_array_equal(each, np.multiply(found, [1.0, 2.0, 1.0, 1.0]))
    assert sampler.half_size(D, "sphere", (1.0, 1.0)) == pytest.approx(D / 2)


def test_the_mean_is_that_of_the_grains():
    """The sample of 1e5 has a standard error of 0.0004; 4 of them: 6e-5 false alarms."""
    table = sampler.load("corundum-steel-compact")
    grains = table.grains(7, np.arange(100_000))
    each = sampler.half_size(1.0, grains[:, 0], grains[:, 1:])
    assert float(table.mean_half_size(D)) == pytest.approx(D * each.mean(), rel=0.0025)


def test_a_population_that_is_not_known_has_no_mean(table):
    with pytest.raises(sampler.InputError, match=r"^mean_half_size: this table has no spin law"):
        table.mean_half_size(D)


def test_deposits_by_the_normal_speed():
    normal, wall = np.array([0.0, 2.0, 0.0]), np.array([5.0, 1.0, 0.0])
    velocity = wall + np.array([[9.0, -0.49, 1.0], [9.0, -0.51, 1.0], [9.0, 0.2, 1.0], [9, 0, 1]])
    found = sampler.deposits(velocity, normal, 0.5, wall_velocity=wall)
    np.testing.assert_array_equal(found, [True, False, False, False])
    assert sampler.deposits(velocity[0] - wall, normal, [0.4, 0.5]).tolist() == [False, True]


def test_the_critical_speed_is_that_of_brach_and_dunn():
    """Computed by hand, k = 4.4157e-12 + 1.3794e-12 1/Pa, E = 4.4038e-07."""
    d = np.array([1e-6, 1e-5])
    speeds = sampler.critical_speed(d, *MATERIALS)
    np.testing.assert_allclose(speeds, (2.0 * 4.4038e-7 / d) ** (10.0 / 7.0), rtol=1e-4)


def test_wrong_arguments_are_refused():
    for arguments, message in (
        ((D, "mesh", (0.8, 0.8)), r"^shape: got mesh, allowed: 0 ellipsoid, 1 prism"),
        ((D, [1, 6], (0.8, 0.8)), r"^shape: got 6, allowed: 0"),
        ((D, 1, (0.8, 1.2)), r"^ratios: got 1.2, allowed: b/a and c/b, above 0"),
        ((D, 1, (0.8,)), r"^ratios: got shape \(1,\), allowed: \(2,\) or \(..., 2\)"),
        ((-1.0, 1, (0.8, 0.8)), r"^diameter: got -1, allowed: a finite number above 0"),
    ):
        with pytest.raises(sampler.InputError, match=message):
            sampler.half_size(*arguments)
    with pytest.raises(sampler.InputError, match=r"^wall_poisson: got 0.7 at index 0, allowed: 0"):
        sampler.critical_speed(D, 2200.0, 7e10, 0.17, 2.1e11, [0.7])
    with pytest.raises(sampler.InputError, match=r"^normal: got a vector of length zero, allowed"):
        sampler.deposits([1.0, -1.0, 0.0], [0.0, 0.0, 0.0], 0.5)


def test_small_particles_meet_flanks_and_large_ones_the_whole_profile():
    """Ra 2, Rq 3, RSm 20 micrometres: flanks of 11.3 degrees, met below 102 micrometres."""
    border = 20.0 / math.sin(math.atan(0.2))
    assert border == pytest.approx(102.0, abs=0.1)
    tilts = sampler.wall_tilt(2e-6, 3e-6, 20e-6, np.array([[1e-6, 101e-6], [103e-6, 1.0]]))
    expected = [[math.atan(0.2)] * 2, [math.atan(0.3)] * 2]
    np.testing.assert_allclose(tilts, expected, rtol=1e-14)


def test_only_the_tilts_of_the_particles_at_hand_count():
    """The flanks of a cast wall are too steep for a small particle, which is refused."""
    with pytest.raises(sampler.InputError, match=r"got 25, 1, 10, 5, allowed: tilts up to 0.5 rad"):
        sampler.wall_tilt(25.0, 1.0, 10.0, [200.0, 5.0])
    rsm = 2.0 / math.tan(MAX_ROUGHNESS)
    assert sampler.wall_tilt(1.0, 1.0, rsm * (1.0 + 1e-12), 1.0) <= MAX_ROUGHNESS


@pytest.mark.parametrize(
    ("lengths", "message"),
    [
        ((-1.0, 1.0, 1.0, 1.0), r"ra: got -1, allowed: a finite number, 0 or more"),
        ((0.1, np.nan, 1.0, 1.0), r"rq: got nan, allowed: a finite number, 0 or more"),
        ((0.1, 0.1, 0.0, 1.0), r"rsm: got 0, allowed: a finite number above 0"),
        ((0.1, 0.1, np.inf, 1.0), r"rsm: got inf, allowed"),
        ((0.1, 0.1, 1.0, 0.0), r"diameter: got 0, allowed: a finite number above 0"),
        ((0.1, 0.1, 1.0, [1.0, -2.0]), r"diameter: got -2 at index 1, allowed"),
        ((0.1, "rough", 1.0, 1.0), r"rq: got str\w* values, allowed: real numbers"),
    ],
)
def test_wrong_lengths_are_refused(lengths, message):
    with pytest.raises(sampler.InputError, match=f"^{message}"):
        sampler.wall_tilt(*lengths)
