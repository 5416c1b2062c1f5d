"""Simulate the same particles with the model and with the readable reference."""

import numpy as np
from one_particle import NO_MAP, kernel_condition, prepared_rows, shaped_body
from reference_model import Law, Setup, rebounds

from tablegen.config.config import load_config
from tablegen.model.rebound import HEIGHT, MOTION_SIZE, place_before_impact
from tablegen.model.shapes import MAX_VERTICES
from tablegen.simulation.simulate import make_condition, simulate_condition

CONFIG = load_config("corundum-steel")
TRUNCATION = CONFIG.population.truncation
_RESTITUTION, _RESISTANCE = CONFIG.pair.restitution, CONFIG.pair.resistance
LAW = Law(_RESTITUTION.coefficient, _RESTITUTION.exponent, _RESISTANCE.strength)


def random_particles(population, condition, count, seed):
    """Particles that `simulate` draws, as `reference_model.rebounds` takes them.

    Returns shape codes (n,), ratios b / a and c / b (n, 2), rotations from body to wall axes
    (n, 3, 3), and heights (n,).
    """
    rows, prepared = prepared_rows(population, condition, count, seed)
    axes, kind, condition = prepared[:, :6], rows.grain, kernel_condition(condition)
    normal, axis = axes[:, :3], axes[:, 3:]
    rotations = np.stack([axis, normal, np.cross(axis, normal)], axis=1)
    codes, ratios = kind[:, 0].astype(np.int64), kind[:, 1:].copy()
    motion, heights = np.empty(MOTION_SIZE), np.empty(count)
    for k in range(count):
        storage = np.empty((MAX_VERTICES, 3)), np.zeros(1, dtype=np.int64), NO_MAP
        body = shaped_body(codes[k], ratios[k, 0], ratios[k].prod(), TRUNCATION, *storage)
        motion[3:9] = axes[k]
        place_before_impact(condition, body, motion)
        # without spin a fall from any height is the same
        heights[k] = motion[HEIGHT] if any(condition.spin) else body.bounding_radius
    return codes, ratios, rotations, heights


def follow(population, condition, count, seed, changes=None):
    """Simulate particles with both models; ``changes`` alter the reference, to make it differ.

    ``condition``: alpha1 [degrees], speed [m/s], spin, contact resolution; ``changes``: fields of
    `Law` and `Setup`, and "truncation". Returns the model's simulation, and the reference's states
    (n, 6) and collisions (n,). Angular velocities are those of an instant.
    """
    alpha_deg, speed, spin, resolution = condition
    fast_condition = make_condition(
        np.radians(alpha_deg), speed, spin, resolution, omega="departure"
    )
    fast = simulate_condition(CONFIG.pair, population, fast_condition, count, seed=seed)
    settings = Setup(np.radians(alpha_deg), speed, spin, resolution)._asdict()
    settings |= LAW._asdict() | {"truncation": TRUNCATION} | (changes or {})
    law = Law(*(settings.pop(name) for name in Law._fields))
    truncation = settings.pop("truncation")
    particles = random_particles(population, fast_condition, count, seed)
    return fast, *rebounds(law, Setup(**settings), *particles, truncation)
