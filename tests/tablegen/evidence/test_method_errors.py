"""Means over batches, their intervals, and states that no rebound can have."""

import numpy as np
import pytest
from tablegen.evidence.method_errors import (
    batch_errors,
    batch_mean,
    batch_seed,
    forbidden_share,
)

from tablegen.accuracy.metrics import Reference


def test_interval_holds_the_mean_as_often_as_it_says():
    # 400 sets of 8: a percentile bootstrap of 8 values covers some 90 % where it says 95;
    # below 84 % of 400, by chance: 1e-4; the interval of one value alone covers nothing
    rng = np.random.default_rng(5)
    covered = 0
    for _ in range(400):
        found = batch_mean(rng.normal(1.0, 0.3, 8))
        assert found.low <= found.mean <= found.high
        covered += found.low <= 1.0 <= found.high
    assert 0.84 < covered / 400 < 0.99
    assert batch_mean([1.3]).low == batch_mean([1.3]).high == 1.3


def test_interval_shrinks_with_the_spread():
    wide, narrow = batch_mean([0.0, 1.0, 2.0, 3.0]), batch_mean([1.4, 1.5, 1.6, 1.5])
    assert wide.high - wide.low > 5.0 * (narrow.high - narrow.low)
    assert wide.mean == pytest.approx(narrow.mean)


def test_seeds_of_purposes_differ():
    seeds = {batch_seed(1, a, b) for a in range(20) for b in range(20)}
    assert len(seeds) == 400
    assert batch_seed(1, 2, 3) == batch_seed(1, 2, 3)
    assert batch_seed(2, 2, 3) != batch_seed(1, 2, 3)


def test_forbidden_states_are_counted():
    state = np.tile([0.5, 0.3, 0.0, 9.0, 9.0, 9.0], (10, 1))
    assert forbidden_share(state) == 0.0
    state[0, 1] = 0.0  # does not leave
    state[1, 2] = 0.9  # faster than before
    assert forbidden_share(state) == 0.2


def test_errors_of_a_batch():
    rng = np.random.default_rng(6)
    reference = Reference(rng.uniform(0.1, 0.4, (4000, 6)))
    errors = batch_errors(
        lambda n, seed: np.random.default_rng(seed).uniform(0.1, 0.4, (n, 6)),
        reference,
        1000,
        0,
        0,
        7,
    )
    assert set(errors) == {"ks", "sliced_wasserstein", "correlation_error", "forbidden"}
    # the KS distance of six components exceeds this by chance once in 1e5
    assert errors["ks"] < np.sqrt(np.log(12e5) / 2.0 * (1 / 1000 + 1 / 4000))
    assert errors["forbidden"] == 0.0
