"""The distances to a prepared reference are those of `tablegen.accuracy.metrics`."""

import numpy as np
import pytest

from tablegen.accuracy import metrics as distances
from tablegen.studies.report.reference_sample import Reference


def states(count, seed, shift=0.0):
    rng = np.random.default_rng(seed)
    values = rng.standard_normal((count, 6))
    values[:, 1] += 0.5 * values[:, 0] + shift
    return values


@pytest.fixture(scope="module")
def reference():
    return Reference(states(3000, 1))


@pytest.mark.parametrize("shift", [0.0, 0.3])
def test_distances_are_the_same(reference, shift):
    sample = states(1000, 2, shift)
    expected = distances.ks_distances(sample, reference.state).max()
    assert reference.ks(sample) == pytest.approx(expected, abs=1e-12)
    expected = distances.correlation_error(sample, reference.state)
    assert reference.correlation_error(sample) == pytest.approx(expected, abs=1e-12)
    expected = distances.sliced_wasserstein(sample, reference.state, 32, seed=0)
    assert reference.sliced_wasserstein(sample) == pytest.approx(expected, rel=1e-9)


def test_values_that_repeat_are_counted(reference):
    # a store of few states, drawn from with replacement
    sample = states(20, 3)[np.random.default_rng(4).integers(20, size=1000)]
    expected = distances.ks_distances(sample, reference.state).max()
    assert reference.ks(sample) == pytest.approx(expected, abs=1e-12)


def test_size_that_does_not_divide_is_refused(reference):
    with pytest.raises(ValueError, match="700 states do not divide 3000"):
        reference.sliced_wasserstein(states(700, 2))


def test_classifier_sees_a_shift_and_nothing_else(reference):
    # of two samples of 1,000 the AUC has a noise of 0.6 / sqrt(1000) = 0.02; 5 of these: 6e-7
    assert abs(reference.auc(states(1000, 2), 1, 1000) - 0.5) < 0.1
    assert reference.auc(states(1000, 2, 1.0), 1, 1000) > 0.65
