"""Impacts of chains, and their rebounds by direct simulation."""

import numpy as np

from sampler.formats.bounds import CONDITIONS, N_INPUTS
from tablegen.fitting.law_conditions import covered_range, grain_moments
from tablegen.fitting.spin_coordinates import SPIN_RANGE
from tablegen.simulation.direct import DirectModel
from tablegen.simulation.impact_chains import (
    ANY_WALL,
    OPPOSITE_WALL,
    SAME_WALL,
    energy_factor,
    first_impacts,
    join_impacts,
    next_impacts,
    simulate_departures,
)

#: Impacts that a particle has before its chain ends; each gives one of those after the first.
_HITS = 6


def effective_speed(impacts):
    """Speeds V_e [m/s] whose translational energy is the whole energy, (n,)."""
    return impacts.speed * energy_factor(impacts.spin, impacts.inertia)


def _occurring(config, model, seed, index):
    """One impact with spin of each of some particles that a table draws.

    Half of the particles meet one wall again and again, or two opposite ones, half walls of any
    direction.
    """
    rng, n = np.random.default_rng(seed), len(index)
    alpha1 = np.radians(rng.uniform(*config.domain.alpha_deg, n))
    speed = rng.uniform(*config.domain.speed, n)
    impacts = first_impacts(alpha1, speed, model.grains(seed, index), index)
    walls = rng.choice([SAME_WALL, OPPOSITE_WALL, ANY_WALL], n, p=[0.25, 0.25, 0.5])
    wanted, taken = rng.integers(1, _HITS, n), []
    for number in range(1, _HITS):
        departures = simulate_departures(model, impacts, seed, threads=1)
        impacts = next_impacts(departures, walls, rng.random((len(walls), 2)))
        covered = impacts.alpha1 >= np.radians(config.domain.alpha_deg[0])
        covered &= effective_speed(impacts) >= covered_range(config).effective[0]
        covered &= np.linalg.norm(impacts.spin, axis=1) <= SPIN_RANGE[1]
        taken.append(impacts.select(covered & (wanted == number)))
        going = covered & (wanted > number)
        impacts, walls, wanted = impacts.select(going), walls[going], wanted[going]
    return join_impacts(taken)


def chain_sample(config, most_spin_z=np.inf):
    """Impacts of chains, departures after as many others, and a bound of KS distances.

    Of equal laws, a variable exceeds the bound with p = 0.001. Spins along z are smaller than
    ``most_spin_z``.
    """
    model, index = DirectModel(config), np.arange(8000, dtype=np.uint64)
    both = (_occurring(config, model, seed, index) for seed in (3, 4))
    impacts, others = (some.select(some.spin[:, 2] < most_spin_z) for some in both)
    left = simulate_departures(model, others, 3, threads=1)
    sizes = 1.0 / len(others.index) + 1.0 / len(impacts.index)
    return impacts, left, np.sqrt(0.5 * np.log(2.0 / 1e-3) * sizes)


def tilted_departures(config, code, tilt):
    """Departures of grains that arrive with a tilted spin, and the moments of the grains.

    The grains turn about their shortest axes, which lie across the impact but for the tilt.
    """
    n, rng = 2000, np.random.default_rng(9)
    ratios, turn = rng.uniform(0.5, 0.9, (n, 2)), rng.uniform(0.0, 2.0 * np.pi, n)
    alpha, grain = np.radians(rng.uniform(10.0, 40.0, n)), np.insert(ratios, 0, code, axis=1)
    impacts = first_impacts(alpha, np.full(n, 60.0), grain, np.arange(n, dtype=np.uint64))
    spin = 0.6 * np.column_stack([tilt * np.cos(turn), tilt * np.sin(turn), -np.ones(n)])
    moments = grain_moments(config.population, code, ratios)
    impacts = impacts._replace(spin=spin, inertia=moments.largest)
    return simulate_departures(DirectModel(config), impacts, 9, threads=1), moments


def folded_inputs(n, rng, spinning=True):
    """Inputs of the spin law, (n, 13), uniform over what conditions have after the fold."""
    low = [0.03, 0.0, 0.0, -2.0, -2.0, -1.0, -3.5, 0.5, 0.5, 0.0, -1.0, 0.0, 0.0]
    high = [1.25, 0.7, 2.0, 2.0, 2.0, 1.0, 3.5, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0]
    inputs = rng.uniform(low, high, (n, 13))
    inputs[:, 2 : len(CONDITIONS)] *= spinning
    inputs[:, N_INPUTS:] *= spinning
    return inputs
