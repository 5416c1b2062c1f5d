"""Moments of shapes and of mixtures, and their chance errors, against plain sums."""

import math

import numpy as np
import pytest

from tablegen.measured.measurements import QUANTITIES
from tablegen.measured.moments import (
    CentralMoments,
    Strata,
    central_moments,
    covariances,
    influences,
    variables_of,
)

#: Two shapes of four states each: u, v, w, omega_x, omega_y, omega_z.
FIRST = np.array(
    [
        [0.5, 0.2, 0.0, 0.0, 0.0, -0.4],
        [0.7, 0.2, 0.3, 9.0, 9.0, -0.2],
        [-0.1, 0.4, -0.3, 9.0, 9.0, 0.2],
        [0.5, 0.4, 0.0, 0.0, 9.0, -0.4],
    ]
)
SECOND = np.array(
    [
        [0.1, 0.8, 0.1, 0.0, 0.0, 0.1],
        [0.3, 0.6, 0.1, 0.0, 0.0, 0.3],
        [0.2, 0.3, -0.2, 0.0, 0.0, 0.2],
        [0.2, 0.1, 0.0, 0.0, 0.0, -0.6],
    ]
)


def strata_of(*samples, alpha_deg=30.0):
    """Strata of one row from the states of each shape."""
    parts = [central_moments(variables_of(states)) for states in samples]
    moments = CentralMoments(*(np.array([arrays]) for arrays in zip(*parts, strict=True)))
    shares = np.full(len(samples), 1.0 / len(samples))
    return Strata(np.array([alpha_deg]), shares, len(samples[0]), moments)


def test_quantities_of_hand_made_states():
    found = strata_of(FIRST).mixed()
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
        assert found.mean[name][0] == pytest.approx(mean), name
        assert found.std[name][0] == pytest.approx(std), name


def test_tangential_restitution_is_undefined_at_normal_impact():
    found = strata_of(FIRST, alpha_deg=90.0).mixed()
    for moments in (found.mean, found.std, found.mean_error, found.std_error):
        assert [name for name in QUANTITIES if np.isnan(moments[name][0])] == ["e_t"]


def test_a_mixture_is_its_particles_put_together():
    """Shares 3/4 and 1/4 are three copies of the states of one shape and one of the other's."""
    mixed = strata_of(FIRST, SECOND).mixed([0.75, 0.25])
    together = strata_of(np.vstack([FIRST] * 3 + [SECOND])).mixed()
    for name in QUANTITIES:
        np.testing.assert_allclose(mixed.mean[name], together.mean[name], rtol=1e-13)
        np.testing.assert_allclose(mixed.std[name], together.std[name], rtol=1e-13)


def test_equal_states_have_no_spread_and_no_error():
    states = np.repeat(FIRST[:1], 5, axis=0)
    found = strata_of(states).mixed()
    for name in QUANTITIES:
        assert found.std[name][0] < 1e-14
        assert found.mean_error[name][0] < 1e-14
        assert np.isfinite(found.std_error[name][0])
    (influence,) = influences([np.ones((10, 5))], np.ones(1), 0.6, ("e_n_std",))
    assert not influence.any()


def test_chance_errors_are_the_scatter_of_repetitions():
    """600 repetitions of two strata: a standard deviation of them is within 15 %, five errors."""
    rng, n = np.random.default_rng(2), 200
    shares = np.array([0.3, 0.7])

    def states():
        some = rng.gamma((4.0, 2.0, 3.0, 1.0, 1.0, 2.0), 0.1, (n, 6))
        others = rng.uniform((-0.4, 0.1, -0.3, 0, 0, -1), (0.2, 0.3, 0.3, 1, 1, 0), (n, 6))
        return some, others

    runs = [strata_of(*states()).mixed(shares) for _ in range(600)]
    for name in QUANTITIES:
        for value, error in (("mean", "mean_error"), ("std", "std_error")):
            scatter = np.std([getattr(run, value)[name][0] for run in runs])
            told = np.mean([getattr(run, error)[name][0] for run in runs])
            assert told == pytest.approx(scatter, rel=0.15), (name, value)


def test_covariances_are_those_of_many_small_samples():
    """Of 4,000 samples: an element errs by 0.03 of its scale, a hundredth of them by 0.08."""
    rng, alpha, n, shares = np.random.default_rng(8), np.radians(35.0), 400, np.array([0.7, 0.3])
    columns = ("e_n", "e_n_std", "e_t", "e_t_std", "rebound_angle_deg", "omega_z")

    def particles(shape, count):
        v = rng.gamma(2.0 + shape, 0.1, count)
        u = 0.5 + 0.2 * shape - 0.4 * v + rng.normal(0.0, 0.1, count)
        angle = np.degrees(np.arctan2(v, u))
        return np.column_stack([u, v, angle, rng.normal(0.0, 5.0, count), -v + 0.1 * u])

    def moments(x, weights):
        mean = weights @ x
        std = np.sqrt(weights @ (x - mean) ** 2)
        e_n, e_t = 1.0 / np.sin(alpha), 1.0 / np.cos(alpha)
        turned = np.degrees(np.arctan2(mean[1], mean[0]))
        return np.array([e_n * mean[1], e_n * std[1], e_t * mean[0], e_t * std[0], turned, mean[4]])

    large = [particles(shape, 100_000) for shape in range(2)]
    measured, simulated = covariances(influences(large, shares, alpha, columns), shares)
    mixed, stratified = [], []
    for _ in range(4000):
        first = rng.binomial(n, shares[0])
        x = np.vstack([particles(0, first), particles(1, n - first)])
        mixed.append(moments(x, np.full(n, 1.0 / n)))
        x = np.vstack([particles(shape, n) for shape in range(2)])
        stratified.append(moments(x, np.repeat(shares / n, n)))
    for expected, samples in ((measured, mixed), (simulated, stratified)):
        found = n * np.cov(np.array(samples), rowvar=False)
        scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
        assert np.abs((found - expected) / scale).max() < 0.1
    # strata leave the chance of the shapes out
    assert np.abs(measured - simulated).max() > 0.1 * np.abs(measured).max()
