"""Statistics of rebounds over the impact angle, by shape, from direct simulation and a table.

Each sample is reduced to `SampleStatistics` and forgotten, so that millions of particles need no
memory.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from sampler.formats.channels import STATE
from sampler.table import Table
from tablegen.accuracy.descriptive import modes, scattering_angles, translational_energy
from tablegen.config.config import Config
from tablegen.config.defaults import MIXTURE
from tablegen.model.float_array import FloatArray
from tablegen.simulation.simulate import simulate

#: Impact speed of the paper [m/s], and impact angles of our curves [degrees].
SPEED = 200.0
ANGLES = tuple(float(x) for x in range(5, 91, 5))

#: Shapes of the paper, in its order, and the mixture.
SHAPES = ("ellipsoid", "prism", "truncated-prism", "tetrahedron", MIXTURE)

#: At normal impact, of which the paper says most, this many times as many particles.
NORMAL_FACTOR = 5

#: Sources of a sample.
DIRECT, TABLE = "direct", "table"

#: Bins of densities: range and number; bins of the indicatrices in alpha2, and in alpha2 and beta2.
DENSITY = {"u": (-0.8, 1.0, 180), "v": (0.0, 1.0, 150), "omega_z": (-2.0, 2.0, 200)}
SCATTERING_BINS = 180
SPATIAL_BINS = (60, 60)

#: Quantities with a mean and a most probable value.
QUANTITIES = (*STATE, "translational", "rotational")


@dataclass(frozen=True)
class SampleStatistics:
    """Statistics of one sample."""

    #: `DIRECT` or `TABLE`.
    source: str
    shape: str
    alpha_deg: float
    count: int
    #: By quantity: mean, its standard error, and most probable value. A table has no "rotational".
    mean: dict[str, float]
    error: dict[str, float]
    mode: dict[str, float]
    #: Shares of particles with 1, 2, 3, 4, 5 and more collisions; None from a table.
    collisions: tuple[float, ...] | None
    #: Share with omega_z > 0.
    positive_spin: float
    #: `asymmetry` by variable.
    asymmetry: dict[str, float]
    #: Standard deviation of alpha2, and counts of alpha2 over 0 to pi.
    scattering_deg: float
    scattering: Any
    #: Counts by variable in the bins of `DENSITY`.
    density: dict[str, Any]
    #: Counts over alpha2 and beta2 at normal impact, else None.
    spatial: Any

    @property
    def singles(self) -> float:
        """Share of particles that collide once."""
        assert self.collisions is not None
        return self.collisions[0]

    def to_dict(self) -> dict[str, Any]:
        """Numbers without the histograms, JSON-ready."""
        histograms = ("scattering", "density", "spatial")
        return {name: value for name, value in vars(self).items() if name not in histograms}


def asymmetry(values: FloatArray) -> float:
    """Largest difference between the distribution functions of x and -x, times sqrt(n).

    For a symmetric law the difference, as |x| falls, is a random walk of n steps of +-1/n: the
    statistic tends to the largest |B| of a Brownian motion on (0, 1), which exceeds t with a
    probability below 4 (1 - Phi(t)).
    Source: Butler, "A test for symmetry using the sample distribution function", Ann. Math.
    Statist. 40 (1969).
    """
    walk = np.cumsum(np.sign(values[np.argsort(-np.abs(values))]))
    return float(np.abs(walk).max() / np.sqrt(values.size))


def sample_statistics_of(
    source: str,
    shape: str,
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
        counts = np.bincount(np.minimum(collisions, 6), minlength=7)[1:]
        shares = tuple((counts / len(collisions)).tolist())
    alpha2, beta2 = scattering_angles(state)
    spatial = None
    if alpha_deg == 90.0:
        limits = ((0.0, np.pi), (-np.pi / 2, np.pi / 2))
        spatial = np.histogram2d(alpha2, beta2, SPATIAL_BINS, limits)[0]
    return SampleStatistics(
        source=source,
        shape=shape,
        alpha_deg=alpha_deg,
        count=len(state),
        mean=named(values.mean(axis=0)),
        error=named(values.std(axis=0) / np.sqrt(len(state))),
        mode=named(modes(values)),
        collisions=shares,
        positive_spin=float(np.mean(state[:, 5] > 0.0)),
        asymmetry={name: asymmetry(state[:, k]) for k, name in enumerate(STATE)},
        scattering_deg=float(np.degrees(alpha2.std())),
        scattering=np.histogram(alpha2, SCATTERING_BINS, (0.0, np.pi))[0],
        density={
            name: np.histogram(state[:, STATE.index(name)], bins, (low, high))[0]
            for name, (low, high, bins) in DENSITY.items()
        },
        spatial=spatial,
    )


@dataclass(frozen=True)
class FigureStatistics:
    """Samples of all shapes at all angles, and the direction of rebound of spheres."""

    config: Config
    #: By (source, shape, angle).
    samples: dict[tuple[str, str, float], SampleStatistics]
    #: By angle: smallest and largest alpha2 of spheres [degrees].
    sphere_deg: dict[float, tuple[float, float]]

    def curve(self, source: str, shape: str) -> list[SampleStatistics]:
        """List the samples of one shape by rising angle; none if the source does not have it."""
        found = [sample for key, sample in self.samples.items() if key[:2] == (source, shape)]
        return sorted(found, key=lambda sample: sample.alpha_deg)

    def at(self, source: str, shape: str, alpha_deg: float) -> SampleStatistics | None:
        """Find the sample at one angle; None if there is none."""
        return self.samples.get((source, shape, alpha_deg))

    def shapes(self, source: str) -> list[str]:
        """List the shapes that a source has."""
        return [shape for shape in SHAPES if self.curve(source, shape)]


def make_statistics(
    table: Table, config: Config, count: int, seed: int, tick: Callable[[int], Any]
) -> FigureStatistics:
    """Simulate all shapes at all angles, and draw the mixture from the table.

    There are `count` particles of each shape at each angle, `NORMAL_FACTOR` times as many at
    normal impact. `tick` is called with 1 for each sample.
    """
    samples: dict[tuple[str, str, float], SampleStatistics] = {}
    departing = config.with_changes({"domain": {"omega": "departure"}})  # as in the paper
    (first, last), (slow, fast) = np.degrees(table.alpha_range), table.speed_range
    spheres, sphere_deg = config.population.restricted_to("sphere"), {}
    for i, alpha_deg in enumerate(ANGLES):
        alpha1 = np.radians(alpha_deg)
        size = count * (NORMAL_FACTOR if alpha_deg == 90.0 else 1)
        for k, shape in enumerate(SHAPES):
            particles, stream = config.population.restricted_to(shape), i * len(SHAPES) + k
            made = simulate(
                departing, alpha1, SPEED, size, seed=seed, stream=stream, population=particles
            )
            samples[DIRECT, shape, alpha_deg] = sample_statistics_of(
                DIRECT, shape, alpha_deg, made.state, made.collisions, made.energy[:, 1]
            )
            tick(1)
        if first - 1e-9 <= alpha_deg <= last + 1e-9 and slow <= SPEED <= fast:
            state = table.sample(alpha1, SPEED, seed=seed, hit=i, index=np.arange(size))
            drawn = sample_statistics_of(TABLE, MIXTURE, alpha_deg, state)
            samples[TABLE, MIXTURE, alpha_deg] = drawn
        few = simulate(config, alpha1, SPEED, 100, seed=seed, population=spheres).state
        angles = np.degrees(scattering_angles(few)[0])
        sphere_deg[alpha_deg] = float(angles.min()), float(angles.max())
    return FigureStatistics(config, samples, sphere_deg)
