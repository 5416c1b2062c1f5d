"""The readable reference: right by itself, and `tablegen.model` right by it, particle by particle.

Both models follow the same particles from the same orientations, so single rebounds are compared,
not statistics. What is left is the reference's own error: 1e-6 of its Runge-Kutta flight, and the
few particles of which it misses a contact.
"""

import json
from pathlib import Path

import numpy as np
import pathwise
import pytest
from pathwise import CONFIG, LAW, TRUNCATION
from reference_model import SHAPES, Law, Setup, make_particle, rebounds
from reference_population import draw_particles
from scipy.spatial import ConvexHull

from tablegen.simulate import CONTACT_RESOLUTION, make_condition, simulate_condition

COUNT, SEED = 2000, 61
NON_SPHERICAL = [name for name in SHAPES if name != "sphere"]

#: Angle [deg], speed [m/s], spin: grazing, the angles of the benchmarks, slow, fast, with spin.
CONDITIONS = [
    (1.0, 200.0, (0.0, 0.0, 0.0)),
    (20.0, 200.0, (0.0, 0.0, 0.0)),
    (45.0, 200.0, (0.0, 0.0, 0.0)),
    (90.0, 200.0, (0.0, 0.0, 0.0)),
    (90.0, 50.0, (0.0, 0.0, 0.0)),
    (70.0, 300.0, (0.0, 0.0, 0.0)),
    (30.0, 200.0, (1.0, -2.0, 3.0)),
]

#: Two rebounds agree if no component differs by more than this.
SAME = 1e-4

REFERENCE_POINTS = json.loads(
    (Path(__file__).parents[1] / "data" / "direct.json").read_text(encoding="utf-8")
)["points"]

# --- Particles of both models ---


def follow(shape, alpha_deg, speed, spin, changes=None):
    """The shipped population's particles of a shape through both models."""
    population = CONFIG.population.restricted_to(shape)
    condition = alpha_deg, speed, spin, CONTACT_RESOLUTION
    return pathwise.follow(population, condition, COUNT, SEED, changes)


def differing(fast, states, chosen=slice(None)):
    """Share of the chosen particles whose rebounds differ."""
    return np.mean(np.abs(states - fast.state)[chosen].max(axis=1) > SAME)


# --- Pathwise agreement ---


@pytest.mark.parametrize(("alpha_deg", "speed", "spin"), CONDITIONS)
@pytest.mark.parametrize("shape", SHAPES)
def test_both_models_agree_on_each_particle(shape, alpha_deg, speed, spin):
    fast, states, collisions = follow(shape, alpha_deg, speed, spin)
    few = fast.collisions <= 3
    assert np.count_nonzero(few) > 300
    # at most 0.1 % and 0.85 % were measured, all of them particles with a missed contact
    assert differing(fast, states, few) <= 0.005
    assert differing(fast, states) <= 0.02
    same = collisions == fast.collisions
    assert np.mean(same) >= 0.98
    assert np.median(np.abs(states - fast.state)[few]) <= 1e-8


@pytest.mark.parametrize(("alpha_deg", "speed", "spin"), CONDITIONS[3:4] + CONDITIONS[6:])
@pytest.mark.parametrize("shape", NON_SPHERICAL)
def test_a_finer_step_leaves_no_difference(shape, alpha_deg, speed, spin):
    # so what differs above is the reference's error, however long the chain of collisions
    fast, states, collisions = follow(shape, alpha_deg, speed, spin, {"step": 0.005})
    assert np.mean(collisions != fast.collisions) <= 0.001
    assert differing(fast, states) <= 0.001


@pytest.mark.parametrize(
    ("shape", "change"),
    [
        ("ellipsoid", {"coefficient": 0.1005}),
        ("prism", {"exponent": 0.612}),
        ("prism", {"strength": 0.998}),
        ("truncated-prism", {"truncation": 0.59}),
        ("tetrahedron", {"speed": 199.0}),
        ("ellipsoid", {"alpha1": np.radians(45.02)}),
        ("tetrahedron", {"spin": (0.0, 0.0, 1e-3)}),
    ],
)
def test_the_comparison_sees_another_law_or_condition(shape, change):
    fast, states, _ = follow(shape, 45.0, 200.0, (0.0, 0.0, 0.0), change)
    assert differing(fast, states, fast.collisions <= 3) > 0.5


def test_the_comparison_sees_missed_contacts():
    fast, states, collisions = follow("tetrahedron", 90.0, 200.0, (0.0, 0.0, 0.0), {"step": 0.4})
    assert differing(fast, states) > 0.02
    assert np.mean(collisions == fast.collisions) < 0.98


def test_the_comparison_sees_another_contact_resolution():
    # only chains of small bounces feel it
    fast, states, collisions = follow(
        "ellipsoid", 90.0, 200.0, (0.0, 0.0, 0.0), {"resolution": 1e-2}
    )
    assert differing(fast, states) > 0.02
    assert collisions.max() < fast.collisions.max()


# --- The reference by itself ---


@pytest.mark.parametrize("shape", ["prism", "truncated-prism", "tetrahedron"])
def test_moments_are_those_of_the_hull(shape):
    particle = make_particle(SHAPES[shape], 0.8, 0.7, TRUNCATION)
    hull = ConvexHull(particle.vertices)
    corners = particle.vertices[hull.simplices]
    # tetrahedra from the centre; <x^2> of each: (sum x_i)^2 + sum x_i^2 over 20, corner 0 at 0
    volumes = np.abs(np.linalg.det(corners))
    squares = (corners.sum(axis=1) ** 2 + np.sum(corners**2, axis=1)) / 20.0
    second = volumes @ squares / volumes.sum()
    np.testing.assert_allclose(particle.moments, second.sum() - second, rtol=1e-13)
    centre = volumes @ corners.sum(axis=1) / 4.0 / volumes.sum()
    np.testing.assert_allclose(centre, 0.0, atol=1e-15)


def test_ellipsoid_has_the_moments_of_a_stretched_ball():
    particle = make_particle(SHAPES["ellipsoid"], 0.8, 0.5, TRUNCATION)
    expected = np.array([0.8**2 + 0.4**2, 1.0 + 0.4**2, 1.0 + 0.8**2]) / 5.0
    np.testing.assert_allclose(particle.moments, expected, rtol=1e-15)


@pytest.mark.parametrize("alpha_deg", [5.0, 45.0, 90.0])
def test_sphere_follows_its_closed_form(alpha_deg):
    alpha = np.radians(alpha_deg)
    particles = draw_particles(np.random.default_rng(62), "sphere", 20)
    states, collisions = rebounds(Law(), Setup(alpha, 150.0), *particles, TRUNCATION)
    a_nc = 1.0 - (1.0 - np.exp(-0.1 * 150.0**0.61)) * np.sin(alpha)
    s = (1.0 + a_nc) * np.sin(alpha)
    k = np.exp(np.sin(alpha))
    side = -k * s * np.cos(alpha) / (1.0 + 0.5 * k * s * 3.5)
    expected = [np.cos(alpha) + side, a_nc * np.sin(alpha), 0.0, 0.0, 0.0, side / 0.4]
    np.testing.assert_array_equal(collisions, 1)
    np.testing.assert_allclose(states, np.tile(expected, (20, 1)), rtol=0.0, atol=1e-13)


# --- Statistics, with random particles of its own ---

#: Standard errors allowed. All tests below make about 250 comparisons, so a right model fails
#: one of them with probability 250 * 2 * (1 - Phi(4.8)) = 4e-4.
ERRORS = 4.8


def largest_deviation(point, law):
    """Largest deviation of a mean or a share from a point of direct.json, in standard errors."""
    count = 6000
    rng = np.random.default_rng([63, REFERENCE_POINTS.index(point)])
    particles = draw_particles(rng, point["shape"], count)
    setup = Setup(np.radians(point["alpha_deg"]), point["speed"])
    states, collisions = rebounds(law, setup, *particles, TRUNCATION)
    both = np.sqrt(1.0 / count + 1.0 / point["count"])
    means = np.array(list(point["mean"].values()))
    # the file rounds to five digits, which counts where a component hardly varies
    deviations = list(
        (np.abs(states.mean(axis=0) - means) - 1e-5)
        / (np.array(list(point["std"].values())) * both)
    )
    for label, percent in point["collisions_percent"].items():
        share = percent / 100.0
        found = np.mean(collisions > 5 if label == ">5" else collisions == int(label))
        if share * count >= 30.0:  # else not normally distributed
            deviations.append(abs(found - share) / (np.sqrt(share * (1.0 - share)) * both))
    return max(deviations)


@pytest.mark.parametrize(
    "point", REFERENCE_POINTS, ids=lambda p: f"{p['shape']}-{p['alpha_deg']}-{p['speed']}"
)
def test_statistics_are_those_of_another_implementation(point):
    assert largest_deviation(point, LAW) < ERRORS


@pytest.mark.parametrize(
    ("alpha_deg", "change"),
    [(90, {"coefficient": 0.09}), (90, {"exponent": 0.59}), (20, {"strength": 0.8})],
)
def test_statistics_reject_another_law(alpha_deg, change):
    point = next(p for p in REFERENCE_POINTS if p["alpha_deg"] == alpha_deg)
    assert largest_deviation(point, LAW._replace(**change)) > 2.0 * ERRORS


@pytest.mark.parametrize("alpha_deg", [20.0, 45.0, 90.0])
def test_mixture_has_the_statistics_of_the_fast_model(alpha_deg):
    count = 10_000
    particles = draw_particles(np.random.default_rng(64), "mixture", count)
    states, collisions = rebounds(LAW, Setup(np.radians(alpha_deg), 200.0), *particles, TRUNCATION)
    population = CONFIG.population.restricted_to("mixture")
    condition = make_condition(np.radians(alpha_deg), 200.0)
    fast = simulate_condition(CONFIG.pair, population, condition, 10 * count, seed=65)
    ours = np.column_stack([states, collisions <= 1, collisions <= 2, collisions <= 5])
    theirs = np.column_stack([fast.state, *(fast.collisions <= limit for limit in (1, 2, 5))])
    error = theirs.std(axis=0) * np.sqrt(1.1 / count)
    deviation = np.abs(ours.mean(axis=0) - theirs.mean(axis=0)) / error
    assert deviation.max() < ERRORS
