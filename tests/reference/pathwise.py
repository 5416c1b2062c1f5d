"""The same particles through the model and through its readable reference."""

import numpy as np
from reference_model import Law, Setup, rebounds

from tablegen.config.config import load_config
from tablegen.model.random_particles import draw_particles, keys_of_run
from tablegen.simulation.simulate import make_condition, simulate_condition

CONFIG = load_config("corundum-steel")
TRUNCATION = CONFIG.population.truncation
_RESTITUTION, _RESISTANCE = CONFIG.pair.restitution, CONFIG.pair.resistance
LAW = Law(_RESTITUTION.coefficient, _RESTITUTION.exponent, _RESISTANCE.strength)


def random_particles(population, count, seed):
    """Particles that `simulate` draws, as `reference_model.rebounds` takes them.

    Returns shape codes (n,), ratios b / a and c / b (n, 2), rotations from body to wall axes
    (n, 3, 3).
    """
    axes, kind = np.empty((count, 6)), np.empty((count, 3))
    draw_particles(population.kernel_arguments(), keys_of_run(seed, 0, 0, count), axes, kind)
    normal, axis = axes[:, :3], axes[:, 3:]
    rotations = np.stack([axis, normal, np.cross(axis, normal)], axis=1)
    return kind[:, 0].astype(np.int64), kind[:, 1:].copy(), rotations


def follow(population, condition, count, seed, changes=None):
    """The same particles through both models; ``changes`` make the reference differ.

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
    particles = random_particles(population, count, seed)
    return fast, *rebounds(law, Setup(**settings), *particles, truncation)
