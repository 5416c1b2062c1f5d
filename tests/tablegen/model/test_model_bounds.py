"""Bounds of the direct model: one line beyond them; within them all rebounds end."""

import math

import numpy as np
import pytest
from refusals import refused

from sampler.formats.shape_codes import SHAPE_NAMES
from tablegen.config.config import load_config
from tablegen.model import model_bounds as bounds
from tablegen.simulation.simulate import make_condition, simulate_condition

CONFIG = load_config("corundum-steel")


def test_spin_is_bounded_by_the_turns_of_a_particle_before_it_meets_the_wall():
    alpha1 = np.radians(0.01)
    most = 0.5 * bounds.MOST_TURNED * math.sin(alpha1)
    assert make_condition(alpha1, 200.0, (0.0, 0.999 * most, 0.0)).spin[1] > 0.0
    refused("spin", make_condition, alpha1, 200.0, (0.0, 1.001 * most, 0.0))


@pytest.mark.parametrize(
    ("shape", "aspect", "alpha_deg", "speed", "spin"),
    [
        ("prism", (1e-3, 1e-3), 1e-6, 1e-6, (0.0, 0.0, 0.0)),
        ("truncated-prism", (1e-3, 1.0), 90.0, 1e5, (0.0, 0.0, 1e3)),
        ("tetrahedron", (1.0, 1e-3), 45.0, 1e5, (1e3, 0.0, 0.0)),
        ("ellipsoid", (1e-3, 1.0), 1e-6, 1e5, (0.0, 0.0, -1e-4)),
    ],
)
def test_corners_of_the_bounds_give_finite_states(shape, aspect, alpha_deg, speed, spin):
    population = CONFIG.population.restricted_to(shape).with_aspect(*aspect)
    condition = make_condition(np.radians(alpha_deg), speed, spin)
    simulation = simulate_condition(CONFIG.pair, population, condition, 8, seed=5, threads=1)
    assert np.isfinite(simulation.state).all()
    assert simulation.state[:, 1].min() > 0.0
    assert simulation.energy.sum(axis=1).max() <= 1.0 + 1e-9


RESTITUTION = (
    {"law": "constant", "value": 0.0},
    {"law": "constant", "value": 1.0},
    {"law": "power", "coefficient": 1e6, "reference_speed": 1e5, "exponent": 2.0},
    {"law": "exponential", "coefficient": 1e300, "exponent": 10.0},
    {"law": "exponential", "coefficient": 0.1, "exponent": 0.2},
)
RESISTANCE = (
    {"law": "constant", "value": 0.0},
    {"law": "constant", "value": 100.0},
    {"law": "exponential-orientation", "strength": 10.0, "factor": 100.0},
    {"law": "coulomb", "static": 0.5, "dynamic": 0.3},
    {"law": "coulomb", "static": 100.0, "dynamic": 100.0},
)


def between(rng, low, high):
    """Draw an end of a range, or a number inside it with an evenly spread logarithm."""
    if rng.random() < 0.4:
        return float(rng.choice([low, high]))
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def corner(rng):
    """Configuration, population and condition of a case."""
    source = {"source": "a corner"}
    laws = {
        "restitution": {**RESTITUTION[rng.integers(len(RESTITUTION))], **source},
        "resistance": {**RESISTANCE[rng.integers(len(RESISTANCE))], **source},
    }
    config = CONFIG.with_changes({"pair": laws, "domain": {"extrapolate": True}})
    population = config.population.restricted_to(SHAPE_NAMES[rng.integers(len(SHAPE_NAMES))])
    if not population.shapes.sphere:
        ratios = [between(rng, bounds.ASPECT.low, bounds.ASPECT.high) for _ in range(2)]
        population = population.with_aspect(*ratios)
    alpha1 = math.radians(between(rng, bounds.ALPHA_DEG.low, bounds.ALPHA_DEG.high))
    most = 0.999_999 * min(bounds.SPIN.high, 0.5 * bounds.MOST_TURNED * math.sin(alpha1))
    direction = rng.normal(size=3) if rng.random() < 0.5 else np.eye(3)[rng.integers(3)]
    spin = rng.choice([0.0, most, between(rng, 1e-6 * most, most)])
    condition = make_condition(
        alpha1,
        between(rng, bounds.SPEED.low, bounds.SPEED.high),
        direction / np.linalg.norm(direction) * spin,
        between(rng, bounds.CONTACT_RESOLUTION.low, bounds.CONTACT_RESOLUTION.high),
        between(rng, bounds.TOLERANCE.low, bounds.TOLERANCE.high),
    )
    return config, population, condition


@pytest.mark.study(reason="200 cases of up to some seconds a particle")
@pytest.mark.parametrize("seed", range(200))
def test_random_corners_of_the_bounds_end_with_finite_states(seed):
    config, population, condition = corner(np.random.default_rng(seed))
    simulation = simulate_condition(config.pair, population, condition, 2, seed=1, threads=1)
    assert simulation.state[:, 1].min() > 0.0  # numbers that are not finite are an error
