"""Chains of impacts: the next impact's frame, and which conditions are taken."""

import numpy as np
import pytest

from tablegen.config.config import load_config
from tablegen.simulation.direct import DirectModel
from tablegen.simulation.impact_chains import (
    HITS,
    effective_speed,
    first_impacts,
    next_impacts,
    occurring_impacts,
    simulated,
    speeds_measured,
)

CONFIG = load_config("corundum-steel")
SLOW = CONFIG.with_changes({"domain": {"speed": [5.0, 300.0], "extrapolate": True}})
MODEL = DirectModel(CONFIG)
INDEX = np.arange(400, dtype=np.uint64)
SIZE = 1e-5


class TestNextImpact:
    """In wall axes as in the lab frame, where the particle just flies on to the next wall."""

    @pytest.mark.parametrize("opposite", [False, True])
    def test_is_that_of_the_lab_frame(self, opposite):
        start = first_impacts(CONFIG, 3, INDEX)
        speed, alpha = start.speed, start.alpha1
        velocity = speed[:, None] * np.column_stack([np.cos(alpha), -np.sin(alpha), 0.0 * alpha])
        keys = {"seed": 3, "index": INDEX}
        up = np.array([0.0, 1.0, 0.0])
        first = MODEL.rebound(velocity, up, SIZE, hit=0, **keys)
        # flying on, a particle meets a wall above; to meet the one below again, it is turned back
        if opposite:
            normal, again, omega = -up, first.velocity, first.omega
        else:
            normal, again, omega = up, first.velocity * [1.0, -1.0, 1.0], first.omega
        second = MODEL.rebound(again, normal, SIZE, omega=omega, hit=1, **keys)
        there = next_impacts(start, simulated(MODEL, start, 3), np.full(len(INDEX), opposite))
        after = simulated(MODEL, there, 3)
        assert (there.hit == 1).all()
        np.testing.assert_allclose(there.speed, np.linalg.norm(again, axis=1), rtol=1e-12)
        # some rebounds of many collisions grow a rounding of the condition
        close = np.isclose(
            np.linalg.norm(after[:, :3], axis=1) * there.speed,
            np.linalg.norm(second.velocity, axis=1),
            rtol=1e-6,
        )
        assert close.mean() > 0.97
        along = np.abs(second.velocity @ normal)
        assert np.isclose(after[close, 1] * there.speed[close], along[close], rtol=1e-5).all()


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
