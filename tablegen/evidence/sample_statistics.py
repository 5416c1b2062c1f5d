"""Statistics of rebounds over the impact angle, by shape, from direct simulation and a table.

One simulation is reduced to `SampleStatistics` and forgotten, so that millions of particles need
no memory.
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

#: Impact speed of the paper [m/s], and the impact angles of our curves [degrees].
SPEED = 200.0
ANGLES = tuple(float(x) for x in range(5, 91, 5))

#: Shapes of the paper, in its order, and the mixture.
SHAPES = ("ellipsoid", "prism", "truncated-prism", "tetrahedron", MIXTURE)

#: At normal impact, of which the paper says most, this many times as many particles.
NORMAL_FACTOR = 5

#: Sources of a sample.
DIRECT, TABLE = "direct", "table"

#: Bins of densities: range and number.
DENSITY = {"u": (-0.8, 1.0, 180), "v": (0.0, 1.0, 150), "omega_z": (-2.0, 2.0, 200)}
SCATTERING_BINS = 180

#: Bins of the spatial indicatrix in alpha2 and beta2.
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
    #: By quantity. Mean, its standard error, most probable value, of the
    #: `QUANTITIES` that the source has.
    mean: dict[str, float]
    error: dict[str, float]
    mode: dict[str, float]
    #: Share of particles with 1, 2, 3, 4, 5 and more collisions; a table does not tell.
    collisions: tuple[float, ...] | None
    #: Share with Omega_z > 0.
    positive_spin: float
    #: By variable. Largest difference between the distribution functions of x and
    #: -x, times the root of the count; for a symmetric law it exceeds t with probability
    #: 4 (1 - Phi(t)).
    asymmetry: dict[str, float]
    #: Standard deviation of alpha2.
    scattering_deg: float
    #: Shape (SCATTERING_BINS,). Counts of alpha2 over 0 to pi.
    scattering: Any
    #: By variable. Counts in the bins of `DENSITY`.
    density: dict[str, Any]
    #: Int array, shape SPATIAL_BINS, or None. Counts over alpha2 and beta2; at normal impact only.
    spatial: Any

    @property
    def singles(self) -> float:
        """Share of particles that collide once."""
        assert self.collisions is not None
        return self.collisions[0]

    def to_dict(self) -> dict[str, Any]:
        """Numbers but for the histograms, JSON-ready."""
        histograms = ("scattering", "density", "spatial")
        return {name: value for name, value in vars(self).items() if name not in histograms}


def asymmetry(values: FloatArray) -> float:
    """Largest difference between the distribution functions of x and -x, times sqrt(n).

    For a symmetric law the difference, as |x| falls, is a random walk of n steps of +-1/n: the
    statistic tends to the largest |B| of a Brownian motion on (0, 1), which exceeds t with a
    probability below 4 (1 - Phi(t)).
    Source: Butler, "A test for symmetry using the sample distribution function", Ann. Math.
    Statist. 40 (1969).

    Parameters
    ----------
    values : float64 array, shape (n,)
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
    """Reduce a sample to its statistics.

    Parameters
    ----------
    source, shape : str
    alpha_deg : float
    state : float64 array, shape (n, 6)
    collisions : int array, shape (n,), optional
    rotational : float64 array, shape (n,), optional
        Rotational energy over the energy before.
    """
    columns = [*state.T, translational_energy(state)]
    columns += [] if rotational is None else [rotational]
    values = np.column_stack(columns)
    names = QUANTITIES[: values.shape[1]]
    alpha2, beta2 = scattering_angles(state)
    spatial = None
    if alpha_deg == 90.0:
        limits = ((0.0, np.pi), (-np.pi / 2, np.pi / 2))
        spatial = np.histogram2d(alpha2, beta2, SPATIAL_BINS, limits)[0].astype(np.int64)
    return SampleStatistics(
        source=source,
        shape=shape,
        alpha_deg=alpha_deg,
        count=len(state),
        mean=_named(names, values.mean(axis=0)),
        error=_named(names, values.std(axis=0) / np.sqrt(len(state))),
        mode=_named(names, modes(values)),
        collisions=_collision_shares(collisions),
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


def _collision_shares(collisions: np.ndarray | None) -> tuple[float, ...] | None:
    """Shares of particles with 1, 2, 3, 4, 5 and more collisions."""
    if collisions is None:
        return None
    counts = np.bincount(np.minimum(collisions, 6), minlength=7)[1:]
    return tuple((counts / len(collisions)).tolist())


def _named(names: tuple[str, ...], values: FloatArray) -> dict[str, float]:
    return dict(zip(names, values.tolist(), strict=True))


@dataclass(frozen=True)
class FigureStatistics:
    """Samples of all shapes at all angles, and the direction of rebound of spheres."""

    config: Config
    seed: int
    #: By (source, shape, angle).
    samples: dict[tuple[str, str, float], SampleStatistics]
    #: By angle. Smallest and largest alpha2 of spheres [degrees].
    sphere_deg: dict[float, tuple[float, float]]

    def curve(self, source: str, shape: str) -> list[SampleStatistics]:
        """List samples of one shape, by rising angle; none if the source does not have it."""
        found = [sample for key, sample in self.samples.items() if key[:2] == (source, shape)]
        return sorted(found, key=lambda sample: sample.alpha_deg)

    def at(self, source: str, shape: str, alpha_deg: float) -> SampleStatistics | None:
        """Sample at one angle; None if there is none."""
        return self.samples.get((source, shape, alpha_deg))

    def shapes(self, source: str) -> list[str]:
        """Shapes that a source has."""
        return [shape for shape in SHAPES if self.curve(source, shape)]


def _simulated(
    config: Config, shape: str, alpha_deg: float, count: int, keys: tuple[int, int]
) -> SampleStatistics:
    made = simulate(
        config,
        np.radians(alpha_deg),
        SPEED,
        count,
        seed=keys[0],
        stream=keys[1],
        population=config.population.restricted_to(shape),
    )
    return sample_statistics_of(
        DIRECT, shape, alpha_deg, made.state, made.collisions, made.energy[:, 1]
    )


def _sphere(config: Config, alpha_deg: float, seed: int) -> tuple[float, float]:
    """Smallest and largest alpha2 [degrees] of a few spheres."""
    spheres = config.population.restricted_to("sphere")
    angle = np.radians(alpha_deg)
    state = simulate(config, angle, SPEED, 100, seed=seed, population=spheres).state
    angles = np.degrees(scattering_angles(state)[0])
    return float(angles.min()), float(angles.max())


def table_covers(table: Table, alpha_deg: float) -> bool:
    """Whether a table can be drawn from at an angle and the paper's speed."""
    (first, last), (slow, fast) = np.degrees(table.alpha_range), table.speed_range
    slack = 1e-9
    return bool(first - slack <= alpha_deg <= last + slack and slow <= SPEED <= fast)


def make_statistics(
    table: Table, config: Config, count: int, seed: int, tick: Callable[[int], Any]
) -> FigureStatistics:
    """Simulate all shapes at all angles, and draw the mixture from the table.

    Parameters
    ----------
    table : Table
    config : Config
        Pair, population and numerics of the direct simulation.
    count : int
        Particles of each shape at each angle; `NORMAL_FACTOR` times as many at normal impact.
    seed : int
    tick : callable
        Called with 1 for each sample.
    """
    samples: dict[tuple[str, str, float], SampleStatistics] = {}
    for i, alpha_deg in enumerate(ANGLES):
        size = count * (NORMAL_FACTOR if alpha_deg == 90.0 else 1)
        for k, shape in enumerate(SHAPES):
            keys = (seed, i * len(SHAPES) + k)
            samples[DIRECT, shape, alpha_deg] = _simulated(config, shape, alpha_deg, size, keys)
            tick(1)
        if table_covers(table, alpha_deg):
            index = np.arange(size)
            state = table.sample(np.radians(alpha_deg), SPEED, seed=seed, hit=i, index=index)
            drawn = sample_statistics_of(TABLE, MIXTURE, alpha_deg, state)
            samples[TABLE, MIXTURE, alpha_deg] = drawn
    spheres = {alpha_deg: _sphere(config, alpha_deg, seed) for alpha_deg in ANGLES}
    return FigureStatistics(config, seed, samples, spheres)
