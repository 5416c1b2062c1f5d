"""Mixtures of experts: kernels against plain formulae, a law that is recovered, hard samples."""

import numpy as np
import pytest
from scipy.special import logsumexp

from sampler.formats.bounds import N_DIRECTIONS, N_FEATURES, N_INPUTS
from tablegen.fitting.expectation import (
    add_products,
    find_shares,
    softmax,
    weigh_shares,
    write_log_densities,
)
from tablegen.fitting.experts import Experts, Weight, expectation, fit_experts
from tablegen.fitting.spin_coordinates import features

RNG = np.random.default_rng(6)
#: Numbers of a condition: inputs and directions.
WIDTH = N_INPUTS + N_DIRECTIONS


def reference_softmax(logits):
    weights = np.exp(logits - logits.max(axis=-1, keepdims=True))
    return weights / weights.sum(axis=-1, keepdims=True)


def single(values):
    return np.ascontiguousarray(values, dtype=np.float32)


def shares_by_kernels(log_density, group, expert):
    """Shares and gradients of experts, (n, g, k), and of groups, (n, g), with the likelihood."""
    share, probability = single(log_density.transpose(1, 2, 0)), single(expert.transpose(1, 2, 0))
    group_share = np.array([find_shares(*pair) for pair in zip(share, probability, strict=True)])
    group_probability, gradient = single(group.T), np.empty_like(share)
    total = find_shares(group_share, group_probability)
    for g, row in enumerate(group_share):
        weigh_shares(share[g], probability[g], row, gradient[g])
    by_group = group_share - group_probability
    return share.transpose(2, 0, 1), gradient.transpose(2, 0, 1), by_group.T, total


def test_shares_and_derivatives_of_the_likelihood():
    n, groups, each, d = 30, 3, 4, 6
    logits = single(RNG.normal(0.0, 3.0, (16, 40)))
    expected, log_sums = reference_softmax(logits.T).T, logsumexp(logits, axis=0)
    np.testing.assert_allclose(softmax(logits), log_sums, rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(logits, expected, rtol=1e-5, atol=1e-7)
    white = RNG.normal(size=(n, d, groups * each)).astype(np.float32)
    constant = RNG.normal(size=groups * each).astype(np.float32)
    top, sub = RNG.normal(size=(n, groups)), RNG.normal(size=(n, groups, each))
    log_density = constant - 0.5 * np.sum(white.astype(float) ** 2, axis=1)
    written = np.empty((groups * each, n), dtype=np.float32)
    write_log_densities(single(white.reshape(n, -1).T), constant, written)
    np.testing.assert_allclose(written.T, log_density, rtol=1e-5)
    log_density = log_density.reshape(n, groups, each)

    def likelihood(top, sub):
        joint = reference_softmax(top)[:, :, None] * reference_softmax(sub) * np.exp(log_density)
        return np.log(joint.sum(axis=(1, 2))), joint / joint.sum(axis=(1, 2), keepdims=True)

    share, gradient, by_group, total = shares_by_kernels(
        log_density, reference_softmax(top), reference_softmax(sub)
    )
    expected, shares = likelihood(top, sub)
    np.testing.assert_allclose(total, expected, rtol=1e-4, atol=1e-5)
    np.testing.assert_allclose(share, shares, atol=1e-5)
    step = 1e-5
    for g in range(groups):
        moved, inner = top.copy(), sub.copy()
        moved[:, g] += step
        slope = (likelihood(moved, sub)[0] - expected) / step
        np.testing.assert_allclose(by_group[:, g], slope, atol=1e-3)
        inner[:, g, 1] += step
        slope = (likelihood(top, inner)[0] - expected) / step
        np.testing.assert_allclose(gradient[:, g, 1], slope, atol=1e-3)


def test_no_share_is_subnormal():
    """Processors take a hundred cycles for each number between 0 and 2**-126.

    These are sharp gates and densities, as those of the last iterations of a fit.
    """
    n, groups, each = 200, 4, 8
    group, expert = RNG.normal(0.0, 60.0, (groups, n)), RNG.normal(0.0, 60.0, (groups, each, n))
    group, expert = single(group), single(expert)
    for logits in (group, *expert):
        softmax(logits)
        assert logits.min() > 2.0**-35
    log_density = RNG.normal(0.0, 300.0, (n, groups, each))
    # products of shares in a group and of shares of groups are not subnormal either
    inner = single(log_density[:, 0].T)
    find_shares(inner, expert[0])
    assert ((inner == 0.0) | (inner >= 2.0**-60)).all()
    shares = shares_by_kernels(log_density, group.T, expert.transpose(2, 0, 1))
    np.testing.assert_allclose(shares[0].sum(axis=(1, 2)), 1.0, rtol=1e-5)
    assert ((shares[0] == 0.0) | (shares[0] >= 2.0**-60)).all()
    for numbers in shares:
        assert ((numbers == 0.0) | (np.abs(numbers) > 2.0**-126)).all()


def separate_experts(each, rng):
    """Experts of three groups around scores of -2, 0 and 2, with gates that are nearly flat."""
    count = 3 * each
    mean = np.zeros((count, 7, N_FEATURES))
    mean[:, :, 0] = np.repeat([-2.0, 0.0, 2.0], each)[:, None]
    gates = rng.normal(0.0, 0.1, (3, N_FEATURES)), rng.normal(0.0, 0.1, (count, N_FEATURES))
    factor = np.repeat(0.1 * np.eye(7)[None], count, axis=0)
    weight = Weight(*(np.zeros((n, N_FEATURES, N_FEATURES)) for n in (3, count, count)))
    return Experts(*gates, mean, factor, weight)


def separate_rebounds(n, rng):
    """Features and scores of rebounds of `separate_experts`, and their groups."""
    group = rng.integers(3, size=n)
    scores = np.array([-2.0, 0.0, 2.0])[group, None] + 0.1 * rng.normal(size=(n, 7))
    return single(np.hstack([features(rng.normal(size=(n, WIDTH))), scores])), group


def test_groups_without_a_share_need_not_be_computed():
    rng = np.random.default_rng(3)
    fitted, (vectors, group) = separate_experts(2, rng), separate_rebounds(3000, rng)
    whole = expectation(fitted, vectors, np.ones((3, 3000), dtype=bool), curved=1500)
    np.testing.assert_array_equal(whole.near, np.arange(3)[:, None] == group)
    part = expectation(fitted, vectors, whole.near, curved=1500)
    assert part.likelihood == pytest.approx(whole.likelihood, rel=1e-6)
    for name in ("products", "by_group", "by_expert", "group_curvature", "expert_curvature"):
        a, b = getattr(part, name), getattr(whole, name)
        # P (1 - P) of groups that are far apart is nothing but the rounding of P
        np.testing.assert_allclose(a, b, atol=1e-5 * max(np.abs(b).max(), 1.0))
    assert 1500 <= part.curved < 3000
    first = vectors[: part.curved]
    begun = expectation(fitted, first, np.ones((3, len(first)), dtype=bool), curved=len(first))
    for name in ("group_curvature", "expert_curvature"):
        np.testing.assert_allclose(getattr(whole, name), getattr(begun, name), rtol=1e-6, atol=1e-6)
    # with other groups instead, the likelihood is far lower
    wrong = expectation(fitted, vectors, np.roll(whole.near, 1, axis=0))
    assert wrong.likelihood < whole.likelihood - 1000.0 * len(vectors)


def test_curvatures_of_gates():
    """P (1 - P) for a group, and that of an expert times the share of its group."""
    rng = np.random.default_rng(4)
    fitted, (vectors, group) = separate_experts(2, rng), separate_rebounds(500, rng)
    sums = expectation(fitted, vectors, np.ones((3, 500), dtype=bool), curved=500)
    phi = vectors[:, :N_FEATURES].astype(float)
    top = reference_softmax(phi @ fitted.group_gate.T)
    inner = reference_softmax((phi @ fitted.gate.T).reshape(500, 3, 2))
    share = (group[:, None] == np.arange(3))[:, :, None] * (inner - inner**2)
    for found, weight in (
        (sums.group_curvature, top - top**2),
        (sums.expert_curvature, share.reshape(500, 6)),
    ):
        expected = np.triu(np.einsum("nk,na,nb->kab", weight, phi, phi))
        np.testing.assert_allclose(found, expected, atol=1e-4 * np.abs(expected).max())


def test_sums_of_products():
    n, count, width = 70, 5, 19
    weight, vectors = RNG.random((count, n)), RNG.normal(size=(n, width))
    weight[weight < 0.3], weight[2] = 1e-3, 0.0
    kept = np.where(weight < 0.1, 0.0, weight)
    expected = np.triu(np.einsum("kn,na,nb->kab", kept, vectors, vectors))
    products = np.zeros((count, width, width))
    for _ in range(2):
        add_products(single(weight), single(vectors), np.float32(0.1), products)
    np.testing.assert_allclose(products, 2.0 * expected, atol=1e-4)


def test_a_known_law_is_recovered():
    """Two experts with opposite slopes, chosen by the sign of the second input."""
    t = RNG.normal(size=(6000, WIDTH))
    t[:, 2:] *= 0.3
    chosen = 1.0 / (1.0 + np.exp(-6.0 * t[:, 1]))
    second = RNG.random(len(t)) < chosen
    mean = np.where(second, 1.0 + t[:, 0], -1.0 - 0.5 * t[:, 0])[:, None]
    scores = mean + 0.3 * RNG.normal(size=(len(t), 7))
    vectors = np.hstack([features(t), scores]).astype(np.float32)
    fitted, likelihood = fit_experts(
        vectors, N_INPUTS, 7, 1, 2, np.zeros(len(t), dtype=int), np.random.default_rng(1)
    )
    right = np.where(second, chosen, 1.0 - chosen)
    density = -0.5 * np.sum(((scores - mean) / 0.3) ** 2, axis=1)
    density -= 7.0 * np.log(0.3 * np.sqrt(2.0 * np.pi))
    # the two hardly overlap, so this is the likelihood of the truth; free numbers add a half each
    free = 2 * (7 * N_FEATURES + 28) + N_FEATURES
    truth = float(np.mean(density + np.log(right)))
    assert likelihood == pytest.approx(truth + 0.5 * free / len(t), abs=0.05)
    deviations = np.sqrt(np.einsum("kij,kij->ki", fitted.factor, fitted.factor))
    np.testing.assert_allclose(deviations, 0.3, rtol=0.1)
    # with the slopes exchanged, the law is worse
    wrong = Experts(fitted.group_gate, fitted.gate, fitted.mean[::-1], fitted.factor, fitted.weight)
    near = np.ones((1, len(t)), dtype=bool)
    assert expectation(wrong, vectors, near).likelihood / len(t) < likelihood - 1.0


def test_a_class_of_rebounds_is_made_by_its_group_alone():
    """Of one rebound in twenty the first outcome is low; its class has the first group."""
    rng = np.random.default_rng(9)
    t, slow = rng.normal(size=(8000, WIDTH)), rng.random(8000) < 0.05
    scores = rng.normal(size=(8000, 7))
    scores[:, 0] = np.where(slow, -4.0 + 0.1 * scores[:, 0], scores[:, 0])
    vectors = np.hstack([features(t), scores]).astype(np.float32)
    fitted, _ = fit_experts(vectors, N_INPUTS, 7, 4, 2, slow.astype(int), rng)
    np.testing.assert_allclose(fitted.mean[:2, 0, 0], -4.0, atol=0.1)
    assert (np.abs(fitted.mean[2:, 0, 0]) < 1.0).all()
    share = reference_softmax(features(t) @ fitted.group_gate.T)[:, 0]
    assert share.mean() == pytest.approx(slow.mean(), rel=0.1)
    # without classes, the likelihood leaves no group to them alone
    mixed, _ = fit_experts(vectors, N_INPUTS, 7, 4, 2, np.zeros(8000, dtype=int), rng)
    assert np.abs(mixed.mean[:2, 0, 0] + 4.0).max() > 0.5


@pytest.mark.parametrize("n", [5, 60, 3000])
def test_hard_samples_give_finite_numbers(n):
    """Outcomes that are constant, functions of the condition, and equal to another outcome."""
    t, scores = RNG.normal(size=(n, WIDTH)), RNG.normal(size=(n, 7))
    scores[:, 1], scores[:, 2], scores[:, 3] = 0.0, t[:, 0], scores[:, 0]
    vectors = np.hstack([features(t), scores]).astype(np.float32)
    fitted, likelihood = fit_experts(
        vectors, N_INPUTS, 7, 3, 4, np.arange(n) % 3, np.random.default_rng(2)
    )
    for part in (fitted.group_gate, fitted.gate, fitted.mean, fitted.factor, likelihood):
        assert np.isfinite(part).all()
    assert (np.einsum("kii->ki", fitted.factor) > 0.0).all()
