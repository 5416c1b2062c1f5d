"""The roughness of a measured profile: the formula, and what is refused."""

import math

import numpy as np
import pytest
from sampler.arguments import MAX_ROUGHNESS

import sampler


def test_small_particles_meet_flanks_and_large_ones_the_whole_profile():
    """Ra 2, Rq 3, RSm 20 micrometres: flanks of 11.3 degrees, met below 102 micrometres."""
    border = 20.0 / math.sin(math.atan(0.2))
    assert border == pytest.approx(102.0, abs=0.1)
    tilts = sampler.wall_tilt(2e-6, 3e-6, 20e-6, np.array([[1e-6, 101e-6], [103e-6, 1.0]]))
    expected = [[math.atan(0.2)] * 2, [math.atan(0.3)] * 2]
    np.testing.assert_allclose(tilts, expected, rtol=1e-14)


def test_one_particle_and_any_unit():
    one = sampler.wall_tilt(2e-6, 3e-6, 20e-6, 50e-6)
    assert one.shape == ()
    assert one == pytest.approx(sampler.wall_tilt(2.0, 3.0, 20.0, 50.0), rel=1e-15)


def test_a_flat_profile_is_a_smooth_wall():
    assert sampler.wall_tilt(0.0, 0.0, 1.0, 1e9) == 0.0


def test_published_profiles():
    """For sand of 200 micrometres: polished and cast walls; on a cut one Rq / RSm is 1/2."""
    assert sampler.wall_tilt(1.0, 0.05, 0.5, 200.0) == math.atan(0.2)
    assert sampler.wall_tilt(25.0, 1.0, 10.0, 200.0) == math.atan(0.2)
    with pytest.raises(sampler.InputError, match=r"got ra 100, rq 25, rsm 50, a tilt of 0\.78"):
        sampler.wall_tilt(100.0, 25.0, 50.0, 200.0)


def test_only_the_tilts_of_the_particles_at_hand_count():
    """The flanks of a cast wall are too steep for a small particle, which is refused."""
    with pytest.raises(sampler.InputError, match=r"a tilt of 1\.37\S* rad, allowed: .* 0\.5 rad$"):
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
        ((0.1, 0.1, [1.0], 1.0), r"rsm: got shape \(1,\), allowed: one number"),
        ((0.1, "rough", 1.0, 1.0), r"rq: got str\w* values, allowed: real numbers"),
    ],
)
def test_wrong_lengths_are_refused(lengths, message):
    with pytest.raises(sampler.InputError, match=f"^{message}"):
        sampler.wall_tilt(*lengths)
