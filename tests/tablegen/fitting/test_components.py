"""Classes of rebounds, components divided between them, and alias tables."""

import numpy as np
import pytest

from tablegen.fitting.components import (
    LEAST_SHARE,
    alias_table,
    allocate_components,
    rebound_classes,
)

RNG = np.random.default_rng(5)

LAWS = {
    "one component": np.array([0.3]),
    "falling by 28 decades": 10.0 ** -np.arange(28.0),
    "random": RNG.dirichlet(np.ones(64)),
    "with zeros": np.array([0.0, 3.0, 0.0, 1.0, 0.0, 0.0, 2.5, 0.0]),
    "the most components": 1.0 + np.arange(65536.0),
}


@pytest.mark.parametrize("rare", [1, 2])
def test_a_class_too_small_to_be_fitted_joins_the_other(rare):
    usual = 3 - rare
    assert rebound_classes(np.tile([1, 2, 1, 7], 100)).tolist() == [0, 1, 0, 1] * 100
    collisions = np.full(100_000, usual)
    least = int(LEAST_SHARE * len(collisions))
    collisions[: least - 1] = rare
    assert set(rebound_classes(collisions)) == {usual - 1}
    collisions[:least] = rare
    assert np.bincount(rebound_classes(collisions))[rare - 1] == least
    # ten points are a tenth of a hundred, but too few
    assert set(rebound_classes(np.array([rare] * 10 + [usual] * 90))) == {usual - 1}


def test_all_components_are_allocated_by_the_stated_power():
    for components, count in ((2, (1, 1000)), (64, (500, 500)), (64, (999, 1))):
        shares = allocate_components(components, count)
        assert sum(shares) == components
        assert min(shares) >= 1
    shares = allocate_components(10_000, (1600, 8100))
    assert shares[0] / shares[1] == pytest.approx((1600 / 8100) ** 0.75, rel=1e-3)
    assert allocate_components(64, (0, 1000)) == [0, 64]
    assert sum(allocate_components(1, (500, 500))) == 1


def law_of_columns(weight):
    """Probabilities that the columns of an alias table add up to."""
    probability, alias = alias_table(weight)
    stay = probability / 65536.0
    total = stay + np.bincount(alias, 1.0 - stay, minlength=len(weight))
    return total / len(weight)


@pytest.mark.parametrize("name", LAWS)
def test_columns_of_an_alias_table_add_up_to_the_weights(name):
    weight = LAWS[name]
    # Each probability is rounded to 16 bits, half a unit of 2**-16, and is divided by the number
    # of columns: the sum of all errors is below 2**-17.
    np.testing.assert_allclose(
        law_of_columns(weight), weight / weight.sum(), rtol=0.0, atol=2.0**-17
    )
    if name == "random":
        assert np.abs(law_of_columns(weight[::-1]) - weight).max() > 2.0**-17
