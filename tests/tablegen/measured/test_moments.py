"""Moments of shapes and of mixtures, and their chance errors, against plain sums."""

import math

import numpy as np
import pytest

from tablegen.measured.measurements import QUANTITIES
from tablegen.measured.moments import SimulatedMoments, mixed_moments, variables_of

#: Two shapes of four states each: u, v, w, omega_x, omega_y, omega_z.
FIRST, SECOND = np.array(
    [
        [0.5, 0.2, 0.0, 0.0, 0.0, -0.4],
        [0.7, 0.2, 0.3, 9.0, 9.0, -0.2],
        [-0.1, 0.4, -0.3, 9.0, 9.0, 0.2],
        [0.5, 0.4, 0.0, 0.0, 9.0, -0.4],
        [0.1, 0.8, 0.1, 0.0, 0.0, 0.1],
        [0.3, 0.6, 0.1, 0.0, 0.0, 0.3],
        [0.2, 0.3, -0.2, 0.0, 0.0, 0.2],
        [0.2, 0.1, 0.0, 0.0, 0.0, -0.6],
    ]
).reshape(2, 4, 6)


def moments_of(*samples, alpha_deg=30.0, shares=(1.0,)):
    """Moments of one row from the states of each shape."""
    parts = [variables_of(states) for states in samples]
    return SimulatedMoments.from_rows([mixed_moments(parts, shares, alpha_deg)])


def test_quantities_of_hand_made_states():
    row_moments = moments_of(FIRST)
    s, c = 0.5, math.sqrt(0.75)
    # the angle of the mean velocity, but the spread of the particles' own angles, one beyond 90
    angles = np.degrees([math.atan2(v, u) for u, v in FIRST[:, :2]])
    out = [math.degrees(math.asin(s[2] / np.linalg.norm(s[:3]))) for s in FIRST]
    expected = {
        "e_n": (0.3 / s, 0.1 / s),
        "e_t": (0.4 / c, 0.3 / c),
        "rebound_angle_deg": (math.degrees(math.atan2(0.3, 0.4)), angles.std()),
        "out_of_plane_deg": (np.mean(out), np.std(out)),
        "omega_z": (-0.2, math.sqrt(0.06)),
    }
    for name, (mean, std) in expected.items():
        assert row_moments.mean[name][0] == pytest.approx(mean), name
        assert row_moments.std[name][0] == pytest.approx(std), name


def test_tangential_restitution_is_undefined_at_normal_impact():
    row_moments = moments_of(FIRST, alpha_deg=90.0)
    for moments in (
        row_moments.mean,
        row_moments.std,
        row_moments.mean_error,
        row_moments.std_error,
    ):
        assert [name for name in QUANTITIES if np.isnan(moments[name][0])] == ["e_t"]


def test_a_mixture_is_its_particles_put_together():
    """Shares 3/4 and 1/4 are three copies of the states of one shape and one of the other's."""
    mixed = moments_of(FIRST, SECOND, shares=(0.75, 0.25))
    together = moments_of(np.vstack([FIRST] * 3 + [SECOND]))
    for name in QUANTITIES:
        np.testing.assert_allclose(mixed.mean[name], together.mean[name], rtol=1e-13)
        np.testing.assert_allclose(mixed.std[name], together.std[name], rtol=1e-13)


def test_chance_errors_are_the_scatter_of_repetitions():
    """600 repetitions of two strata: a standard deviation of them is within 15 %, five errors."""
    rng, n = np.random.default_rng(2), 200
    shares = np.array([0.3, 0.7])

    def states():
        some = rng.gamma((4.0, 2.0, 3.0, 1.0, 1.0, 2.0), 0.1, (n, 6))
        others = rng.uniform((-0.4, 0.1, -0.3, 0, 0, -1), (0.2, 0.3, 0.3, 1, 1, 0), (n, 6))
        return some, others

    runs = [moments_of(*states(), shares=shares) for _ in range(600)]
    for name in QUANTITIES:
        for value, error in (("mean", "mean_error"), ("std", "std_error")):
            scatter = np.std([getattr(run, value)[name][0] for run in runs])
            stated_error = np.mean([getattr(run, error)[name][0] for run in runs])
            assert stated_error == pytest.approx(scatter, rel=0.15), (name, value)
