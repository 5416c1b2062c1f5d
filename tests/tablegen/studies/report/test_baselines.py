"""The rivals draw what they are said to draw."""

import importlib.util
from dataclasses import replace

import numpy as np
import pytest

from tablegen.config import load_config
from tablegen.studies.report import baselines as rivals
from tablegen.studies.report.direct_method import direct_states, direct_ways
from tablegen.studies.report.sampling_methods import CONDITION, Scene

CONFIG = load_config("corundum-steel")
COUNT = 4000


@pytest.fixture(scope="module")
def scene():
    return Scene(CONFIG, 45.0, 200.0, direct_states(CONFIG, 45.0, 200.0, COUNT, 1), 2)


def ways():
    return rivals.rival_ways()[0]


@pytest.mark.parametrize("way", ways(), ids=lambda way: f"{way.family}-{way.name}")
def test_rivals_draw_states_like_those_they_were_fitted_to(scene, way):
    ready = way.prepare(scene)
    drawn = ready.draw(COUNT, 3)
    assert drawn.shape == (COUNT, 6)
    assert np.array_equal(drawn, ready.draw(COUNT, 3))
    assert not np.array_equal(drawn, ready.draw(COUNT, 4))
    # five standard errors of a difference of means in six components: 4e-6 by chance; kernel
    # estimates and mixtures keep the mean as well
    gap = np.abs(drawn.mean(axis=0) - scene.training.mean(axis=0))
    assert np.all(gap < 5.0 * scene.training.std(axis=0) * np.sqrt(2.0 / COUNT))
    assert way.covers == CONDITION
    assert ready.size > 0


def test_independent_marginals_lose_the_correlations_and_the_vine_keeps_them(scene):
    truth = np.corrcoef(scene.training.T)
    by_family = {way.family: way for way in ways()}
    strongest = np.unravel_index(np.abs(np.triu(truth, 1)).argmax(), truth.shape)
    assert abs(truth[strongest]) > 0.5
    drawn = by_family["independent marginals"].prepare(scene).draw(COUNT, 5)
    assert abs(np.corrcoef(drawn.T)[strongest]) < 0.1
    if "vine copula" in by_family:
        drawn = by_family["vine copula"].prepare(scene).draw(COUNT, 5)
        assert np.corrcoef(drawn.T)[strongest] == pytest.approx(truth[strongest], abs=0.15)


def test_stored_states_are_those_of_the_store(scene):
    drawn = rivals.stored_states(scene, 50).draw(1000, 1)
    store = {row.tobytes() for row in scene.training[:50].astype(np.float32)}
    assert {row.tobytes() for row in drawn.astype(np.float32)} <= store


def test_a_rival_that_is_not_installed_is_left_out_with_a_line(monkeypatch):
    real = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name: None if name == "pyvinecopulib" else real(name)
    )
    found, left_out = rivals.rival_ways()
    assert "vine copula" not in {way.family for way in found}
    assert len(left_out) == 1
    assert "vine copula: left out, pyvinecopulib is not installed" in left_out[0]


def test_direct_ways_follow_their_settings(scene):
    # slow contacts, which the resolution decides, are frequent at normal impact
    steep = replace(scene, alpha_deg=90.0)
    every = {way.name: way.prepare(steep).draw(2000, 9) for way in direct_ways()}
    default = every.pop("as configured")
    assert np.array_equal(default, direct_states(CONFIG, 90.0, 200.0, 2000, 9))
    moved = {name: np.abs(states - default).mean() for name, states in every.items()}
    assert min(moved.values()) > 0.0, moved
    assert moved["contact resolution 0.1"] > 10.0 * moved["contact resolution 0.0001"]
    assert moved["flight tolerance 0.0001"] > moved["flight tolerance 1e-06"]
