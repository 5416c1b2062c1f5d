"""Classes of rebounds and how the components are shared out between them."""

import numpy as np
import pytest

from tablegen.fitting.classes import CLASSES, LEAST_SHARE, allocate_components, class_of


def test_single_and_repeated():
    collisions = np.tile([1, 2, 1, 7], 100)
    np.testing.assert_array_equal(class_of(collisions), np.tile([0, 1, 0, 1], 100))
    assert len(CLASSES) == 2


@pytest.mark.parametrize("rare", [1, 2])
def test_a_class_too_small_to_be_fitted_joins_the_other(rare):
    usual = 3 - rare
    collisions = np.full(100_000, usual)
    least = int(LEAST_SHARE * len(collisions))
    collisions[: least - 1] = rare
    assert set(class_of(collisions)) == {usual - 1}
    collisions[:least] = rare
    assert np.bincount(class_of(collisions))[rare - 1] == least


def test_few_points_are_one_class():
    """A share of a tenth, but of only a hundred points: ten cannot be fitted."""
    assert set(class_of(np.array([1] * 10 + [2] * 90))) == {1}


@pytest.mark.parametrize("components", [2, 3, 64, 257])
@pytest.mark.parametrize("count", [(1, 1000), (500, 500), (999, 1), (150, 850)])
def test_all_components_are_allocate_components(components, count):
    shares = allocate_components(components, count)
    assert sum(shares) == components
    assert min(shares) >= 1
    if components > 3:
        assert (shares[0] >= shares[1]) == (count[0] >= count[1])


def test_shares_follow_the_stated_power():
    shares = allocate_components(10_000, (1600, 8100))
    assert shares[0] / shares[1] == pytest.approx((1600 / 8100) ** 0.75, rel=1e-3)


def test_empty_class_gets_none():
    assert allocate_components(64, (0, 1000)) == [0, 64]
    assert allocate_components(1, (1000, 0)) == [1, 0]
