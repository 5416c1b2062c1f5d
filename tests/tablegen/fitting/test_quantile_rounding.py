"""Rounded quantiles: close in probability, in order, odd where they were, and smaller."""

import zlib

import numpy as np
from scipy.stats import norm

from tablegen.fitting.quantile_rounding import STEPS, rounded_quantiles

KNOTS = np.linspace(-4.2, 4.2, 129)


def _quantiles():
    """Of a wide law, a narrow one far from zero, one next to zero and one with an atom."""
    return np.array(
        [
            norm.ppf(norm.cdf(KNOTS)),
            0.9 + 1e-3 * KNOTS,
            np.exp(2.0 * KNOTS - 9.0),
            np.maximum(KNOTS, 0.25),
        ]
    ).astype(np.float32)


def _packed(values):
    """Bytes after shuffling and compression, as a file has them."""
    return len(
        zlib.compress(np.ascontiguousarray(values).view(np.uint8).reshape(-1, 4).T.tobytes(), 9)
    )


def test_probabilities_stay():
    before, after = _quantiles(), rounded_quantiles(_quantiles())
    for old, new in zip(before.astype(float), after.astype(float), strict=True):
        rising = np.append(np.diff(old) > 0.0, True)
        shares = np.interp(new[rising], old[rising], norm.cdf(KNOTS)[rising])
        assert np.abs(shares - norm.cdf(KNOTS)[rising]).max() < 0.027 / (2 * STEPS)


def test_order_ends_and_atoms_stay():
    before, after = _quantiles(), rounded_quantiles(_quantiles())
    assert (np.diff(after, axis=-1) >= 0.0).all()
    np.testing.assert_array_equal(np.diff(after, axis=-1) > 0.0, np.diff(before, axis=-1) > 0.0)
    np.testing.assert_array_equal(after[:, [0, -1]], before[:, [0, -1]])
    assert (after[3, KNOTS <= 0.25] == 0.25).all()


def test_odd_stays_odd():
    odd = rounded_quantiles(_quantiles()[:1])
    np.testing.assert_array_equal(odd, -odd[:, ::-1])


def test_bytes():
    """Quantiles of samples, whose last digits are chance."""
    samples = np.random.default_rng(1).standard_normal((20, 10_000))
    before = np.quantile(samples, norm.cdf(KNOTS), axis=-1).T.astype(np.float32)
    assert _packed(rounded_quantiles(before)) < 0.75 * _packed(before)
