"""One leaf: fitted to rebounds of a known law, stored, and drawn from, it gives that law back."""

import numpy as np
import pytest
from scipy.stats import ks_2samp, norm
from spin_laws import folded_inputs

from sampler.formats.bounds import N_EXPERTS, N_FEATURES, N_INPUTS, SCORE_MAX
from tablegen.fitting.leaf import Rebounds, fit_leaf
from tablegen.fitting.resolution import SpinSizes
from tablegen.fitting.spin_coordinates import features
from tablegen.fitting.spin_scores import StoredExperts, bounded_scores

N = 20_000
SIZES = SpinSizes(1, 1, 4, 4, 4, N, 97)


def rebounds(rng, root_angle=None, outcomes=7):
    """A law with two branches in which the first outcome depends on the angle and on the spin.

    p_v is log-normal, p_w is the sum of p_u and noise, and all others are noise.
    """
    inputs = folded_inputs(N, rng)
    inputs[:, 8] = 0.8  # all grains have one c/b
    if root_angle is not None:
        inputs[:, 0] = root_angle
    slides = rng.random(N) < norm.cdf(3.0 * (inputs[:, 0] - 0.6))
    noise = rng.standard_normal((N, outcomes))
    values = noise.copy()
    values[:, 0] = np.where(slides, 2.0 + inputs[:, 4], -2.0 - inputs[:, 0]) + 0.3 * noise[:, 0]
    values[:, 1] = np.exp(0.5 * noise[:, 1] - inputs[:, 0])
    values[:, 2] = values[:, 0] + 0.5 * noise[:, 2]
    return Rebounds(inputs, values)


def draw_outcomes(leaf, inputs, rng):
    """Outcomes of a stored leaf at some inputs, as a draw makes them."""
    experts = StoredExperts(leaf.group_gate, leaf.gate, leaf.mean, leaf.factor)
    t = (inputs[:, :N_INPUTS] - leaf.centre) * leaf.scale
    phi = features(np.column_stack([t, inputs[:, N_INPUTS:]]), np.float32)
    scores = bounded_scores(experts, phi, rng)
    knots = np.linspace(-SCORE_MAX, SCORE_MAX, leaf.quantiles.shape[1])
    columns = zip(scores.T, leaf.quantiles, strict=True)
    return np.column_stack([np.interp(score, knots, row) for score, row in columns])


@pytest.fixture(scope="module")
def leaf():
    rng = np.random.default_rng(1)
    return fit_leaf(rebounds(rng), np.ones(N, dtype=bool), SIZES, rng)


@pytest.mark.parametrize("root_angle", [None, 0.4, 0.6, 0.8])
def test_draws_follow_the_law_over_the_leaf_and_at_each_condition(leaf, root_angle):
    """KS of 20,000 draws: 0.016 by chance with p = 0.01.

    The quantiles come from 20,000 rebounds and as many scores, so 0.023 occurs by chance.
    """
    known = rebounds(np.random.default_rng(2), root_angle)
    drawn = draw_outcomes(leaf, known.inputs, np.random.default_rng(3))
    whole = root_angle is None
    pairs = zip(drawn.T, known.outcomes.T, strict=True)
    distances = [ks_2samp(*pair).statistic for pair in pairs]
    assert max(distances) < (0.025 if whole else 0.05)
    # the dependence between outcomes, too
    differences = [ks_2samp(*(x[:, 2] - x[:, 0] for x in (drawn, known.outcomes))).statistic]
    assert max(differences) < 0.05
    if not whole:  # and at another angle the law is another one
        other = rebounds(np.random.default_rng(2), root_angle + 0.2).outcomes
        assert ks_2samp(drawn[:, 0], other[:, 0]).statistic > 0.1


def test_is_stored_as_a_file_has_it(leaf):
    assert leaf.mean.shape == (N_EXPERTS, N_FEATURES, 7)
    assert leaf.factor.shape == (N_EXPERTS, 28)
    assert leaf.quantiles.shape == (7, 97)
    assert (np.diff(leaf.quantiles, axis=1) >= 0.0).all()
    assert (leaf.quantiles[1] > 0.0).all()
    diagonal = [row * (row + 3) // 2 for row in range(7)]
    assert (leaf.factor[:, diagonal] > 0).all()
    # an input that does not vary counts nowhere
    assert leaf.scale[8] == 0.0
    assert (leaf.scale[:8] > 0.0).all()
    assert not leaf.mean[:, 9].any()


def test_with_works_and_where_quantiles_of_p_v_would_be_negative():
    rng = np.random.default_rng(4)
    inputs, outcomes = rebounds(rng, outcomes=8)
    leaf = fit_leaf(Rebounds(inputs, outcomes - 1.0), np.ones(N, dtype=bool), SIZES, rng)
    assert leaf.mean.shape == (N_EXPERTS, N_FEATURES, 8)
    assert leaf.quantiles[1, 0] > 0.0
