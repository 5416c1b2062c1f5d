"""Baselines draw from what they were fitted to, and direct simulation follows its settings."""

import importlib.util
from dataclasses import replace

import numpy as np
import pytest
from tablegen.evidence.direct_method import direct_methods
from tablegen.evidence.sampling_methods import CONDITION, BenchmarkCase

from tablegen.config.config import load_config
from tablegen.evidence import baselines
from tablegen.simulation.simulate import simulate

CONFIG = load_config("corundum-steel")
COUNT = 4000


@pytest.fixture(scope="module")
def case():
    state = simulate(CONFIG, np.radians(45.0), 200.0, COUNT, seed=1).state
    return BenchmarkCase(CONFIG, 45.0, 200.0, state, 2)


def methods():
    return baselines.baseline_methods()[0]


@pytest.mark.parametrize("method", methods(), ids=lambda method: f"{method.family}-{method.name}")
def test_baselines_draw_states_like_those_they_were_fitted_to(case, method):
    ready = method.prepare(case)
    drawn = ready.draw(COUNT, 3)
    assert drawn.shape == (COUNT, 6)
    assert np.array_equal(drawn, ready.draw(COUNT, 3))
    assert not np.array_equal(drawn, ready.draw(COUNT, 4))
    # five standard errors of a difference of means in six components: 4e-6 by chance; kernel
    # estimates and mixtures keep the mean as well
    gap = np.abs(drawn.mean(axis=0) - case.training.mean(axis=0))
    assert np.all(gap < 5.0 * case.training.std(axis=0) * np.sqrt(2.0 / COUNT))
    assert method.covers == CONDITION
    assert ready.size > 0


def test_independent_marginals_lose_the_correlations_and_the_vine_keeps_them(case):
    truth = np.corrcoef(case.training.T)
    by_family = {method.family: method for method in methods()}
    strongest = np.unravel_index(np.abs(np.triu(truth, 1)).argmax(), truth.shape)
    assert abs(truth[strongest]) > 0.5
    drawn = by_family["independent marginals"].prepare(case).draw(COUNT, 5)
    assert abs(np.corrcoef(drawn.T)[strongest]) < 0.1
    if "vine copula" in by_family:
        drawn = by_family["vine copula"].prepare(case).draw(COUNT, 5)
        assert np.corrcoef(drawn.T)[strongest] == pytest.approx(truth[strongest], abs=0.15)


def test_stored_states_are_those_of_the_store(case):
    drawn = baselines.stored_states(case, 50).draw(1000, 1)
    store = {row.tobytes() for row in case.training[:50].astype(np.float32)}
    assert {row.tobytes() for row in drawn.astype(np.float32)} <= store


def test_a_baseline_that_is_not_installed_is_left_out_with_a_line(monkeypatch):
    real = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name: None if name == "pyvinecopulib" else real(name)
    )
    found, left_out = baselines.baseline_methods()
    assert "vine copula" not in {method.family for method in found}
    assert len(left_out) == 1
    assert "vine copula: left out, pyvinecopulib is not installed" in left_out[0]


def test_direct_methods_follow_their_settings(case):
    # slow contacts, which the resolution decides, are frequent at normal impact
    steep = replace(case, alpha_deg=90.0)
    every = {method.name: method.prepare(steep).draw(2000, 9) for method in direct_methods()}
    default = every.pop("as configured")
    assert np.array_equal(default, simulate(CONFIG, np.pi / 2, 200.0, 2000, seed=9).state)
    moved = {name: np.abs(states - default).mean() for name, states in every.items()}
    assert min(moved.values()) > 0.0, moved
    assert moved["contact resolution 0.1"] > 10.0 * moved["contact resolution 0.0001"]
    assert moved["flight tolerance 0.0001"] > moved["flight tolerance 1e-06"]
