"""Conditions of the fit: within the domain of the law, and everywhere in it."""

import math

import numpy as np
import pytest
from mesh_fixtures import box
from scipy.spatial.transform import Rotation

from sampler.formats.shape_codes import FIRST_MESH, SHAPE_CODES
from tablegen.config.config import load_config
from tablegen.config.mesh import MeshFile
from tablegen.fitting.law_conditions import (
    SPIN_RANGE,
    Range,
    chain_impacts,
    draw_ratios,
    grains_of,
    ratio_range,
    spinning_impacts,
    spread_impacts,
    still_impacts,
)
from tablegen.simulation.direct import DirectModel
from tablegen.simulation.impact_chains import effective_speed, energy_factor

CONFIG = load_config("corundum-steel")
DOMAIN = Range.of(CONFIG)
N = 4000
PRISM = SHAPE_CODES["prism"]


def made_impacts(kind, domain, count, seed):
    """Impacts of prisms: without spin, of chains, or spread over the domain."""
    rng, model = np.random.default_rng(seed), DirectModel(CONFIG)
    if kind == "still":
        return still_impacts(domain, grains_of(CONFIG.population, PRISM, count, rng), rng)
    grains = grains_of(CONFIG.population, PRISM, math.ceil(count / 5), rng)
    met, departures = chain_impacts(model, domain, grains, int, rng)
    return met if kind == "chains" else spread_impacts(model, domain, departures, count, rng)


@pytest.mark.parametrize("kind", ["spread", "still"])
def test_impacts_fill_the_domain(kind):
    """The domain has all angles of the table, and speeds V_e up to twice its largest speed.

    Few particles without spin are faster than that largest speed.
    """
    assert ((math.radians(0.5), math.pi / 2.0), (5.0, 600.0), (50.0, 300.0)) == DOMAIN
    found = made_impacts(kind, DOMAIN, N, 1)
    size, effective = np.linalg.norm(found.spin, axis=1), effective_speed(found)
    for values, (low, high) in ((found.alpha1, DOMAIN.alpha), (effective, DOMAIN.speed)):
        assert low * (1.0 - 1e-9) <= values.min() < values.max() <= high * (1.0 + 1e-9)
        # each sixth of the domain has at least a twentieth of the conditions
        sixths = np.histogram(values, 6, (low, high))[0]
        if kind == "still" and values is effective:
            assert 0 < sixths[3:].sum() < N / 20
            sixths = sixths[:3]
        assert (sixths > N / 20).all()
    if kind == "still":
        assert not found.spin.any()
        assert not found.orientation.any()
    else:
        most = size / energy_factor(found.spin)
        assert (np.histogram(most, 6, (0.0, 10.0 / math.sqrt(1.0 + 200.0 / 3.0)))[0] > N / 20).all()
        assert SPIN_RANGE[1] < size.max() < 13.0
        assert np.abs(found.spin.mean(axis=0) / found.spin.std(axis=0)).max() < 0.2


@pytest.mark.parametrize("kind", ["spread", "chains"])
def test_orientations_are_those_of_grains_that_a_wall_has_set_spinning(kind):
    """They turn about their long axis less than uniform orientations would; false alarms: 5e-3."""
    found = made_impacts(kind, DOMAIN, 16 * N, 3)
    turn = Rotation.from_quat(found.orientation, scalar_first=True)
    own = turn.inv().apply(found.spin / np.linalg.norm(found.spin, axis=1)[:, None])
    # 0.283 or 0.315 +- 0.003 of the squared spin, and a third if uniform
    assert np.mean(own[:, 0] ** 2) < {"chains": 0.31, "spread": 0.325}[kind]


def test_the_direct_model_can_simulate_every_impact():
    """In the largest domain, particles turn at most a million radians before the impact."""
    domain = Range((math.radians(1e-6), math.pi / 2.0), (1e-6, 2e5), (1e-6, 1e5))
    found = made_impacts("spread", domain, N, 6)
    turned = 2.0 * np.linalg.norm(found.spin, axis=1) / np.sin(found.alpha1)
    assert turned.max() < 1e6
    assert found.speed.min() >= 1e-6


def test_half_of_the_impacts_are_those_of_chains():
    hits = []

    def seed(hit):
        hits.append(hit)
        return hit

    rng = np.random.default_rng(2)
    given = DirectModel(CONFIG), DOMAIN, CONFIG.population, PRISM, N, seed, rng
    found = spinning_impacts(*given)
    assert hits == [1, 2, 3, 4, 5]
    assert 0.8 * N < len(found.index) < 1.05 * N
    assert DOMAIN.holds(found).all()
    assert (found.grain[:, 0] == PRISM).all()
    assert 0.5 <= found.grain[:, 1:].min() < found.grain[:, 1:].max() <= 1.0
    # half of the grains follow the law, with a mean of 0.775, and half are uniform, with 0.75
    ratios = draw_ratios(CONFIG.population, PRISM, 20_000, rng)
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
