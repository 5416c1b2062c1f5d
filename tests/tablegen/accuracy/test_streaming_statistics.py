"""Streaming moments and histograms: those of numpy over all rebounds, in constant memory."""

import importlib
import json
import time
import tracemalloc
from dataclasses import fields
from functools import reduce

import numpy as np
import pytest
from command_line import SIMULATE, flags

from sampler.errors import InputError
from sampler.formats.channels import STATE
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
from tablegen.model.particle_run import simulate_batch
from tablegen.simulation.batches import BATCH
from tablegen.simulation.simulate import make_condition, simulate_condition

#: The module itself: `tablegen` may give its name to something else.
MODULE = importlib.import_module("tablegen.accuracy.streaming_statistics")

_CONFIG = load_config("corundum-steel")
PAIR, POPULATION = _CONFIG.pair, _CONFIG.population
NORMAL = make_condition(np.pi / 2, 200.0)

#: Two whole batches and a part of one.
COUNT = 2 * BATCH + 4321


def run(count=COUNT, condition=NORMAL, population=POPULATION, seed=31, **options):
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
    return run()


# --- What numpy says ---


def test_moments_are_those_of_all_rebounds(whole, streamed):
    assert streamed.count == COUNT
    np.testing.assert_allclose(streamed.mean, whole.state.mean(axis=0), rtol=0.0, atol=1e-14)
    expected = np.cov(whole.state, rowvar=False, bias=True)
    np.testing.assert_allclose(streamed.covariance, expected, rtol=0.0, atol=1e-14)
    np.testing.assert_allclose(streamed.standard_deviation, whole.state.std(axis=0), rtol=1e-13)
    np.testing.assert_allclose(streamed.energy, whole.energy.mean(axis=0), rtol=1e-13)


def test_extremes_and_collisions_are_those_of_all_rebounds(whole, streamed):
    np.testing.assert_array_equal(streamed.minimum, whole.state.min(axis=0))
    np.testing.assert_array_equal(streamed.maximum, whole.state.max(axis=0))
    expected = [np.sum(whole.collisions == n) for n in range(1, 6)] + [np.sum(whole.collisions > 5)]
    np.testing.assert_array_equal(streamed.collision_counts, expected)
    assert streamed.collisions == whole.collisions.sum()
    assert streamed.most_collisions == whole.collisions.max()


def test_histograms_are_those_of_all_rebounds(whole, streamed):
    for i in range(6):
        expected, _ = np.histogram(whole.state[:, i], BINS, (LOW[i], HIGH[i]))
        np.testing.assert_array_equal(streamed.histogram[i], expected)
        below, above = np.sum(whole.state[:, i] < LOW[i]), np.sum(whole.state[:, i] > HIGH[i])
        np.testing.assert_array_equal(streamed.outside[i], [below, above])


def test_default_population_without_spin_stays_inside_the_histograms(streamed):
    assert streamed.outside.sum() == 0
    np.testing.assert_array_equal(streamed.histogram.sum(axis=1), COUNT)


def test_statistics_of_a_simulation_at_hand_are_the_same(whole, streamed):
    assert_identical(statistics_of(whole), streamed)


def test_another_seed_or_stream_gives_other_statistics(streamed):
    for other in (run(seed=32), run(stream=1)):
        assert not np.any(other.mean == streamed.mean)
        assert not np.array_equal(other.histogram, streamed.histogram)


# --- Ends of the histograms ---


def test_values_outside_are_counted_and_not_put_into_the_end_bins():
    state = np.tile(0.5 * (LOW + HIGH), (5, 1))
    state[0], state[1], state[2], state[3] = LOW, HIGH, LOW - 1e-9, HIGH + 1e-9
    made = summarise(state, np.ones(5, dtype=np.int64), np.zeros((5, 2)))
    np.testing.assert_array_equal(made.outside, [[1, 1]] * 6)
    expected = np.zeros(BINS)
    expected[[0, BINS // 2, BINS - 1]] = 1
    np.testing.assert_array_equal(made.histogram, [expected] * 6)


def test_spin_reaches_outside():
    condition = make_condition(np.radians(45.0), 200.0, (0.0, 0.0, 50.0))
    made = run(1000, condition)
    assert made.outside[5].sum() > 500
    np.testing.assert_array_equal(made.histogram.sum(axis=1) + made.outside.sum(axis=1), 1000)


# --- Merging ---


def random_run(rng, count, centre=0.0):
    """Rebounds that need not be physical."""
    state = centre + rng.normal(size=(count, 6))
    return state, rng.integers(1, 9, count), rng.random((count, 2))


def test_merging_is_summarising_together():
    rng = np.random.default_rng(33)
    first, second = random_run(rng, 700), random_run(rng, 41, centre=3.0)
    merged = merge(summarise(*first), summarise(*second))
    together = summarise(*(np.concatenate(pair) for pair in zip(first, second, strict=True)))
    for field in fields(merged):
        one, other = getattr(merged, field.name), getattr(together, field.name)
        np.testing.assert_allclose(one, other, rtol=1e-12, atol=1e-12, err_msg=field.name)


def test_nothing_cancels_far_from_zero():
    # 50 batches around 1e6 with spread 1: a difference of sums of squares keeps no digit
    rng = np.random.default_rng(34)
    parts = [random_run(rng, 100, centre=1e6) for _ in range(50)]
    total = reduce(merge, (summarise(*part) for part in parts))
    state = np.concatenate([part[0] for part in parts])
    expected = np.cov(state, rowvar=False, bias=True)
    np.testing.assert_allclose(total.covariance, expected, rtol=0.0, atol=1e-8)
    naive = state.T @ state / len(state) - np.outer(total.mean, total.mean)
    assert np.abs(naive - expected).max() > 1e-6


def test_one_rebound_has_statistics():
    made = run(1)
    assert made.count == made.collision_counts.sum() == 1
    np.testing.assert_array_equal(made.covariance, 0.0)
    np.testing.assert_array_equal(made.minimum, made.maximum)


# --- Threads and memory ---


@pytest.mark.processor
@pytest.mark.parametrize("threads", [1, 2, 3])
def test_number_of_threads_changes_no_bit(streamed, threads):
    assert_identical(run(threads=threads), streamed)


def test_order_of_merging_changes_bits(whole):
    # so the test above would see batches merged as they come
    every = whole.state, whole.collisions, whole.energy
    parts = [summarise(*(x[s : s + BATCH] for x in every)) for s in range(0, COUNT, BATCH)]
    forward, backward = merge(merge(*parts[:2]), parts[2]), merge(merge(*parts[:0:-1]), parts[0])
    assert not np.array_equal(forward.comoment, backward.comoment)


def test_slow_first_batch_changes_no_bit_and_lets_nothing_pile_up(monkeypatch):
    monkeypatch.setattr("tablegen.simulation.batches.BATCH", 100)
    expected = run(3000, threads=2)
    work, started, meanwhile = MODULE._batch_statistics, [], []

    def slow_first(*arguments):
        start = arguments[-1].start
        started.append(start)
        if start == 0:
            time.sleep(0.5)
            meanwhile.extend(started)
        return work(*arguments)

    monkeypatch.setattr(MODULE, "_batch_statistics", slow_first)
    assert_identical(run(3000, threads=2), expected)
    assert sorted(started) == list(range(0, 3000, 100))
    # the other thread went on, but not far
    assert 1 < len(meanwhile) <= 5


def peak_memory(function, *arguments, **options):
    """Largest memory held during a call, in bytes."""
    tracemalloc.start()
    try:
        function(*arguments, **options)
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def test_memory_does_not_grow_with_the_count():
    spheres = POPULATION.restricted_to("sphere")
    run(BATCH, population=spheres, threads=2)  # compiles
    small, large = (
        peak_memory(run, count, population=spheres, threads=2) for count in (100_000, 1_000_000)
    )
    assert large < 1.2 * small
    assert large < 5e6
    # the measure sees memory that does grow
    every = (PAIR, spheres, NORMAL)
    assert peak_memory(simulate_condition, *every, 1_000_000, seed=31, threads=2) > 80e6


# --- What is refused ---


def test_bad_arguments_are_refused():
    """As for `simulate_condition`, whose tests have every argument."""
    with pytest.raises(InputError, match=r"^count: got 0, allowed: 1 or more$"):
        run(0)


def test_particle_in_endless_contact_is_an_error(monkeypatch):
    real = simulate_batch

    def stuck_in_second(*arguments):
        keys = arguments[3]
        return 7 if keys.particle[0] == BATCH else real(*arguments)

    monkeypatch.setattr("tablegen.simulation.batches.simulate_batch", stuck_in_second)
    message = f"particle {BATCH + 7} of seed 31, stream 0 is .* contact_resolution"
    with pytest.raises(RuntimeError, match=message):
        run()


# --- Command line ---


class TestCommand:
    def test_statistics_alone(self, run, tmp_path, whole, streamed):
        file = tmp_path / "s.json"
        words = flags(SIMULATE, {"--alpha": 90, "--count": COUNT, "--seed": 31})
        assert run("simulate", *words, "--statistics", file, "--quiet").status == 0
        written = json.loads(file.read_text())
        condition = {
            "pair": "corundum-steel",
            "shape": "mixture",
            "aspect": None,
            "alpha_deg": 90.0,
            "speed": 200.0,
            "spin": [0.0, 0.0, 0.0],
            "seed": 31,
        }
        assert {name: written[name] for name in condition} == condition
        assert {name: written[name] for name in streamed.to_dict()} == streamed.to_dict()
        assert written["mean"] == dict(zip(STATE, streamed.mean.tolist(), strict=True))
        assert list(written["collisions_percent"]) == list(COLLISION_LABELS)
        single = 100.0 * np.mean(whole.collisions == 1)
        assert written["collisions_percent"]["1"] == pytest.approx(single)
        assert sum(written["collisions_percent"].values()) == pytest.approx(100.0)
        assert written["histogram"]["v"]["low"] == 0.0

    def test_both_outputs_are_of_the_same_rebounds(self, run, tmp_path):
        files = tmp_path / "s.json", tmp_path / "r.npz"
        words = flags(SIMULATE, {"--statistics": files[0], "--output": files[1]})
        assert run("simulate", *words, "--quiet").status == 0
        state = np.load(files[1])["state"]
        mean = list(json.loads(files[0].read_text())["mean"].values())
        np.testing.assert_allclose(mean, state.mean(axis=0), rtol=0.0, atol=1e-14)

    def test_one_of_the_outputs_is_needed_and_not_both_in_one(self, refused, tmp_path):
        line = refused("simulate", *flags(SIMULATE, {}))
        assert line == "Missing option '--output' or '--statistics', allowed: one or both"
        file = tmp_path / "x"
        line = refused("simulate", *flags(SIMULATE, {"--output": file, "--statistics": file}))
        assert line == f"--statistics: got {file}, the same file as --output, allowed: another"

    def test_statistics_file_is_checked_before_any_work(self, refused, tmp_path, monkeypatch):
        monkeypatch.setattr("tablegen.accuracy.streaming_statistics.simulate_statistics", None)
        words = flags(SIMULATE, {"--statistics": tmp_path / "none" / "s.json"})
        assert "'--statistics'" in (line := refused("simulate", *words))
        assert "a folder that exists" in line
