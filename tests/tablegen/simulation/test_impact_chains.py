"""Chains of impacts: the next impact's frame, and which conditions are taken."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import kstest

from tablegen.config.config import load_config
from tablegen.simulation.direct import DirectModel
from tablegen.simulation.impact_chains import (
    HITS,
    WALLS,
    depart,
    effective_speed,
    first_impacts,
    meet,
    next_impacts,
    occurring_impacts,
    speeds_measured,
)

CONFIG = load_config("corundum-steel")
SLOW = CONFIG.with_changes({"domain": {"speed": [5.0, 300.0], "extrapolate": True}})
MODEL = DirectModel(CONFIG)
INDEX = np.arange(400, dtype=np.uint64)


class TestNextImpact:
    """Turned to the axes of the next wall, a particle flies and spins as it did."""

    @pytest.fixture(scope="class")
    @classmethod
    def departures(cls):
        alpha = np.radians(np.linspace(0.5, 90.0, len(INDEX)))
        start = first_impacts(alpha, np.full(len(INDEX), 200.0), MODEL.grains(3, INDEX), INDEX)
        return depart(MODEL, start, 3)

    def frames(self, departures, there, mirrored=False):
        """Axes of the next walls, rows of matrices, in those of the wall that was left.

        Found from the velocities and spins, which turn alike. Also the direction of motion before.
        """
        _, states, inertia, _ = departures
        speed = np.linalg.norm(states[:, :3], axis=1)
        np.testing.assert_allclose(there.speed, 200.0 * speed, rtol=1e-12)
        np.testing.assert_array_equal(there.hit, 1)
        np.testing.assert_array_equal(there.grain, departures.impacts.grain)
        np.testing.assert_array_equal(there.inertia, inertia)
        size = np.linalg.norm(states[:, 3:], axis=1) / speed
        np.testing.assert_allclose(np.linalg.norm(there.spin, axis=1), size, rtol=1e-12)
        cosine, sine = np.cos(there.alpha1), np.sin(there.alpha1)
        towards = np.column_stack([cosine, -sine, np.zeros(len(sine))])
        left = states[:, :3] / speed[:, None] * ([1.0, -1.0, 1.0] if mirrored else 1.0)
        frames = []
        for k, spin in enumerate(states[:, 3:] / speed[:, None]):
            now, before = (towards[k], there.spin[k] / size[k]), (left[k], spin / size[k])
            turn, off = Rotation.align_vectors(now, before)
            assert off < 1e-6
            frames.append(turn.as_matrix())
        return np.array(frames), left

    @pytest.mark.parametrize("walls", WALLS)
    def test_is_that_of_the_lab_frame(self, departures, walls):
        uniform = np.random.default_rng(1).random((len(INDEX), 2))
        number = np.full(len(INDEX), WALLS.index(walls))
        there = next_impacts(departures, number, uniform)
        frames, left = self.frames(departures, there, walls == "same")
        normal, up = frames[:, 1], np.array([0.0, 1.0, 0.0])
        if walls in ("same", "opposite"):
            side = 1.0 if walls == "same" else -1.0
            np.testing.assert_allclose(normal, np.tile(side * up, (len(INDEX), 1)), atol=1e-7)
        elif walls == "corner":
            np.testing.assert_allclose(normal @ up, 0.0, atol=1e-7)
            np.testing.assert_allclose(np.cross(normal, left) @ up, 0.0, atol=1e-7)
        else:
            angles = np.radians(5.0 + 80.0 * uniform[:, 0])
            np.testing.assert_allclose(there.alpha1, angles, atol=1e-9)
            # isotropic about the direction: false-alarm rate 1e-6
            along = normal + np.sin(angles)[:, None] * left
            side = along @ up / np.cos(angles) / np.linalg.norm(np.cross(left, up), axis=1)
            assert kstest(np.arccos(np.clip(side, -1, 1)), "uniform", (0, np.pi)).pvalue > 1e-6

    def test_walls_are_met_at_given_angles(self, departures):
        alpha = np.radians(np.linspace(0.5, 90.0, len(INDEX)))
        there = meet(departures, alpha, np.full(len(INDEX), 0.3))
        np.testing.assert_array_equal(there.alpha1, alpha)
        self.frames(departures, there)


class TestOccurring:
    def test_are_within_the_table_and_of_all_hits(self):
        found = occurring_impacts(SLOW, DirectModel(SLOW), 1, np.arange(2000, dtype=np.uint64))
        assert 0.8 * 2000 < len(found.index) < 2000
        assert (np.diff(found.index.astype(np.int64)) > 0).all()
        assert effective_speed(found).min() >= 5.0
        assert (found.speed < 5.0).any()
        assert np.degrees(found.alpha1).min() >= 0.5
        np.testing.assert_array_equal(found.hit + 1, np.array(HITS)[found.index % 5])
        shares = np.bincount(found.hit)[1:] / len(found.index)
        assert np.abs(shares - 0.2).max() < 0.05

    def test_depend_on_the_seed_alone(self):
        one, two = (occurring_impacts(CONFIG, MODEL, 1, INDEX, threads=t) for t in (1, 2))
        np.testing.assert_array_equal(one.spin, two.spin)
        few = occurring_impacts(CONFIG, MODEL, 1, INDEX[:100])
        np.testing.assert_array_equal(few.spin, one.spin[one.index < 100])
        other = occurring_impacts(CONFIG, MODEL, 2, INDEX, threads=1)
        assert not np.isin(other.speed, one.speed).any()


@pytest.mark.parametrize(
    ("domain", "expected"),
    [
        ({"speed": [5.0, 300.0], "extrapolate": True}, (50.0, 300.0)),
        ({"speed": [60.0, 400.0], "extrapolate": True}, (60.0, 300.0)),
        ({"speed": [60.0, 200.0]}, (60.0, 200.0)),
        ({"speed": [5.0, 30.0], "extrapolate": True}, (5.0, 30.0)),
    ],
)
def test_speeds_that_were_measured(domain, expected):
    assert speeds_measured(CONFIG.with_changes({"domain": domain})) == expected
