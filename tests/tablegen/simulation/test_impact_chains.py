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
    """Turned to the axes of the next wall, a particle flies, spins and lies as it did."""

    @pytest.fixture(scope="class")
    @classmethod
    def departures(cls):
        alpha = np.radians(np.linspace(0.5, 90.0, len(INDEX)))
        start = first_impacts(alpha, np.full(len(INDEX), 200.0), MODEL.grains(3, INDEX), INDEX)
        return depart(MODEL, start, 3)

    def frames(self, departures, there, flight):
        """Axes of the next walls, rows of matrices, in those of the wall that was left."""
        _, states, orientation, _ = departures
        speed, omega = np.linalg.norm(states[:, :3], axis=1), states[:, 3:]
        turned, _ = MODEL.tumble(
            orientation, omega, departures.impacts.grain, 1.0, (5.0 + 10.0 * flight) / speed
        )
        before, after = (
            Rotation.from_quat(q, scalar_first=True) for q in (turned, there.orientation)
        )
        frames = (after * before.inv()).as_matrix()
        spin = np.einsum("nij,nj->ni", frames, omega / speed[:, None])
        np.testing.assert_allclose(there.spin, spin, atol=1e-9 * np.abs(spin).max())
        np.testing.assert_allclose(there.speed, 200.0 * speed, rtol=1e-12)
        np.testing.assert_array_equal(there.hit, 1)
        np.testing.assert_array_equal(there.grain, departures.impacts.grain)
        cosine, sine = np.cos(there.alpha1), np.sin(there.alpha1)
        towards = np.column_stack([cosine, -sine, np.zeros(len(sine))])
        direction = np.einsum("nji,nj->ni", frames, towards)
        keys = {"orientation": turned, "grain": there.grain, "seed": 3, "index": INDEX, "hit": 1}
        velocity = there.speed[:, None] * direction
        lab = MODEL.rebound(velocity, frames[:, 1], 0.1, omega=2000.0 * omega, **keys)
        after = np.einsum("nij,nj->ni", frames, lab.velocity) / there.speed[:, None]
        # in a long chain of collisions rounding grows
        off = np.abs(after - depart(MODEL, there, 3).states[:, :3]).max(axis=1)
        assert np.mean(off < 1e-6) > 0.97
        return frames, direction, states[:, :3] / speed[:, None]

    @pytest.mark.parametrize("walls", WALLS)
    def test_is_that_of_the_lab_frame(self, departures, walls):
        uniform = np.random.default_rng(1).random((len(INDEX), 3))
        number = np.full(len(INDEX), WALLS.index(walls))
        there = next_impacts(MODEL, departures, number, uniform)
        frames, direction, left = self.frames(departures, there, uniform[:, 0])
        normal, up = frames[:, 1], np.array([0.0, 1.0, 0.0])
        left = left * [1.0, -1.0, 1.0] if walls == "same" else left
        np.testing.assert_allclose(direction, left, atol=1e-7)
        if walls in ("same", "opposite"):
            side = 1.0 if walls == "same" else -1.0
            np.testing.assert_allclose(normal, np.tile(side * up, (len(INDEX), 1)), atol=1e-12)
        elif walls == "corner":
            np.testing.assert_allclose(normal @ up, 0.0, atol=1e-12)
            np.testing.assert_allclose(np.cross(normal, left) @ up, 0.0, atol=1e-7)
        else:
            angles = np.radians(5.0 + 80.0 * uniform[:, 1])
            np.testing.assert_allclose(there.alpha1, angles, atol=1e-9)
            # isotropic about the direction: false-alarm rate 1e-6
            along = normal + np.sin(angles)[:, None] * left
            side = along @ up / np.cos(angles) / np.linalg.norm(np.cross(left, up), axis=1)
            assert kstest(np.arccos(np.clip(side, -1, 1)), "uniform", (0, np.pi)).pvalue > 1e-6

    def test_walls_are_met_at_given_angles(self, departures):
        alpha, uniform = (
            np.radians(np.linspace(0.5, 90.0, len(INDEX))),
            np.full((len(INDEX), 2), 0.3),
        )
        there = meet(MODEL, departures, alpha, uniform)
        np.testing.assert_array_equal(there.alpha1, alpha)
        _, direction, left = self.frames(departures, there, uniform[:, 0])
        np.testing.assert_allclose(direction, left, atol=1e-7)


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
