"""Direct rebounds from rough walls: the runtime's facets, spin and grain kept, no energy gained."""

import numpy as np
import pytest

import sampler
from sampler.arguments import MAX_ROUGHNESS
from sampler.errors import InputError
from tablegen.config.config import load_config
from tablegen.model.roughness import draw_tilt, seed_of_bounce
from tablegen.simulation.direct import DirectModel

MODEL = DirectModel(load_config("corundum-steel"))
UP, HALF_SIZE, N = np.array([0.0, 1.0, 0.0]), 1e-5, 400
IDS = np.arange(N)
VELOCITY = np.array([120.0, -90.0, 0.0])
OMEGA = np.array([1e5, -2e5, -4e6])


def facets(velocity, seed, roughness, index=IDS, hit=0):
    """Normals of the facets that particles with the velocities (n, 3) meet, in the xy plane."""
    alpha = np.arctan2(-velocity[:, 1], np.hypot(velocity[:, 0], velocity[:, 2]))
    tilts = [draw_tilt(a, roughness, (seed, i, hit)) for a, i in zip(alpha, index, strict=True)]
    assert all(found for found, _ in tilts)
    tilt = np.array([t for _, t in tilts])
    along = velocity * [1.0, 0.0, 1.0]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    return np.cos(tilt)[:, None] * UP - np.sin(tilt)[:, None] * along


def test_bounces_are_smooth_ones_from_facets_with_spin_grain_and_orientation_kept():
    """Each bounce again by the smooth model, from the facets of the runtime's own function."""
    velocity = np.array([20.0, -140.0, 0.0])  # one in five hits again
    found = MODEL.rebound(
        velocity, UP, HALF_SIZE, omega=OMEGA, seed=3, index=IDS, hit=2, roughness=0.5
    )
    grains = MODEL.grains(3, IDS)

    def bounced(keeps):
        moving, omega = np.tile(velocity, (N, 1)), np.tile(OMEGA, (N, 1))
        turned, rows, bounces = np.zeros((N, 4)), IDS, 0
        while len(rows):
            key = np.uint64(seed_of_bounce(3, bounces))
            moving[rows], omega[rows], turned[rows] = MODEL.rebound(
                moving[rows],
                facets(moving[rows], key, 0.5, rows, hit=2),
                HALF_SIZE,
                omega=omega[rows],
                grain=grains[rows],
                orientation=turned[rows] if bounces and keeps else None,
                seed=key,
                index=rows,
                hit=2,
            )
            rows, bounces = rows[moving[rows, 1] <= 0.0], bounces + 1
        assert bounces > 2
        return moving, omega, turned

    # the facets above were put together by other formulas
    for part, expected, most in zip(found, bounced(True), (1e-6, 10.0, 1e-6), strict=True):
        np.testing.assert_allclose(part, expected, rtol=1e-6, atol=most)
    assert np.abs(found.velocity - bounced(False)[0]).max() > 1.0


def test_no_roughness_is_the_smooth_wall():
    keys = {"omega": OMEGA, "seed": 3, "index": IDS, "hit": 1}
    for grain in ("own", "fresh", (1.0, 0.8, 0.7)):
        smooth = MODEL.rebound(VELOCITY, UP, HALF_SIZE, grain=grain, **keys)
        zero = MODEL.rebound(VELOCITY, UP, HALF_SIZE, grain=grain, roughness=0.0, **keys)
        np.testing.assert_array_equal(np.hstack(smooth), np.hstack(zero))
    moving = MODEL.rebound(VELOCITY + 7.0, UP, HALF_SIZE, wall_velocity=[7.0] * 3, **keys)
    rough = {"wall_velocity": [7.0] * 3, "roughness": 0.0}
    found = MODEL.rebound(VELOCITY + 7.0, UP, HALF_SIZE, **rough, **keys)
    np.testing.assert_array_equal(np.hstack(moving), np.hstack(found))


def test_table_and_direct_model_agree_on_a_rough_wall():
    """Means and spreads within five standard errors and the table's own error, 0.01 V.

    A smooth wall instead is refused.
    """
    n, roughness = 20_000, 0.3
    keys = {"seed": 5, "index": np.arange(n), "roughness": roughness}
    still = np.zeros(3)
    direct = MODEL.rebound(VELOCITY, UP, HALF_SIZE, omega=still, **keys)
    table = sampler.load("corundum-steel").rebound(VELOCITY, UP, HALF_SIZE, omega=still, **keys)
    smooth = MODEL.rebound(VELOCITY, UP, HALF_SIZE, seed=5, index=np.arange(n))

    def off(a, b):
        return max(np.abs(a.mean(0) - b.mean(0)).max(), np.abs(a.std(0) - b.std(0)).max()) / 150.0

    bound = 0.01 + 5.0 * 0.35 * np.sqrt(2.0 / n)  # no component has a spread above 0.35 V
    assert off(direct.velocity, table.velocity) < bound
    assert off(direct.velocity, smooth.velocity) > bound
    assert (direct.velocity[:, 1] > 0.0).all()
    assert (np.linalg.norm(direct.velocity, axis=1) <= 150.0).all()


def test_results_do_not_depend_on_threads_or_batches():
    rng = np.random.default_rng(1)
    n = 6_000  # two batches
    roughness = rng.uniform(0.0, MAX_ROUGHNESS, n)
    keys = {"seed": 9, "index": np.arange(n)}
    one = MODEL.rebound(VELOCITY, UP, HALF_SIZE, roughness=roughness, threads=1, **keys)
    two = MODEL.rebound(VELOCITY, UP, HALF_SIZE, roughness=roughness, threads=2, **keys)
    np.testing.assert_array_equal(np.hstack(one), np.hstack(two))
    single = MODEL.rebound(VELOCITY, UP, HALF_SIZE, roughness=roughness[5500], seed=9, index=5500)
    np.testing.assert_array_equal(np.hstack(one)[5500], np.hstack(single))


def test_bad_input_is_refused():
    for roughness in (-0.1, 0.51, np.nan):
        with pytest.raises(InputError, match=r"^roughness: got .* index 1, allowed: 0 to 0.5 rad$"):
            MODEL.rebound(VELOCITY, UP, HALF_SIZE, seed=1, index=[0, 1], roughness=[0.1, roughness])
    with pytest.raises(
        InputError, match=r"^velocity: got .* at row 0 \(particle \d+\), allowed: towards"
    ):
        MODEL.rebound(-VELOCITY, UP, HALF_SIZE, seed=1, index=0, roughness=0.1)


def test_a_particle_that_never_leaves_is_named(monkeypatch):
    monkeypatch.setattr("tablegen.simulation.rough_walls.simulate_batch", lambda *arguments: 2)
    with pytest.raises(RuntimeError, match="the particle at index 2 is still in contact"):
        MODEL.rebound(VELOCITY, UP, HALF_SIZE, seed=1, index=IDS, roughness=0.1)
    monkeypatch.undo()
    monkeypatch.setattr("tablegen.simulation.rough_walls.MAX_BOUNCES", 1)
    with pytest.raises(InputError, match=r"^roughness: got .* one that lets the particle leave"):
        MODEL.rebound(VELOCITY, UP, HALF_SIZE, seed=1, index=IDS, roughness=0.4)
