"""Conditions of the fit: within what the law covers, and everywhere in it."""

import math

import numpy as np
import pytest
from mesh_fixtures import box

from sampler.formats.bounds import SPEED
from sampler.formats.shape_codes import FIRST_MESH, SHAPE_CODES
from tablegen.config.config import load_config
from tablegen.config.mesh import MeshFile
from tablegen.fitting.law_conditions import (
    Range,
    draw_ratios,
    ratio_range,
    spinning_conditions,
    spread_conditions,
    still_conditions,
)
from tablegen.simulation.direct import DirectModel
from tablegen.simulation.impact_chains import energy_factor

CONFIG = load_config("corundum-steel").with_changes(
    {"domain": {"speed": [5.0, 300.0], "extrapolate": True}}
)
DOMAIN = Range.of(CONFIG)
N = 4000


def test_covers_the_angles_and_twice_the_speeds():
    assert DOMAIN.alpha == (math.radians(0.5), math.pi / 2.0)
    assert DOMAIN.speed == (5.0, 600.0)
    assert DOMAIN.first_speed == (50.0, 300.0)
    assert SPEED[0] < DOMAIN.speed[0]


@pytest.mark.parametrize("made", [spread_conditions, still_conditions])
def test_conditions_fill_the_domain(made):
    found = made(DOMAIN, N, np.random.default_rng(1))
    factor = energy_factor(found[:, 2:])
    effective, sigma = found[:, 1] * factor, np.linalg.norm(found[:, 2:], axis=1) / factor
    assert (DOMAIN.alpha[0] <= found[:, 0]).all()
    assert (found[:, 0] <= DOMAIN.alpha[1]).all()
    assert (effective > 5.0 * (1.0 - 1e-9)).all()
    assert (effective < 600.0 * (1.0 + 1e-9)).all()
    # a sixth of the domain has at least a twentieth of them, on each axis
    for values, ends in ((found[:, 0], DOMAIN.alpha), (effective, DOMAIN.speed)):
        assert (np.histogram(values, 6, ends)[0] > N / 20).all()
    if made is still_conditions:
        assert not found[:, 2:].any()
    else:
        assert (np.histogram(sigma, 6, (0.0, math.sqrt(1.5)))[0] > N / 20).all()
        assert np.abs(found[:, 2:].mean(axis=0) / found[:, 2:].std(axis=0)).max() < 0.1


def test_no_condition_is_beyond_the_direct_model():
    """At the ends of what a domain may be, particles turn at most a million radians first."""
    domain = Range((math.radians(1e-6), math.pi / 2.0), (1e-6, 2e5), (1e-6, 1e5))
    found = spread_conditions(domain, N, np.random.default_rng(6))
    turned = 2.0 * np.linalg.norm(found[:, 2:], axis=1) / np.sin(found[:, 0])
    assert turned.max() < 1e6
    assert found[:, 1].min() >= 1e-6


def test_half_of_the_conditions_are_those_of_chains():
    model = DirectModel(CONFIG)
    hits = []

    def rebound(conditions, grains, hit):
        hits.append(hit)
        return model.sample(
            conditions[:, 0],
            conditions[:, 1],
            spin=conditions[:, 2:],
            grain=grains,
            seed=3,
            index=np.arange(len(grains)),
            hit=hit,
        )

    code = SHAPE_CODES["prism"]
    rng = np.random.default_rng(2)
    found, grains = spinning_conditions(DOMAIN, CONFIG.population, code, N, rebound, rng)
    assert hits == [1, 2, 3, 4, 5]
    assert 0.8 * N < len(found) <= N + 5
    assert DOMAIN.holds(found).all()
    assert (grains[:, 0] == code).all()
    assert (grains[:, 1:] >= 0.5).all()
    assert (grains[:, 1:] <= 1.0).all()
    # of the study: what spins backwards is what occurs on the same wall
    assert 0.5 < np.median(np.linalg.norm(found[:, 2:], axis=1)) < 1.5


def test_ratios_are_of_the_law_and_even_over_its_range():
    rng = np.random.default_rng(4)
    ratios = draw_ratios(CONFIG.population, SHAPE_CODES["prism"], 20_000, rng)
    assert ratios.min() >= 0.5
    assert ratios.max() <= 1.0
    # the mean of the truncated law is 0.775, that of even ratios 0.75
    assert ratios.mean() == pytest.approx(0.5 * (0.775 + 0.75), abs=0.005)


def test_what_has_ratios_of_its_own_keeps_them():
    rng = np.random.default_rng(5)
    population = CONFIG.population
    sphere = draw_ratios(population, SHAPE_CODES["sphere"], 10, rng)
    np.testing.assert_array_equal(sphere, 1.0)
    fixed = draw_ratios(population.with_aspect(0.8, 0.7), SHAPE_CODES["prism"], 10, rng)
    np.testing.assert_array_equal(fixed, np.tile([0.8, 0.7], (10, 1)))
    corners = tuple(map(tuple, box(0.8, 0.4).tolist()))
    mesh = population.of_mesh(MeshFile("box", corners, 1.0))
    np.testing.assert_allclose(ratio_range(mesh, FIRST_MESH), [[0.8, 0.8], [0.5, 0.5]])
    np.testing.assert_allclose(draw_ratios(mesh, FIRST_MESH, 3, rng), [[0.8, 0.5]] * 3)
