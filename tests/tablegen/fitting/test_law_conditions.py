"""Conditions of the fit: within the domain of the law, and everywhere in it."""

import math

import numpy as np
import pytest
from mesh_fixtures import box

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


@pytest.mark.parametrize("made", [spread_conditions, still_conditions])
def test_conditions_fill_the_domain(made):
    """The domain has all angles of the table, and speeds V_e up to twice its largest speed."""
    assert ((math.radians(0.5), math.pi / 2.0), (5.0, 600.0), (50.0, 300.0)) == DOMAIN
    found = made(DOMAIN, N, np.random.default_rng(1))
    factor = energy_factor(found[:, 2:])
    effective, sigma = found[:, 1] * factor, np.linalg.norm(found[:, 2:], axis=1) / factor
    for values, (low, high) in ((found[:, 0], DOMAIN.alpha), (effective, DOMAIN.speed)):
        assert low * (1.0 - 1e-9) <= values.min() < values.max() <= high * (1.0 + 1e-9)
        # each sixth of the domain has at least a twentieth of the conditions
        assert (np.histogram(values, 6, (low, high))[0] > N / 20).all()
    if made is still_conditions:
        assert not found[:, 2:].any()
    else:
        assert (np.histogram(sigma, 6, (0.0, math.sqrt(1.5)))[0] > N / 20).all()
        assert np.abs(found[:, 2:].mean(axis=0) / found[:, 2:].std(axis=0)).max() < 0.1


def test_the_direct_model_can_simulate_every_condition():
    """In the largest domain, particles turn at most a million radians before the impact."""
    domain = Range((math.radians(1e-6), math.pi / 2.0), (1e-6, 2e5), (1e-6, 1e5))
    found = spread_conditions(domain, N, np.random.default_rng(6))
    turned = 2.0 * np.linalg.norm(found[:, 2:], axis=1) / np.sin(found[:, 0])
    assert turned.max() < 1e6
    assert found[:, 1].min() >= 1e-6


def test_half_of_the_conditions_are_those_of_chains():
    model, hits = DirectModel(CONFIG), []

    def rebound(conditions, grains, hit):
        hits.append(hit)
        keys = {"seed": 3, "index": np.arange(len(grains)), "hit": hit}
        spin = conditions[:, 2:]
        return model.sample(conditions[:, 0], conditions[:, 1], spin=spin, grain=grains, **keys)

    code = SHAPE_CODES["prism"]
    rng = np.random.default_rng(2)
    found, grains = spinning_conditions(DOMAIN, CONFIG.population, code, N, rebound, rng)
    assert hits == [1, 2, 3, 4, 5]
    assert 0.8 * N < len(found) <= N + 5
    assert DOMAIN.holds(found).all()
    assert (grains[:, 0] == code).all()
    assert 0.5 <= grains[:, 1:].min() < grains[:, 1:].max() <= 1.0
    # half of the grains follow the law, with a mean of 0.775, and half are uniform, with 0.75
    ratios = draw_ratios(CONFIG.population, code, 20_000, rng)
    assert ratios.mean() == pytest.approx(0.5 * (0.775 + 0.75), abs=0.005)


def test_spheres_fixed_grains_and_meshes_keep_their_ratios():
    rng, population = np.random.default_rng(5), CONFIG.population
    np.testing.assert_array_equal(draw_ratios(population, SHAPE_CODES["sphere"], 10, rng), 1.0)
    fixed = draw_ratios(population.with_aspect(0.8, 0.7), SHAPE_CODES["prism"], 10, rng)
    np.testing.assert_array_equal(fixed, np.tile([0.8, 0.7], (10, 1)))
    corners = tuple(map(tuple, box(0.8, 0.4).tolist()))
    mesh = population.of_mesh(MeshFile("box", corners, 1.0))
    np.testing.assert_allclose(ratio_range(mesh, FIRST_MESH), [[0.8, 0.8], [0.5, 0.5]])
    np.testing.assert_allclose(draw_ratios(mesh, FIRST_MESH, 3, rng), [[0.8, 0.5]] * 3)
