"""Chains of impacts: a particle flies and spins to the next wall as it left the last one."""

from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import kstest
from spin_laws import effective_speed, tilted_departures

from tablegen.config.config import load_config
from tablegen.model.model_bounds import MOST_TURNED
from tablegen.simulation.direct import model_without_warnings
from tablegen.simulation.direct_law import DirectLaw
from tablegen.simulation.impact_chains import (
    ANY_WALL,
    OPPOSITE_WALL,
    SAME_WALL,
    energy_factor,
    first_impacts,
    join_impacts,
    next_impacts,
    raise_to_limits,
    simulate_departures,
)

CONFIG = load_config("corundum-steel")
INDEX = np.arange(400, dtype=np.uint64)


@cache
def law():
    """Law of the shipped pair; made by the first test, which may have to compile it."""
    return DirectLaw.from_config(CONFIG)


def grains():
    return model_without_warnings(CONFIG).grains(3, INDEX)


@pytest.fixture(scope="module")
def departures():
    alpha = np.radians(np.linspace(0.5, 90.0, len(INDEX)))
    start = first_impacts(alpha, np.full(len(INDEX), 200.0), grains(), INDEX)
    return simulate_departures(law(), start, 3)


def frames_of(departures, impacts, reflected):
    """Axes of the next walls, rows of matrices, in those of the wall that was left.

    Found from the velocities and spins, which turn alike. Also the direction of motion before.
    """
    _, states, inertia, _ = departures
    speed = np.linalg.norm(states[:, :3], axis=1)
    np.testing.assert_allclose(impacts.speed, 200.0 * speed, rtol=1e-12)
    np.testing.assert_array_equal(impacts.hit, 1)
    np.testing.assert_array_equal(impacts.grain, departures.impacts.grain)
    np.testing.assert_array_equal(impacts.inertia, inertia)
    size = np.linalg.norm(states[:, 3:], axis=1) / speed
    np.testing.assert_allclose(np.linalg.norm(impacts.spin, axis=1), size, rtol=1e-12)
    cosine, sine = np.cos(impacts.alpha1), np.sin(impacts.alpha1)
    towards = np.column_stack([cosine, -sine, np.zeros(len(sine))])
    left = states[:, :3] / speed[:, None] * ([1.0, -1.0, 1.0] if reflected else 1.0)
    frames = []
    for k, spin in enumerate(states[:, 3:] / speed[:, None]):
        now, before = (towards[k], impacts.spin[k] / size[k]), (left[k], spin / size[k])
        turn, off = Rotation.align_vectors(now, before)
        assert off < 1e-6
        frames.append(turn.as_matrix())
    return np.array(frames), left


@pytest.mark.parametrize("wall", [SAME_WALL, OPPOSITE_WALL, ANY_WALL])
def test_the_next_impact_is_that_of_the_lab_frame(departures, wall):
    uniform = np.random.default_rng(1).random((len(INDEX), 2))
    impacts = next_impacts(departures, np.full(len(INDEX), wall), uniform)
    frames, left = frames_of(departures, impacts, wall == SAME_WALL)
    normal, up = frames[:, 1], np.array([0.0, 1.0, 0.0])
    if wall != ANY_WALL:
        towards = up if wall == SAME_WALL else -up
        np.testing.assert_allclose(normal, np.tile(towards, (len(INDEX), 1)), atol=1e-7)
        return
    angles = np.radians(5.0 + 80.0 * uniform[:, 0])
    np.testing.assert_allclose(impacts.alpha1, angles, atol=1e-9)
    # isotropic about the direction: false-alarm rate 1e-6
    along = normal + np.sin(angles)[:, None] * left
    side = along @ up / np.cos(angles) / np.linalg.norm(np.cross(left, up), axis=1)
    assert kstest(np.arccos(np.clip(side, -1, 1)), "uniform", (0, np.pi)).pvalue > 1e-6


def test_a_particle_that_leaves_along_the_normal_meets_its_wall_head_on(departures):
    states = departures.states * [0.0, 1.0, 0.0, 1.0, 1.0, 1.0]
    same_wall, uniform = np.full(len(INDEX), SAME_WALL), np.zeros((len(INDEX), 2))
    impacts = next_impacts(departures._replace(states=states), same_wall, uniform)
    np.testing.assert_array_equal(impacts.alpha1, 0.5 * np.pi)
    size = np.linalg.norm(states[:, 3:], axis=1) / states[:, 1]
    np.testing.assert_allclose(np.linalg.norm(impacts.spin, axis=1), size, rtol=1e-12)


def test_energies_before_and_after_an_impact_add_up(departures):
    impacts = next_impacts(departures, np.full(len(INDEX), ANY_WALL), np.full((len(INDEX), 2), 0.3))
    left = simulate_departures(law(), impacts, 3)
    before = energy_factor(impacts.spin, impacts.inertia) ** 2
    after = np.sum(left.states[:, :3] ** 2, axis=1)
    after += left.inertia * np.sum(left.states[:, 3:] ** 2, axis=1)
    np.testing.assert_allclose(after + left.works.sum(axis=1), before, rtol=1e-6)
    energy = 0.5 * (200.0 * departures.states[:, :3]) ** 2
    whole = np.sum(energy, axis=1) + 0.5 * 200.0**2 * departures.inertia * np.sum(
        departures.states[:, 3:] ** 2, axis=1
    )
    np.testing.assert_allclose(0.5 * effective_speed(impacts) ** 2, whole, rtol=1e-9)


def test_the_direct_model_simulates_possible_impacts():
    grain = grains()
    impacts = first_impacts(np.full(400, 1e-4), np.full(400, 1e-12), grain, INDEX)
    impacts = impacts._replace(spin=np.geomspace(1e-3, 900.0, 1200).reshape(400, 3))
    raised = raise_to_limits(impacts)
    turned = 2.0 * np.linalg.norm(raised.spin, axis=1) / np.sin(raised.alpha1)
    assert turned.max() < MOST_TURNED
    assert np.isfinite(simulate_departures(law(), raised, 3).states).all()
    # impacts that can be simulated stay as they are
    usual = first_impacts(np.full(400, 0.5), np.full(400, 100.0), grain, INDEX)
    for one, two in zip(usual, raise_to_limits(usual), strict=True):
        np.testing.assert_array_equal(one, two)


def test_impacts_are_selected_and_joined():
    grain = grains()
    impacts = first_impacts(np.linspace(0.1, 1.0, 400), np.full(400, 100.0), grain, INDEX)
    parts = [impacts.select(slice(0, 100)), impacts.select(np.arange(100, 400))]
    for one, two in zip(join_impacts(parts), impacts, strict=True):
        np.testing.assert_array_equal(one, two)


def sizes_across(code, tilt):
    """Median sizes of w, omega_x and omega_y of grains that arrive with a tilted spin."""
    departures, _ = tilted_departures(CONFIG, code, tilt)
    return np.median(np.abs(departures.states[:, 2:5]), axis=0)


def test_ellipsoids_leave_the_plane_of_the_impact_in_proportion_to_the_tilt_of_their_spin():
    """It is a mirror of a grain that turns about its shortest axis; edges of prisms break it."""
    np.testing.assert_allclose(sizes_across(0, 0.0), 0.0, atol=1e-12)
    near, far = sizes_across(0, 0.003), sizes_across(0, 0.06)
    np.testing.assert_allclose(far / near, 20.0, rtol=0.05)
    assert (sizes_across(1, 0.06) / sizes_across(1, 0.003) < 2.0).all()
