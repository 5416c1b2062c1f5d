"""Conditions of the fit: within the range of the law, and everywhere in it."""

import math

import numpy as np
import pytest
from mesh_fixtures import box
from spin_laws import effective_speed

from sampler.formats.bounds import LEAST_RATIO
from sampler.formats.shape_codes import FIRST_MESH, SHAPE_CODES
from tablegen.config.config import load_config
from tablegen.config.grain_ranges import least_inertia
from tablegen.fitting.law_conditions import (
    LONG_CHAINS,
    LawRange,
    chain_impacts,
    covered_range,
    draw_grains,
    draw_ratios,
    driven_along_wall,
    grain_moments,
    inertia_coefficients,
    neighbouring_impacts,
    nonspinning_impacts,
    ratio_range,
    spinning_impacts,
    spread_impacts,
)
from tablegen.fitting.spin_coordinates import (
    SPIN_RANGE,
    inertia_from_kappa,
    kappa_from_inertia,
    kappa_from_place,
)
from tablegen.meshes.mesh_file import MeshFile
from tablegen.model.shapes import inertia
from tablegen.simulation.direct import DirectModel
from tablegen.simulation.impact_chains import first_impacts, simulate_departures

CONFIG = load_config("corundum-steel")
DOMAIN = covered_range(CONFIG)

#: Speeds [m/s] between which conditions are dense.
SPEED_EDGES = [0.09, 1.0, 5.0, 15.0, 40.0, 100.0, 200.0, 300.0]
N = 4000
PRISM = SHAPE_CODES["prism"]


def prism_moments(impacts):
    return grain_moments(CONFIG.population, PRISM, impacts.grain[:, 1:])


@pytest.fixture(scope="module")
def spread():
    rng = np.random.default_rng(1)
    grains = draw_grains(CONFIG.population, PRISM, N, rng)
    return spread_impacts(
        DOMAIN, grains, grain_moments(CONFIG.population, PRISM, grains[:, 1:]), rng
    )


def chains_of_prisms(every):
    """Simulate twenty-one hits of each of 200 prisms, and take one impact in ``every``."""
    rng = np.random.default_rng(2)
    grains = draw_grains(CONFIG.population, PRISM, N // 20, rng)
    kind = LONG_CHAINS._replace(hits=21, every=every)
    return chain_impacts(DirectModel(CONFIG), DOMAIN, grains, kind, int, rng)


@pytest.fixture(scope="module")
def chains():
    """Twenty impacts of each of 200 prisms, hit after hit."""
    return chains_of_prisms(every=1)


def check_range(impacts):
    """Angles, effective speeds, spins and inertias are within the range of the law."""
    alpha, effective = impacts.alpha1, effective_speed(impacts)
    assert DOMAIN.alpha[0] * (1.0 - 1e-9) <= alpha.min() <= alpha.max() <= DOMAIN.alpha[1]
    assert DOMAIN.effective[0] * (1.0 - 1e-9) <= effective.min()
    assert effective.max() <= DOMAIN.effective[1] * (1.0 + 1e-9)
    assert impacts.speed.max() <= DOMAIN.speed[1] * (1.0 + 1e-9)
    assert np.linalg.norm(impacts.spin, axis=1).max() <= SPIN_RANGE[1] * (1.0 + 1e-9)
    moments = prism_moments(impacts)
    assert (impacts.inertia >= moments.smallest * (1.0 - 1e-6)).all()
    assert (impacts.inertia <= moments.largest * (1.0 + 1e-6)).all()


def test_range_is_that_of_the_law_whatever_the_first_impacts_are():
    # grains that are about to rest are a thousand times slower than when they came in
    low = 3e-4 * 300.0
    assert ((math.radians(0.05), math.pi / 2.0), (low, 300.0), (low, 600.0)) == DOMAIN
    narrow = CONFIG.with_changes({"domain": {"alpha_deg": [30.0, 60.0], "speed": [60.0, 100.0]}})
    assert covered_range(narrow) == (DOMAIN.alpha, (0.03, 100.0), (0.03, 200.0))
    flat = CONFIG.with_changes({"domain": {"alpha_deg": [0.01, 60.0]}})
    assert covered_range(flat).alpha == (math.radians(0.01), math.pi / 2.0)


def shares(values, edges):
    """Shares of values between edges."""
    return np.histogram(values, edges)[0] / len(values)


class TestSpread:
    def test_angles_and_speeds_fill_the_range(self, spread):
        check_range(spread)
        alpha = np.degrees(spread.alpha1)
        assert (shares(alpha, [0.05, 0.2, 1.0, 5.0, 15.0, 30.0, 60.0, 90.0]) > 0.01).all()
        effective = effective_speed(spread)
        assert (shares(effective, SPEED_EDGES) > 0.05).all()
        assert shares(effective, [300.0, 600.0])[0] > 0.05

    def test_spins_fill_the_range_in_size_and_direction(self, spread):
        size = np.linalg.norm(spread.spin, axis=1)
        assert (shares(size, [1e-3, 1e-2, 0.1, 0.5, 1.0, 2.0, 5.0, 10.0]) > 0.03).all()
        assert shares(size, [1e-3, 10.0 + 1e-9])[0] == 1.0
        # each octant of directions has spins, the two of rolling more
        octant = (spread.spin > 0.0) @ [1, 2, 4]
        counts = np.bincount(octant, minlength=8) / N
        assert counts.min() > 0.03
        assert counts[:4].sum() > 0.6

    def test_inertias_fill_the_range(self, spread):
        kappa = kappa_from_inertia(spread.inertia, prism_moments(spread))
        assert (shares(kappa, np.linspace(0.0, 1.0, 11)) > 0.04).all()
        assert kappa.min() < 0.01
        assert kappa.max() > 0.99

    def test_grains_that_roll_are_among_them(self, spread):
        """Spins about -V/a along z, whose lowest points are nearly at rest, at flat angles."""
        flat = spread.alpha1 < math.radians(10.0)
        rolls = np.linalg.norm(spread.spin - [0.0, 0.0, -1.0], axis=1) < 0.4
        assert (flat & rolls).sum() > N / 100
        # more than turn about the other side, as grains seldom do
        others = np.linalg.norm(spread.spin - [0.0, 0.0, 1.0], axis=1) < 0.4
        assert (flat & rolls).sum() > 3 * (flat & others).sum()


class TestChains:
    def test_are_set_back_to_their_speed_and_stay_in_the_range(self, chains):
        impacts, _ = chains
        assert len(impacts.index) == 20 * (N // 20)
        turns = impacts.inertia > 0.0
        check_range(impacts.select(turns))
        # half of those that meet walls of any direction, and three quarters of the others, keep
        # their speed, and the rest their effective speed
        each = (impacts.speed, effective_speed(impacts))
        kept = [np.ptp(speeds.reshape(20, -1), axis=0) < 1e-6 for speeds in each]
        assert np.mean(kept, axis=1) == pytest.approx([0.675, 0.325], abs=0.12)
        assert np.mean(kept[0] | kept[1]) > 0.9  # unless they are too fast
        np.testing.assert_array_equal(impacts.grain[: N // 20], impacts.grain[-N // 20 :])

    def test_give_some_of_their_impacts_and_as_many_of_each_grain(self, chains):
        some, _ = chains_of_prisms(every=4)
        np.testing.assert_array_equal(np.bincount(some.index.astype(int)), np.full(N // 20, 5))
        everything = {tuple(spin) for spin in chains[0].spin}
        assert all(tuple(spin) in everything for spin in some.spin)

    def test_a_gas_drives_grains_along_the_wall(self):
        """It slows down their spins, and a little their velocity towards the wall; others stay."""
        grains = np.tile([SHAPE_CODES["ellipsoid"], 0.8, 0.8], (2, 1))
        impacts = first_impacts(np.radians([30.0, 30.0]), np.full(2, 50.0), grains, np.arange(2))
        impacts = impacts._replace(spin=np.tile([0.1, 0.2, -0.8], (2, 1)))
        driven = driven_along_wall(
            impacts, np.array([True, False]), np.full(2, 80.0), np.full(2, 2.0)
        )
        assert 80.0 * np.sin(driven.alpha1[0]) == pytest.approx(25.0 * np.exp(-0.2))
        np.testing.assert_allclose(80.0 * driven.spin[0], 50.0 * np.exp(-2.0) * impacts.spin[0])
        assert (driven.alpha1[1], *driven.spin[1]) == (impacts.alpha1[1], *impacts.spin[1])

    def test_of_discs_settle_into_rolling(self):
        """Their edges roll along the wall that they meet again and again, ever flatter."""
        rng = np.random.default_rng(2)
        discs = np.tile([SHAPE_CODES["ellipsoid"], 0.97, 0.55], (300, 1))
        kind = LONG_CHAINS._replace(hits=41, every=1)
        impacts, _ = chain_impacts(DirectModel(CONFIG), DOMAIN, discs, kind, int, rng)
        early, late = impacts.select(slice(0, 900)), impacts.select(slice(-900, None))
        flat = [some.alpha1 < math.radians(3.0) for some in (early, late)]
        assert flat[0].mean() < 0.1 < flat[1].mean()
        rolls = [
            np.linalg.norm(some.spin - [0.0, 0.0, -1.0], axis=1) < 0.1 for some in (early, late)
        ]
        assert rolls[0].mean() < 0.02 < 0.04 < rolls[1].mean()
        spins = flat[1] & (np.abs(late.spin[:, 2]) > 0.5)  # others slide between opposite walls
        assert np.median(late.spin[spins, 2]) == pytest.approx(-1.0, abs=0.15)

    def test_inertias_after_first_hits_are_those_of_any_orientation(self, chains):
        """They turn about their long axis less than uniform orientations would."""
        _, after = chains
        grains = draw_grains(CONFIG.population, PRISM, N // 20, np.random.default_rng(2))
        moments = grain_moments(CONFIG.population, PRISM, grains[:, 1:])
        kappa = kappa_from_inertia(after, moments)
        assert ((after > 0.0) & (kappa >= 0.0) & (kappa <= 1.0)).all()
        assert np.median(kappa) > 0.5

    def test_neighbours_lie_around_them(self, chains):
        impacts = chains[0].select(chains[0].inertia > 0.0)
        moments = prism_moments(impacts)
        near = neighbouring_impacts(impacts, DOMAIN, moments, np.random.default_rng(3))
        check_range(near)
        sizes = [np.linalg.norm(some.spin, axis=1) for some in (near, impacts)]
        ratio = sizes[0] / sizes[1]
        kept = np.abs(np.log(ratio)) < 1e-9
        assert 0.5 < kept.mean() < 0.7  # their angles change alone
        assert np.mean(ratio[~kept] < 0.1) > 0.1  # slowed down by a gas
        assert np.mean(np.abs(np.log(ratio[~kept])) < 0.5) > 0.4
        cosine = np.sum(near.spin * impacts.spin, axis=1) / sizes[0] / sizes[1]
        assert np.median(cosine[~kept]) > 0.97
        change = np.log(near.alpha1 / impacts.alpha1)
        assert 0.2 < change[~kept].std() < 0.6 < change[kept].std()
        moved = kappa_from_inertia(near.inertia, moments) - kappa_from_inertia(
            impacts.inertia, moments
        )
        assert 0.02 < np.abs(moved[~kept]).mean() < 0.1
        np.testing.assert_allclose(moved[kept], 0.0, atol=1e-6)
        assert (near.inertia < moments.largest * (1.0 - 1e-12)).mean() > 0.99  # not cut at the end


def settled_ellipsoids(impacts):
    """Mark nearly round ellipsoids that turn about their shortest axes, across the impact."""
    moments = grain_moments(CONFIG.population, SHAPE_CODES["ellipsoid"], impacts.grain[:, 1:])
    across = np.linalg.norm(impacts.spin[:, :2], axis=1) / np.linalg.norm(impacts.spin, axis=1)
    settled = (kappa_from_inertia(impacts.inertia, moments) > 0.9) & (across < 0.3)
    return settled & (impacts.grain[:, 1] > 0.9)


def test_settled_ellipsoids_are_dense_because_they_make_most_hits_of_a_flow():
    """A ninth of the impacts, of 141 grains; if chains gave all impacts, 46 grains.

    Without chains of rounder grains they are a thirtieth of the impacts.
    """
    rng = np.random.default_rng(2)
    impacts, _ = spinning_impacts(
        DirectModel(CONFIG), DOMAIN, CONFIG.population, SHAPE_CODES["ellipsoid"], 5 * N, int, rng
    )
    settled = settled_ellipsoids(impacts)
    assert settled.mean() > 0.08
    assert len(np.unique(impacts.grain[settled, 1])) > 100


def test_impacts_without_spin_fill_the_range():
    rng = np.random.default_rng(4)
    impacts = nonspinning_impacts(DOMAIN, draw_grains(CONFIG.population, PRISM, N, rng), rng)
    assert not impacts.spin.any()
    assert not impacts.inertia.any()
    assert (
        shares(np.degrees(impacts.alpha1), [0.05, 0.5, 5.0, 30.0, 60.0, 85.0, 90.0]) > 0.02
    ).all()
    assert (shares(impacts.speed, SPEED_EDGES) > 0.05).all()
    # the law changes most within a degree of normal impact
    assert shares(impacts.alpha1, np.radians([89.0, 90.0]))[0] > 0.02


def test_spinning_impacts_are_of_chains_their_neighbours_and_all_others():
    seeds = []

    def seed(number):
        seeds.append(number)
        return number

    rng = np.random.default_rng(2)
    impacts, kappa = spinning_impacts(
        DirectModel(CONFIG), DOMAIN, CONFIG.population, PRISM, N, seed, rng
    )
    assert len(set(seeds)) == len(seeds)  # no two hits have the same random numbers
    assert len(impacts.index) >= N
    check_range(impacts)
    assert np.linalg.norm(impacts.spin, axis=1).min() > 0.0
    np.testing.assert_array_equal(impacts.index, np.arange(len(impacts.index)))
    assert ((kappa >= 0.0) & (kappa <= 1.0)).all()
    assert 0.5 < np.median(kappa) < 0.9
    assert 0.5 <= impacts.grain[:, 1:].min() < impacts.grain[:, 1:].max() <= 1.0


def test_the_direct_model_simulates_every_spread_impact():
    """In the widest domain, too."""
    rng, model = np.random.default_rng(6), DirectModel(CONFIG)
    grains = draw_grains(CONFIG.population, PRISM, 300, rng)
    moments = grain_moments(CONFIG.population, PRISM, grains[:, 1:])
    domain = LawRange((math.radians(1e-3), math.pi / 2.0), (1e-3, 1e4), (1e-3, 2e4))
    impacts = spread_impacts(domain, grains, moments, rng)
    assert np.isfinite(simulate_departures(model, impacts, 1, threads=1).states).all()


def test_half_of_the_grains_follow_the_population_and_half_are_even():
    # the means are 0.775 and 0.75
    ratios = draw_ratios(CONFIG.population, PRISM, 20_000, np.random.default_rng(2))
    assert ratios.mean() == pytest.approx(0.5 * (0.775 + 0.75), abs=0.005)
    assert 0.5 <= ratios.min() < ratios.max() <= 1.0


def box_population(population):
    corners = tuple(map(tuple, box(0.8, 0.4).tolist()))
    return population.with_mesh(MeshFile("box", corners, len(corners), 1.0, False))


def test_spheres_fixed_grains_and_meshes_keep_their_ratios():
    rng, population = np.random.default_rng(5), CONFIG.population
    np.testing.assert_array_equal(draw_ratios(population, SHAPE_CODES["sphere"], 10, rng), 1.0)
    fixed = draw_ratios(population.with_aspect(0.8, 0.7), PRISM, 10, rng)
    np.testing.assert_array_equal(fixed, np.tile([0.8, 0.7], (10, 1)))
    mesh = box_population(population)
    np.testing.assert_allclose(ratio_range(mesh, FIRST_MESH), [[0.8, 0.8], [0.5, 0.5]])
    np.testing.assert_allclose(draw_ratios(mesh, FIRST_MESH, 3, rng), [[0.8, 0.5]] * 3)


@pytest.mark.parametrize("shape", SHAPE_CODES)
def test_moments_are_those_of_the_model(shape):
    code, population = SHAPE_CODES[shape], CONFIG.population
    ratios = np.array([[1.0, 1.0]]) if shape == "sphere" else np.array([[0.9, 0.6], [0.5, 1.0]])
    moments = grain_moments(population, code, ratios)
    for k, (b, c) in enumerate(ratios):
        expected = np.sort(inertia(code, b, b * c, population.truncation))
        np.testing.assert_allclose([moments.smallest[k], moments.largest[k]], expected[[0, 2]])


def test_a_mesh_whose_extents_do_not_decrease_has_ratios_that_a_table_can_store():
    """Its moments decide the order of its axes, and stay those of the mesh."""
    spiked = np.concatenate([box(0.8, 0.78), [[0.0, 0.0, 1.1], [0.0, 0.0, -1.1]]])
    corners = tuple(map(tuple, spiked.tolist()))
    population = CONFIG.population.with_mesh(MeshFile("spiked", corners, len(corners), 1.0, False))
    ranges = ratio_range(population, FIRST_MESH)
    np.testing.assert_array_equal(ranges[:, 0], ranges[:, 1])
    assert (ranges >= LEAST_RATIO).all()
    assert (ranges <= 1.0).all()
    assert ranges[0, 0] == 1.0
    particle = population.meshes[0].particle()
    moments = grain_moments(population, FIRST_MESH, ranges[None, :, 0])
    np.testing.assert_allclose(moments.smallest, particle.moments[0])
    np.testing.assert_allclose(moments.largest, particle.moments[2])
    np.testing.assert_array_equal(
        DirectModel(CONFIG, population).grains(7, 3), [FIRST_MESH, *ranges[:, 0]]
    )


def test_moments_of_meshes_and_the_least_of_a_population():
    mesh = box_population(CONFIG.population)
    moments = grain_moments(mesh, FIRST_MESH, np.array([[0.8, 0.5]]))
    b, c = 0.8, 0.4
    np.testing.assert_allclose(moments.largest, (1.0 + b * b) / 3.0, rtol=1e-6)
    np.testing.assert_allclose(moments.smallest, (b * b + c * c) / 3.0, rtol=1e-6)
    assert least_inertia(mesh) == pytest.approx((b * b + c * c) / 3.0, rel=1e-6)
    codes = CONFIG.population.kernel_arguments().shape_codes
    thinnest = [
        grain_moments(CONFIG.population, int(code), np.array([[0.5, 0.5]])) for code in codes
    ]
    least = min(float(moments.smallest[0]) for moments in thinnest)
    assert least_inertia(CONFIG.population) == pytest.approx(least)
    assert inertia_coefficients(CONFIG.population, PRISM) == pytest.approx((1 / 3, 1 / 3))


def test_spins_of_any_direction_in_a_grain_have_uniform_places():
    """With two equal moments the place is the squared cosine of the angle to the axis."""
    rng = np.random.default_rng(9)
    direction = rng.standard_normal((1000, 3))
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    moments = grain_moments(CONFIG.population, PRISM, np.tile([1.0, 0.5], (1000, 1)))
    square = direction[:, 2] ** 2  # of the angular momentum, along the short axis
    k = 1.0 / (square / moments.largest + (1.0 - square) / moments.smallest)
    np.testing.assert_allclose(
        kappa_from_inertia(k, moments), kappa_from_place(direction[:, 2] ** 2), atol=1e-7
    )
    np.testing.assert_allclose(
        inertia_from_kappa(kappa_from_place(direction[:, 2] ** 2), moments), k
    )
