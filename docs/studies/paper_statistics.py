"""Statistics of rebounds over the impact angle: of each shape by direct simulation, and of a table.

Each sample is reduced to `SampleStatistics` and forgotten, so that millions of particles need no
memory.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from sampler.formats.channels import STATE
from sampler.table import Table
from tablegen.accuracy.descriptive import modes, scattering_angles, translational_energy
from tablegen.config.config import Config
from tablegen.config.defaults import MIXTURE
from tablegen.model.float_array import FloatArray
from tablegen.simulation.simulate import simulate

#: Name of the pair of the paper, its impact speed [m/s], and impact angles of our curves [degrees].
PAIR, SPEED = "corundum-steel", 200.0
ANGLES = tuple(float(x) for x in range(5, 91, 5))

#: Shapes of the paper, in its order, and the mixture.
SHAPES = ("ellipsoid", "prism", "truncated-prism", "tetrahedron", MIXTURE)

#: Names of further samples of the mixture: drawn from the table, and simulated with twice the
#: sliding resistance.
TABLE, DOUBLED = "table", "doubled"

#: Factor of the particles at normal impact, of which the paper says most.
NORMAL_FACTOR = 5

#: Bins of densities: range and number; bins of the indicatrices in alpha2, and in alpha2 and beta2.
DENSITY = {"u": (-0.8, 1.0, 180), "v": (0.0, 1.0, 150), "omega_z": (-2.0, 2.0, 200)}
SCATTERING_BINS = 180
SPATIAL_BINS = (180, 180)

#: Quantities with a mean and a most probable value.
QUANTITIES = (*STATE, "translational", "rotational")


@dataclass(frozen=True)
class SampleStatistics:
    """Statistics of one sample."""

    alpha_deg: float
    count: int
    #: By quantity: mean, its standard error, and most probable value. A table has no "rotational".
    mean: dict[str, float]
    error: dict[str, float]
    mode: dict[str, float]
    #: Shares of particles with 1, 2, 3, 4, 5 and more collisions; None from a table.
    collisions: FloatArray | None
    #: Share with omega_z > 0.
    positive_spin: float
    #: Counts of alpha2 over 0 to pi.
    scattering: FloatArray
    #: Counts by variable in the bins of `DENSITY`.
    density: dict[str, FloatArray]
    #: Counts over alpha2 and beta2.
    spatial: FloatArray


def sample_statistics_of(
    alpha_deg: float,
    state: FloatArray,
    collisions: np.ndarray | None = None,
    rotational: FloatArray | None = None,
) -> SampleStatistics:
    """Reduce states (n, 6) to their statistics.

    Numbers of collisions (n,) and rotational energies over the energy before the impact (n,) are
    known of direct simulation only.
    """
    energies = [translational_energy(state)] + ([] if rotational is None else [rotational])
    values = np.column_stack([state, *energies])

    def named(numbers: FloatArray) -> dict[str, float]:
        return dict(zip(QUANTITIES, numbers.tolist(), strict=False))

    shares = None
    if collisions is not None:
        shares = np.bincount(np.minimum(collisions, 6), minlength=7)[1:] / len(collisions)
    alpha2, beta2 = scattering_angles(state)
    limits = ((0.0, np.pi), (-np.pi / 2, np.pi / 2))
    return SampleStatistics(
        alpha_deg=alpha_deg,
        count=len(state),
        mean=named(values.mean(axis=0)),
        error=named(values.std(axis=0) / np.sqrt(len(state))),
        mode=named(modes(values)),
        collisions=shares,
        positive_spin=float(np.mean(state[:, 5] > 0.0)),
        scattering=np.histogram(alpha2, SCATTERING_BINS, (0.0, np.pi))[0].astype(np.float64),
        density={
            name: np.histogram(state[:, STATE.index(name)], bins, (low, high))[0].astype(float)
            for name, (low, high, bins) in DENSITY.items()
        },
        spatial=np.histogram2d(alpha2, beta2, SPATIAL_BINS, limits)[0],
    )


#: Samples by shape, or `TABLE`, and by rising angle [degrees].
Curves = dict[str, dict[float, SampleStatistics]]


@dataclass(frozen=True)
class FigureStatistics:
    """Samples of all shapes at all angles, and the direction of rebound of spheres."""

    #: Impact speed, m/s.
    speed: float
    #: Whether pair and shapes are those of the paper.
    of_paper: bool
    #: With the laws of the configuration; of the table those angles that it holds.
    curves: Curves
    #: With twice the sliding resistance, without the table; empty if the law is not the paper's.
    doubled: Curves
    #: By angle: alpha2 of spheres [rad].
    spheres: dict[float, float]


def speed_of_figures(table: Table, config: Config) -> float:
    """Choose the impact speed: the paper's, or the nearest that was measured and tabulated."""
    low, high = table.speed_nodes[[0, -1]]
    first, last = config.pair.restitution.valid_speed or (low, high)
    return min(max(min(max(SPEED, first), last), low), high)


def shapes_of(config: Config) -> tuple[str, ...]:
    """List the shapes of a population, if there are several, and the mixture."""
    weights = config.population.shapes.positive()
    shapes = tuple(shape for shape in SHAPES if shape in weights)
    return (*shapes, MIXTURE) if len(weights) > 1 else (MIXTURE,)


def doubled_resistance(config: Config) -> Config | None:
    """Double the sliding resistance of the paper's law; None if the law is another."""
    law = config.pair.resistance
    if law.law != "exponential-orientation":
        return None
    return config.with_changes({"pair": {"resistance": {"factor": 2.0 * law.factor}}})


def make_statistics(
    table: Table, config: Config, count: int, seed: int, tick: Callable[[], Any]
) -> FigureStatistics:
    """Simulate all shapes at all angles, also with twice the resistance, and draw from the table.

    There are `count` particles of each shape at each angle, `NORMAL_FACTOR` times as many at
    normal impact. `tick` is called after each sample.
    """
    speed, shapes = speed_of_figures(table, config), shapes_of(config)
    curves = _simulated(config, shapes, speed, count, seed, tick)
    curves[TABLE] = {}
    first, last = table.alpha_nodes_deg[[0, -1]]
    for i, alpha_deg in enumerate(ANGLES):
        if first - 1e-9 <= alpha_deg <= last + 1e-9:
            index = np.arange(_size(alpha_deg, count))
            state = table.sample(np.radians(alpha_deg), speed, seed=seed, hit=i, index=index)
            curves[TABLE][alpha_deg] = sample_statistics_of(alpha_deg, state)
    sphere, spheres = config.population.restricted_to("sphere"), {}
    for alpha_deg in ANGLES:
        alpha1 = np.radians(alpha_deg)
        state = simulate(config, alpha1, speed, 1, seed=seed, population=sphere).state
        spheres[alpha_deg] = float(scattering_angles(state)[0][0])
    twice = doubled_resistance(config)
    doubled = _simulated(twice, shapes, speed, count, seed, tick) if twice else {}
    of_paper = config.pair_name == PAIR and shapes == SHAPES
    return FigureStatistics(speed, of_paper, curves, doubled, spheres)


def samples_of_figures(config: Config) -> int:
    """Count the simulations of `make_statistics`."""
    return len(ANGLES) * len(shapes_of(config)) * (2 if doubled_resistance(config) else 1)


def _size(alpha_deg: float, count: int) -> int:
    return count * (NORMAL_FACTOR if alpha_deg == 90.0 else 1)


def _simulated(
    config: Config,
    shapes: Sequence[str],
    speed: float,
    count: int,
    seed: int,
    tick: Callable[[], Any],
) -> Curves:
    """Simulate each shape and the mixture at each angle; the spin is that of the departure."""
    curves: Curves = {name: {} for name in shapes}
    for stream, (alpha_deg, shape) in enumerate(product(ANGLES, shapes)):
        population = config.population
        simulation = simulate(
            config,
            np.radians(alpha_deg),
            speed,
            _size(alpha_deg, count),
            seed=seed,
            stream=stream,
            population=population if shape == MIXTURE else population.restricted_to(shape),
            omega="departure",  # as in the paper
        )
        parts = simulation.state, simulation.collisions, simulation.energy[:, 1]
        curves[shape][alpha_deg] = sample_statistics_of(alpha_deg, *parts)
        tick()
    return curves
