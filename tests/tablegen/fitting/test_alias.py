"""Alias tables: the law that they hold, and the law that the sampler draws from them."""

import numba
import numpy as np
import pytest
from sampler.drawing.steps import choose_column, choose_component
from scipy.stats import chisquare

from tablegen.fitting.alias import alias_table

RNG = np.random.default_rng(5)

LAWS = {
    "one component": np.array([0.3]),
    "equal": np.ones(64),
    "falling by 28 decades": 10.0 ** -np.arange(28.0),
    "random": RNG.dirichlet(np.ones(64)),
    "concentrated": RNG.dirichlet(np.full(200, 0.01)),
    "with zeros": np.array([0.0, 3.0, 0.0, 1.0, 0.0, 0.0, 2.5, 0.0]),
    "one of many": np.eye(50)[17],
    "the most components": 1.0 + np.arange(65536.0),
}


@numba.njit
def components_of_words(aliases, words, components):
    """Component that the sampler's own rule chooses for each random word."""
    for k in range(words.size):
        column, fraction = choose_column(words[k], aliases.size)
        components[k] = choose_component(column, fraction, aliases[column])


def chosen(weight, words):
    probability, alias = alias_table(weight)
    components = np.empty(len(words), dtype=np.int64)
    aliases = (probability.astype(np.uint32) << 16) | alias
    components_of_words(aliases, np.asarray(words, dtype=np.uint32), components)
    return components


def held_law(weight):
    """Probabilities that the columns of an alias table add up to."""
    probability, alias = alias_table(weight)
    stay = probability / 65536.0
    total = stay + np.bincount(alias, 1.0 - stay, minlength=len(weight))
    return total / len(weight)


@pytest.mark.parametrize("name", LAWS)
def test_columns_add_up_to_the_weights(name):
    weight = LAWS[name]
    # Each stay probability is rounded to 16 bits, half a unit of 2**-16, and shared out over
    # as many columns as there are: the sum of all the errors is below 2**-17.
    np.testing.assert_allclose(held_law(weight), weight / weight.sum(), rtol=0.0, atol=2.0**-17)


def test_a_table_of_other_weights_does_not_add_up():
    weight = LAWS["random"]
    assert np.abs(held_law(weight[::-1]) - weight).max() > 2.0**-17


@pytest.mark.parametrize("name", LAWS)
def test_types_and_ranges_of_the_file(name):
    probability, alias = alias_table(LAWS[name])
    assert (probability.dtype, alias.dtype) == (np.uint16, np.uint16)
    assert probability.shape == alias.shape == LAWS[name].shape
    assert alias.max() < len(alias)


def test_weights_need_no_normalisation_and_stay_as_they_were():
    weight = LAWS["random"].copy()
    plain, scaled = alias_table(weight), alias_table(1024.0 * weight)
    np.testing.assert_array_equal(plain[0], scaled[0])
    np.testing.assert_array_equal(plain[1], scaled[1])
    np.testing.assert_array_equal(weight, LAWS["random"])


@pytest.mark.parametrize("name", ["with zeros", "one of many"])
def test_zero_weights_are_never_drawn(name):
    weight = LAWS[name]
    # The first and the last word of every column, and words all over: nothing in between can
    # choose otherwise, because a column has one threshold.
    first = -(-np.arange(len(weight)) * 2**32 // len(weight))
    last = -(-np.arange(1, len(weight) + 1) * 2**32 // len(weight)) - 1
    words = np.concatenate((first, last, np.random.default_rng(2).integers(0, 2**32, 10_000)))
    assert (weight[chosen(weight, words)] > 0.0).all()
    # The rule does reach such columns: only their stay probability of zero keeps them out.
    assert (weight[words.astype(np.int64) * len(weight) >> 32] == 0.0).any()


def test_single_component_takes_every_word():
    words = np.array([0, 1, 2**31, 2**32 - 1])
    np.testing.assert_array_equal(chosen(np.array([7.0]), words), 0)


def test_frequencies_of_the_samplers_draws():
    """Pearson's chi-square test; a right table fails with probability 1e-6."""
    weight = np.random.default_rng(8).dirichlet(np.ones(12))
    words = np.random.default_rng(9).integers(0, 2**32, 200_000)
    counts = np.bincount(chosen(weight, words), minlength=12)
    assert chisquare(counts, weight * counts.sum()).pvalue > 1e-6
    # Refused: 3 % of one component's weight given to another, and columns without aliases.
    moved = weight.copy()
    giver, taker = weight.argmax(), weight.argmin()
    moved[[giver, taker]] += [-0.03 * weight[giver], 0.03 * weight[giver]]
    counts_moved = np.bincount(chosen(moved, words), minlength=12)
    assert chisquare(counts_moved, weight * counts.sum()).pvalue < 1e-6
    columns = np.bincount(words * 12 >> 32, minlength=12)
    assert chisquare(columns, weight * counts.sum()).pvalue < 1e-6
