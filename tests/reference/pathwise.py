"""The same particles through the model and through its readable reference."""

import numpy as np
from reference_model import Law, Setup, rebounds

from tablegen.config import load_config
from tablegen.model.random_particles import draw_particle
from tablegen.model.rebound import MOTION_SIZE
from tablegen.simulate import make_condition, simulate_condition

CONFIG = load_config("corundum-steel")
TRUNCATION = CONFIG.population.truncation
_RESTITUTION, _RESISTANCE = CONFIG.pair.restitution, CONFIG.pair.resistance
LAW = Law(_RESTITUTION.coefficient, _RESTITUTION.exponent, _RESISTANCE.strength)


def orientations(population, count, seed):
    """Rotations, body to wall axes, of the particles that `simulate` draws; (n, 3, 3)."""
    arguments = population.kernel_arguments()
    motion = np.empty(MOTION_SIZE)
    rotations = np.empty((count, 3, 3))
    for i in range(count):
        draw_particle(arguments, np.uint64(seed), np.uint32(0), i, motion)
        normal, axis = motion[3:6], motion[6:9]
        rotations[i] = axis, normal, np.cross(axis, normal)
    return rotations


def follow(population, condition, count, seed, changes=None):
    """The same particles through both models; ``changes`` make the reference differ.

    Parameters
    ----------
    population : Population
    condition : tuple (alpha1 [degrees], speed [m/s], spin, contact resolution)
    count, seed : int
    changes : dict, optional
        Fields of `Law` and `Setup`, and "truncation".

    Returns
    -------
    tuple (Simulation, (n, 6) float64, (n,) int64)
        The model's simulation; the reference's states and collisions.
    """
    alpha_deg, speed, spin, resolution = condition
    fast_condition = make_condition(np.radians(alpha_deg), speed, spin, resolution)
    fast = simulate_condition(CONFIG.pair, population, fast_condition, count, seed=seed)
    settings = Setup(fast_condition.alpha1, speed, spin, resolution)._asdict()
    settings |= LAW._asdict() | {"truncation": TRUNCATION} | (changes or {})
    law = Law(*(settings.pop(name) for name in Law._fields))
    truncation = settings.pop("truncation")
    particles = fast.shape, fast.aspect, orientations(population, count, seed)
    return fast, *rebounds(law, Setup(**settings), *particles, truncation)
