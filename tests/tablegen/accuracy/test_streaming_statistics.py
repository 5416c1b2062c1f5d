"""Streaming moments and histograms: those of numpy over all rebounds, in constant memory."""

import json
import tracemalloc
from dataclasses import fields
from functools import reduce

import numpy as np
import pytest
from command_line import SIMULATE, flags

from tablegen.accuracy.streaming_statistics import (
    BINS,
    COLLISION_LABELS,
    HIGH,
    LOW,
    merge,
    simulate_statistics,
    statistics_of,
    summarise,
)
from tablegen.config.config import load_config
from tablegen.simulation.batches import BATCH
from tablegen.simulation.simulate import make_condition, simulate_condition

_CONFIG = load_config("corundum-steel")
PAIR, POPULATION = _CONFIG.pair, _CONFIG.population
NORMAL = make_condition(np.pi / 2, 200.0)

#: Two whole batches and a part of one.
COUNT = 2 * BATCH + 4321


def run_of(count=COUNT, condition=NORMAL, population=POPULATION, seed=31, **options):
    return simulate_statistics(PAIR, population, condition, count, seed=seed, **options)


def assert_identical(one, other):
    """Both agree to the last bit."""
    for field in fields(one):
        a, b = getattr(one, field.name), getattr(other, field.name)
        np.testing.assert_array_equal(a, b, err_msg=field.name)


@pytest.fixture(scope="module")
def whole():
    """All rebounds of the run."""
    return simulate_condition(PAIR, POPULATION, NORMAL, COUNT, seed=31)


@pytest.fixture(scope="module")
def streamed():
    return run_of()


def test_statistics_are_those_of_all_rebounds(whole, streamed):
    assert streamed.count == COUNT
    np.testing.assert_allclose(streamed.mean, whole.state.mean(axis=0), rtol=0.0, atol=1e-14)
    expected = np.cov(whole.state, rowvar=False, bias=True)
    np.testing.assert_allclose(streamed.covariance, expected, rtol=0.0, atol=1e-14)
    np.testing.assert_allclose(streamed.standard_deviation, whole.state.std(axis=0), rtol=1e-13)
    np.testing.assert_allclose(streamed.energy, whole.energy.mean(axis=0), rtol=1e-13)
    np.testing.assert_array_equal(streamed.minimum, whole.state.min(axis=0))
    np.testing.assert_array_equal(streamed.maximum, whole.state.max(axis=0))
    expected = [np.sum(whole.collisions == n) for n in range(1, 6)] + [np.sum(whole.collisions > 5)]
    np.testing.assert_array_equal(streamed.collision_counts, expected)
    assert streamed.collisions == whole.collisions.sum()
    assert streamed.most_collisions == whole.collisions.max()
    for i in range(6):
        expected, _ = np.histogram(whole.state[:, i], BINS, (LOW[i], HIGH[i]))
        np.testing.assert_array_equal(streamed.histogram[i], expected)
    # the default population without spin stays inside the histograms
    assert streamed.outside.sum() == 0


@pytest.mark.processor
@pytest.mark.parametrize("threads", [1, 3])
def test_number_of_threads_changes_no_bit(whole, streamed, threads):
    assert_identical(run_of(threads=threads), streamed)
    assert_identical(statistics_of(whole), streamed)


def test_values_outside_are_counted_and_not_put_into_the_end_bins():
    state = np.tile(0.5 * (LOW + HIGH), (5, 1))
    state[0], state[1], state[2], state[3] = LOW, HIGH, LOW - 1e-9, HIGH + 1e-9
    made = summarise(state, np.ones(5, dtype=np.int64), np.zeros((5, 2)))
    np.testing.assert_array_equal(made.outside, [[1, 1]] * 6)
    expected = np.zeros(BINS)
    expected[[0, BINS // 2, BINS - 1]] = 1
    np.testing.assert_array_equal(made.histogram, [expected] * 6)


def test_nothing_cancels_far_from_zero():
    # 50 batches around 1e6 with spread 1: a difference of sums of squares keeps no digit
    rng = np.random.default_rng(34)
    parts = [1e6 + rng.normal(size=(100 + k, 6)) for k in range(50)]
    rest = [(rng.integers(1, 9, len(part)), rng.random((len(part), 2))) for part in parts]
    total = reduce(merge, (summarise(part, *more) for part, more in zip(parts, rest, strict=True)))
    state = np.concatenate(parts)
    expected = np.cov(state, rowvar=False, bias=True)
    np.testing.assert_allclose(total.covariance, expected, rtol=0.0, atol=1e-8)
    naive = state.T @ state / len(state) - np.outer(total.mean, total.mean)
    assert np.abs(naive - expected).max() > 1e-6


def test_memory_does_not_grow_with_the_count():
    spheres = POPULATION.restricted_to("sphere")
    run_of(BATCH, population=spheres, threads=2)  # compiles
    peaks = []
    for count in (100_000, 500_000):
        tracemalloc.start()
        run_of(count, population=spheres, threads=2)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    # all states of the longer run take 24 MB
    assert peaks[1] < min(1.3 * peaks[0], 8e6)


def test_command_writes_the_statistics(run, refused, tmp_path, streamed):
    file = tmp_path / "s.json"
    words = flags(SIMULATE, {"--alpha": 90, "--count": COUNT, "--seed": 31})
    assert run("simulate", *words, "--statistics", file, "--quiet").status == 0
    written, expected = json.loads(file.read_text()), streamed.to_dict()
    assert {name: written[name] for name in expected} == expected
    assert (written["pair"], written["alpha_deg"]) == ("corundum-steel", 90.0)
    assert list(written["collisions_percent"]) == list(COLLISION_LABELS)
    line = refused("simulate", *flags(SIMULATE, {}))
    assert line == "Missing option '--output' or '--statistics', allowed: one or both"
