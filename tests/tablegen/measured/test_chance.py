"""Chance errors of moments that come from the same particles, against many small samples."""

import numpy as np

from tablegen.measured.chance import covariances, influences

COLUMNS = ("e_n", "e_n_std", "e_t", "e_t_std", "rebound_angle_deg", "omega_z")
ALPHA = np.radians(35.0)
SHARES = np.array([0.7, 0.3])


def particles(rng, shape, count):
    """Skew variables u, v, angles and spin of one of two shapes."""
    v = rng.gamma(2.0 + shape, 0.1, count)
    u = 0.5 + 0.2 * shape - 0.4 * v + rng.normal(0.0, 0.1, count)
    angle = np.degrees(np.arctan2(v, u))
    return np.column_stack([u, v, angle, rng.normal(0.0, 5.0, count), -v + 0.1 * u])


def moments(x, weights):
    """The moments of `COLUMNS` of weighted particles."""
    mean = weights @ x
    std = np.sqrt(weights @ (x - mean) ** 2)
    e_n, e_t = 1.0 / np.sin(ALPHA), 1.0 / np.cos(ALPHA)
    turned = np.degrees(np.arctan2(mean[1], mean[0]))
    return np.array([e_n * mean[1], e_n * std[1], e_t * mean[0], e_t * std[0], turned, mean[4]])


def test_covariances_are_those_of_many_small_samples():
    """Of 4,000 samples: an element errs by 0.03 of its scale, a hundredth of them by 0.08."""
    rng = np.random.default_rng(8)
    large = [particles(rng, shape, 100_000) for shape in range(2)]
    measured, simulated = covariances(influences(large, SHARES, ALPHA, COLUMNS), SHARES)
    n = 400
    mixed, stratified = [], []
    for _ in range(4000):
        first = rng.binomial(n, SHARES[0])
        x = np.vstack([particles(rng, 0, first), particles(rng, 1, n - first)])
        mixed.append(moments(x, np.full(n, 1.0 / n)))
        x = np.vstack([particles(rng, shape, n) for shape in range(2)])
        stratified.append(moments(x, np.repeat(SHARES / n, n)))
    for expected, samples in ((measured, mixed), (simulated, stratified)):
        found = n * np.cov(np.array(samples), rowvar=False)
        scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
        assert np.abs((found - expected) / scale).max() < 0.1
    # the two differ: strata leave the chance of the shapes out
    assert np.abs(measured - simulated).max() > 0.1 * np.abs(measured).max()


def test_a_spread_of_zero_has_no_error():
    same = [np.ones((10, 5))]
    found = influences(same, np.ones(1), ALPHA, ("e_n_std",))
    assert found[0].tolist() == np.zeros((10, 1)).tolist()
