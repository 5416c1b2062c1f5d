"""Direct rebounds from rough walls: the runtime's facets, spin and grain kept, no energy gained."""

from functools import cache

import numpy as np
import pytest
from refusals import refused
from rough_wall import facets, seed_of_bounce

import sampler
from sampler.arguments import MAX_ROUGHNESS
from tablegen.config.config import load_config
from tablegen.simulation.direct import DirectModel, model_without_warnings

UP, HALF_SIZE, N = np.array([0.0, 1.0, 0.0]), 1e-5, 400
IDS = np.arange(N)
VELOCITY = np.array([120.0, -90.0, 0.0])
OMEGA = np.array([1e5, -2e5, -4e6])


@cache
def model():
    """Model of the shipped pair; made by the first test, which may have to compile it."""
    return model_without_warnings(load_config("corundum-steel"))


@pytest.mark.parametrize("isotropic", [False, True])
def test_draws_from_the_table_meet_the_same_facets(isotropic):
    """Of spheres, whose rebounds are those of the direct model to the last digits."""
    velocity, omega = np.array([3.0, -2.0, 0.5]), np.array([1e3, -2e3, 5e3])
    keys = {"seed": 5, "index": np.arange(5000), "hit": 0}
    keys |= {"roughness": 0.3, "isotropic": isotropic}
    walls = DirectModel(load_config("kharaz-2001")), sampler.load("kharaz-2001")
    direct, drawn = (wall.rebound(velocity, UP, 1e-3, omega=omega, **keys) for wall in walls)
    np.testing.assert_allclose(drawn.velocity, direct.velocity, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(drawn.omega, direct.omega, rtol=1e-12, atol=1e-9)


@pytest.mark.parametrize("isotropic", [False, True])
def test_bounces_are_smooth_ones_from_facets_with_spin_grain_and_inertia_kept(isotropic):
    """Each bounce again from a smooth wall, the facet of the reference in plain Python."""
    velocity = np.array([20.0, -140.0, 0.0])  # one in five hits again
    keys = {"seed": 3, "index": IDS, "hit": 2, "roughness": 0.5, "isotropic": isotropic}
    rebounds = model().rebound(velocity, UP, HALF_SIZE, omega=OMEGA, **keys)
    grains = model().grains(3, IDS)

    def bounced(keeps):
        moving, omega = np.tile(velocity, (N, 1)), np.tile(OMEGA, (N, 1))
        inertia, rows, bounces = np.zeros(N), IDS, 0
        while len(rows):
            key = seed_of_bounce(3, bounces)
            moving[rows], omega[rows], inertia[rows] = model().rebound(
                moving[rows],
                facets(moving[rows], key, 0.5, isotropic, rows, hit=2),
                HALF_SIZE,
                omega=omega[rows],
                grain=grains[rows],
                inertia=inertia[rows] if keeps else None,
                seed=key,
                index=rows,
                hit=2,
            )
            rows, bounces = rows[moving[rows, 1] <= 0.0], bounces + 1
        assert bounces > 2
        return moving, omega, inertia

    # the facets above were put together by other formulas
    for part, expected, most in zip(rebounds, bounced(True), (1e-6, 10.0, 1e-6), strict=True):
        np.testing.assert_allclose(part, expected, rtol=1e-6, atol=most)
    assert np.abs(rebounds.velocity - bounced(False)[0]).max() > 1.0


def same(one, other):
    for part, expected in zip(one, other, strict=True):
        np.testing.assert_array_equal(part, expected)


def test_no_roughness_is_the_smooth_wall():
    keys = {"omega": OMEGA, "seed": 3, "index": IDS, "hit": 1}
    for grain in ("own", "fresh", (1.0, 0.8, 0.7)):
        smooth = model().rebound(VELOCITY, UP, HALF_SIZE, grain=grain, **keys)
        zero = model().rebound(VELOCITY, UP, HALF_SIZE, grain=grain, roughness=0.0, **keys)
        same(smooth, zero)
    moving = model().rebound(VELOCITY + 7.0, UP, HALF_SIZE, wall_velocity=[7.0] * 3, **keys)
    rough = {"wall_velocity": [7.0] * 3, "roughness": 0.0}
    rebounds = model().rebound(VELOCITY + 7.0, UP, HALF_SIZE, **rough, **keys)
    same(moving, rebounds)


def test_results_do_not_depend_on_threads_or_batches():
    rng = np.random.default_rng(1)
    n = 6_000  # two batches
    roughness = rng.uniform(0.0, MAX_ROUGHNESS, n)
    keys = {"seed": 9, "index": np.arange(n)}
    one = model().rebound(VELOCITY, UP, HALF_SIZE, roughness=roughness, threads=1, **keys)
    two = model().rebound(VELOCITY, UP, HALF_SIZE, roughness=roughness, threads=2, **keys)
    same(one, two)
    single = model().rebound(VELOCITY, UP, HALF_SIZE, roughness=roughness[5500], seed=9, index=5500)
    same([part[5500] for part in one], single)


def test_bad_input_is_refused():
    impact, keys = (VELOCITY, UP, HALF_SIZE), {"seed": 1, "index": [0, 1]}
    for roughness in (-0.1, 0.51, np.nan):
        refused("roughness", model().rebound, *impact, roughness=[0.1, roughness], **keys)
    refused("velocity", model().rebound, -VELOCITY, UP, HALF_SIZE, roughness=0.1, **keys)
