"""Mixtures of experts: kernels against plain formulae, a law that is recovered, hard samples."""

import numpy as np
import pytest

from tablegen.fitting.expectation import (
    add_products,
    find_curvatures,
    find_shares,
    softmax,
    write_log_densities,
)
from tablegen.fitting.experts import Experts, expectation, fit_experts
from tablegen.fitting.spin_coordinates import features

RNG = np.random.default_rng(6)


def reference_softmax(logits):
    weights = np.exp(logits - logits.max(axis=-1, keepdims=True))
    return weights / weights.sum(axis=-1, keepdims=True)


def test_shares_and_derivatives_of_the_likelihood():
    n, groups, each, d = 30, 3, 4, 6
    logits = RNG.normal(0.0, 3.0, (2, 16, 40)).astype(np.float32)
    expected = reference_softmax(logits.swapaxes(1, 2)).swapaxes(1, 2)
    softmax(logits)
    np.testing.assert_allclose(logits, expected, rtol=1e-5, atol=1e-7)
    white = RNG.normal(size=(n, d, groups * each)).astype(np.float32)
    constant = RNG.normal(size=groups * each).astype(np.float32)
    top, sub = RNG.normal(size=(n, groups)), RNG.normal(size=(n, groups, each))

    def likelihood(top, sub):
        prior = reference_softmax(top)[:, :, None] * reference_softmax(sub)
        density = np.exp(constant - 0.5 * np.sum(white.astype(float) ** 2, axis=1))
        joint = prior * density.reshape(n, groups, each)
        return np.log(joint.sum(axis=(1, 2))), joint / joint.sum(axis=(1, 2), keepdims=True)

    group = np.ascontiguousarray(reference_softmax(top).T, dtype=np.float32)
    expert = np.ascontiguousarray(reference_softmax(sub).reshape(n, -1).T, dtype=np.float32)
    share = np.empty_like(expert)
    write_log_densities(np.ascontiguousarray(white.reshape(n, -1).T), constant, share)
    by_group, by_expert = np.empty_like(group), np.empty_like(expert)
    total = find_shares(share, group, expert, by_group, by_expert)
    expected, shares = likelihood(top, sub)
    assert total == pytest.approx(expected.sum(), rel=1e-5)
    np.testing.assert_allclose(share.T.reshape(shares.shape), shares, atol=1e-5)
    step = 1e-5
    for g in range(groups):
        moved, inner = top.copy(), sub.copy()
        moved[:, g] += step
        slope = (likelihood(moved, sub)[0] - expected) / step
        np.testing.assert_allclose(by_group[g], slope, atol=1e-3)
        inner[:, g, 1] += step
        slope = (likelihood(top, inner)[0] - expected) / step
        np.testing.assert_allclose(by_expert[g * each + 1], slope, atol=1e-3)
    find_curvatures(share, group, expert, by_group, by_expert)
    np.testing.assert_allclose(by_group, group * (1.0 - group), rtol=1e-5)
    whole = (
        shares.sum(axis=2, keepdims=True) * reference_softmax(sub) * (1.0 - reference_softmax(sub))
    )
    np.testing.assert_allclose(by_expert.T, whole.reshape(n, -1), atol=1e-5)


def test_no_share_is_subnormal():
    """Processors take a hundred cycles for each number between 0 and 2**-126.

    These are sharp gates and densities, as those of the last iterations of a fit.
    """
    n, groups, each = 200, 4, 8
    group = RNG.normal(0.0, 60.0, (1, groups, n)).astype(np.float32)
    expert = RNG.normal(0.0, 60.0, (groups, each, n)).astype(np.float32)
    share = RNG.normal(0.0, 300.0, (groups * each, n)).astype(np.float32)
    for logits in (group, expert):
        softmax(logits)
        assert logits.min() > 2.0**-35
    group, expert = group[0], expert.reshape(groups * each, n)
    by_group, by_expert = np.empty_like(group), np.empty_like(expert)
    find_shares(share, group, expert, by_group, by_expert)
    np.testing.assert_allclose(share.sum(axis=0), 1.0, rtol=1e-5)
    assert ((share == 0.0) | (share >= 2.0**-60)).all()
    for numbers in (by_group, by_expert):
        assert ((numbers == 0.0) | (np.abs(numbers) > 2.0**-126)).all()


def test_sums_of_products():
    n, count, width = 70, 5, 19
    weight, vectors = RNG.random((count, n)), RNG.normal(size=(n, width))
    weight[weight < 0.3], weight[2] = 1e-3, 0.0
    kept = np.where(weight < 0.1, 0.0, weight)
    expected = np.triu(np.einsum("kn,na,nb->kab", kept, vectors, vectors))
    products = np.zeros((count, width, width))
    single = weight.astype(np.float32), vectors.astype(np.float32)
    for _ in range(2):
        add_products(*single, np.float32(0.1), products)
    np.testing.assert_allclose(products, 2.0 * expected, atol=1e-4)


def test_a_known_law_is_recovered():
    """Two experts with opposite slopes, chosen by the sign of the second input."""
    t = RNG.normal(size=(6000, 8))
    t[:, 2:] *= 0.3
    chosen = 1.0 / (1.0 + np.exp(-6.0 * t[:, 1]))
    second = RNG.random(len(t)) < chosen
    mean = np.where(second, 1.0 + t[:, 0], -1.0 - 0.5 * t[:, 0])[:, None]
    scores = mean + 0.3 * RNG.normal(size=(len(t), 7))
    vectors = np.hstack([features(t), scores]).astype(np.float32)
    fitted, likelihood = fit_experts(vectors, 8, 7, 1, 2, np.random.default_rng(1))
    right = np.where(second, chosen, 1.0 - chosen)
    density = -0.5 * np.sum(((scores - mean) / 0.3) ** 2, axis=1)
    density -= 7.0 * np.log(0.3 * np.sqrt(2.0 * np.pi))
    # the two hardly overlap, so this is the likelihood of the truth; free numbers add a half each
    free = 2 * (7 * 30 + 28) + 30
    truth = float(np.mean(density + np.log(right)))
    assert likelihood == pytest.approx(truth + 0.5 * free / len(t), abs=0.05)
    deviations = np.sqrt(np.einsum("kij,kij->ki", fitted.factor, fitted.factor))
    np.testing.assert_allclose(deviations, 0.3, rtol=0.1)
    # with the slopes exchanged, the law is worse
    wrong = Experts(fitted.group_gate, fitted.gate, fitted.mean[::-1], fitted.factor, fitted.weight)
    assert expectation(wrong, vectors).likelihood / len(t) < likelihood - 1.0


@pytest.mark.parametrize("n", [5, 60, 3000])
def test_hard_samples_give_finite_numbers(n):
    """Outcomes that are constant, functions of the condition, and equal to another outcome."""
    t, scores = RNG.normal(size=(n, 8)), RNG.normal(size=(n, 7))
    scores[:, 1], scores[:, 2], scores[:, 3] = 0.0, t[:, 0], scores[:, 0]
    vectors = np.hstack([features(t), scores]).astype(np.float32)
    fitted, likelihood = fit_experts(vectors, 8, 7, 2, 8, np.random.default_rng(2))
    for part in (fitted.group_gate, fitted.gate, fitted.mean, fitted.factor, likelihood):
        assert np.isfinite(part).all()
    assert (np.einsum("kii->ki", fitted.factor) > 0.0).all()
