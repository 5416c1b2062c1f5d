"""Methods of sampling: baselines, direct simulation and tables; errors of batches."""

from dataclasses import replace

import numpy as np
import pytest
from refusals import refused
from tiny_tables import TINY

import sampler
from sampler.formats.hdf5 import read_table, write_table
from tablegen.config.config import load_config
from tablegen.evidence import methods
from tablegen.evidence.benchmark import Budget, batch_errors, batch_mean, forbidden_share
from tablegen.simulation.simulate import simulate
from tablegen.tables.prune import prune

CONFIG = load_config("corundum-steel")
COUNT = 2000


@pytest.fixture(scope="module")
def case():
    state = simulate(CONFIG, np.radians(45.0), 200.0, COUNT, seed=1).state
    return methods.BenchmarkCase(CONFIG, 45.0, 200.0, state, 2)


@pytest.mark.parametrize("method", methods.baseline_methods(), ids=lambda method: method.name)
def test_baselines_draw_states_like_those_they_were_fitted_to(case, method):
    ready = method.prepare(case)
    drawn = ready.draw(COUNT, 3)
    assert np.array_equal(drawn, ready.draw(COUNT, 3))
    assert not np.array_equal(drawn, ready.draw(COUNT, 4))
    # five standard errors of a difference of means in six variables: 4e-6 by chance; kernel
    # estimates and mixtures keep the mean as well
    gap = np.abs(drawn.mean(axis=0) - case.training.mean(axis=0))
    assert np.all(gap < 5.0 * case.training.std(axis=0) * np.sqrt(2.0 / COUNT))
    assert ready.size > 0


def test_independent_marginals_lose_the_correlations(case):
    truth = np.corrcoef(case.training.T)
    strongest = np.unravel_index(np.abs(np.triu(truth, 1)).argmax(), truth.shape)
    assert abs(truth[strongest]) > 0.5
    drawn = methods.independent_marginals(case).draw(COUNT, 5)
    assert abs(np.corrcoef(drawn.T)[strongest]) < 0.1


def test_direct_methods_follow_their_settings(case):
    # slow contacts, which the resolution decides, are frequent at normal impact
    steep = replace(case, alpha_deg=90.0)
    every = {m.name: m.prepare(steep).draw(2000, 9) for m in methods.direct_methods()}
    default = every.pop("as configured")
    assert np.array_equal(default, simulate(CONFIG, np.pi / 2, 200.0, 2000, seed=9).state)
    moved = {name: np.abs(states - default).mean() for name, states in every.items()}
    assert min(moved.values()) > 0.0
    assert moved["contact resolution 0.1"] > 10.0 * moved["contact resolution 0.0001"]
    assert moved["flight tolerance 0.0001"] > moved["flight tolerance 1e-06"]


def test_tables_beside_are_of_the_pair_the_range_and_all_variables(tiny, tmp_path):
    mine, other, part = sampler.load(tiny.path), tmp_path / "other.h5", tmp_path / "part.h5"
    write_table(other, replace(read_table(tiny.path), pair="sand-glass"))
    assert "pair: got sand-glass" in refused(other, methods.other_table, str(other), mine)
    whole = sampler.load("corundum-steel")
    assert "alpha_range" in refused(tiny.path, methods.other_table, str(tiny.path), whole)
    prune(tiny.path, TINY.with_changes({"domain": {"variables": ["u", "v"]}}), part)
    assert "variables u, v" in refused(part, methods.load_whole, str(part))


def test_interval_holds_the_mean_as_often_as_it_says():
    # a percentile bootstrap of 8 values covers some 90 % where it says 95; below 84 %: 1e-4
    rng = np.random.default_rng(5)
    covered = 0
    for _ in range(400):
        interval = batch_mean(rng.normal(1.0, 0.3, 8))
        assert interval.low <= interval.mean <= interval.high
        covered += interval.low <= 1.0 <= interval.high
    assert 0.84 < covered / 400 < 0.99
    assert batch_mean([1.3]).low == batch_mean([1.3]).high == 1.3


def test_forbidden_states_are_counted():
    state = np.tile([0.5, 0.3, 0.0, 9.0, 9.0, 9.0], (10, 1))
    assert forbidden_share(state) == 0.0
    state[0, 1] = 0.0  # does not leave
    state[1, 2] = 0.9  # faster than before
    assert forbidden_share(state) == 0.2


def test_errors_of_a_batch_of_the_same_law_are_noise():
    rng = np.random.default_rng(6)
    reference = rng.uniform(0.1, 0.4, (4000, 6))

    def draw(n, seed):
        return np.random.default_rng(seed).uniform(0.1, 0.4, (n, 6))

    errors = batch_errors(draw, reference, Budget(batch=1000, classified=400), 0, 7)
    # the KS distance of six variables exceeds this by chance once in 1e5
    assert errors["ks"] < np.sqrt(np.log(12e5) / 2.0 * (1 / 1000 + 1 / 4000))
    assert errors["forbidden"] == 0.0
    shifted = batch_errors(lambda *a: draw(*a) + 0.1, reference, Budget(batch=1000), 0, 7)
    assert shifted["ks"] > 0.2
