"""Within the bounds every rebound ends: particles at random corners of the box of all bounds."""

import math
import multiprocessing

import numpy as np
import pytest

from tablegen.config.config import load_config
from tablegen.model import model_bounds as bounds
from tablegen.model.shape_codes import SHAPE_NAMES
from tablegen.simulation.simulate import make_condition, simulate_condition

#: Cases, particles of each, and the longest that a particle may take, seconds: five times what the
#: worst corner took on an idle machine.
CASES, PARTICLES, LIMIT = 200, 2, 225.0

SOURCE = {"source": "a corner"}
RESTITUTION = (
    {"law": "constant", "value": 0.0},
    {"law": "constant", "value": 1.0},
    {"law": "power", "coefficient": 0.5, "reference_speed": 1.0, "exponent": 0.5},
    {"law": "power", "coefficient": 1e6, "reference_speed": 1e5, "exponent": 2.0},
    {"law": "exponential", "coefficient": 1e300, "exponent": 10.0},
    {"law": "exponential", "coefficient": 0.1, "exponent": 0.2},
)
RESISTANCE = (
    {"law": "constant", "value": 0.0},
    {"law": "constant", "value": 0.3},
    {"law": "constant", "value": 100.0},
    {"law": "exponential-orientation", "strength": 10.0, "factor": 100.0},
    {"law": "coulomb", "static": 0.0, "dynamic": 0.0},
    {"law": "coulomb", "static": 0.5, "dynamic": 0.3},
    {"law": "coulomb", "static": 100.0, "dynamic": 100.0},
)


def between(rng, low, high):
    """An end of a range, or a number inside, even in its logarithm."""
    if rng.random() < 0.4:
        return float(rng.choice([low, high]))
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def spin_of(rng, alpha_deg):
    """No spin, the largest that is allowed, or one between, in any direction."""
    most = min(bounds.SPIN.high, 0.5 * bounds.MOST_TURNED * math.sin(math.radians(alpha_deg)))
    direction = rng.normal(size=3) if rng.random() < 0.5 else np.eye(3)[rng.integers(3)]
    size = rng.choice([0.0, 0.999_999 * most, between(rng, 1e-6 * most, 0.999_999 * most)])
    return direction / np.linalg.norm(direction) * size


def corner(rng):
    """Configuration, population and condition of a case."""
    laws = {
        "restitution": {**RESTITUTION[rng.integers(len(RESTITUTION))], **SOURCE},
        "resistance": {**RESISTANCE[rng.integers(len(RESISTANCE))], **SOURCE},
    }
    config = load_config("corundum-steel").with_changes(
        {"pair": laws, "domain": {"extrapolate": True}}
    )
    population = config.population.restricted_to(SHAPE_NAMES[rng.integers(len(SHAPE_NAMES))])
    if not population.shapes.sphere:
        ratios = [between(rng, bounds.ASPECT.low, bounds.ASPECT.high) for _ in range(2)]
        population = population.with_aspect(*ratios)
    alpha_deg = between(rng, bounds.ALPHA_DEG.low, bounds.ALPHA_DEG.high)
    condition = make_condition(
        math.radians(alpha_deg),
        between(rng, bounds.SPEED.low, bounds.SPEED.high),
        spin_of(rng, alpha_deg),
        between(rng, bounds.CONTACT_RESOLUTION.low, bounds.CONTACT_RESOLUTION.high),
        between(rng, bounds.TOLERANCE.low, bounds.TOLERANCE.high),
    )
    return config, population, condition


def follow(seed, results):
    """Simulate a case, and put whether it is as it must be."""
    config, population, condition = corner(np.random.default_rng(seed))
    made = simulate_condition(config.pair, population, condition, PARTICLES, seed=1, threads=1)
    results.put(bool(made.state[:, 1].min() > 0.0))  # not finite would have been an error


@pytest.mark.study(reason="200 cases of up to some seconds a particle")
def test_random_corners_of_the_bounds_end_with_finite_states():
    # compiled before, so that the time is that of the rebounds
    config = load_config("corundum-steel")
    simulate_condition(config.pair, config.population, make_condition(0.7, 200.0), 8, seed=1)
    context = multiprocessing.get_context("fork")
    results = context.Queue()
    for seed in range(CASES):
        process = context.Process(target=follow, args=(seed, results))
        process.start()
        process.join(PARTICLES * LIMIT)
        alive = process.is_alive()
        process.kill()
        process.join()
        assert not alive, f"case {seed} did not end: {corner(np.random.default_rng(seed))[2]}"
        assert process.exitcode == 0, f"case {seed}"
        assert results.get(timeout=10.0), f"case {seed}: a particle that does not leave"
