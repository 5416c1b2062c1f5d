"""Simulated means and spreads beside measured ones, with the chance error of each."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tablegen.config.config import Config
from tablegen.config.defaults import COMPARE_COUNT
from tablegen.config.population import Population
from tablegen.measured.impact_speeds import impact_speeds
from tablegen.measured.reader import read_measurements
from tablegen.measured.records import QUANTITIES, Measurements
from tablegen.measured.simulated_moments import SimulatedRows
from tablegen.measured.strata import SimulatedMoments
from tablegen.model.float_array import FloatArray


@dataclass(frozen=True)
class Agreement:
    """Means, or standard deviations, of one quantity at n conditions; arrays of shape (n,).

    NaN where nothing was measured, and where a standard error is not known.
    """

    measured: FloatArray
    #: Standard error, from the count and the spread of the row.
    measured_error: FloatArray
    simulated: FloatArray
    #: One standard deviation of what another seed would give.
    simulated_error: FloatArray

    @property
    def deviation(self) -> FloatArray:
        """What is simulated less what is measured."""
        return self.simulated - self.measured

    @property
    def in_errors(self) -> FloatArray:
        """Deviation over the standard error of both together."""
        error = np.hypot(self.measured_error, self.simulated_error)
        return self.deviation / np.where(error > 0.0, error, np.nan)


@dataclass(frozen=True)
class MeasuredComparison:
    """Simulated rebounds beside measured ones.

    Attributes
    ----------
    pair : str
        Name of the material pair.
    shape : str or None
        What was simulated of the pair's population; None: all.
    measured : Measurements
    speed : (n,) float64
        Impact speeds of the simulation, m/s.
    speed_independent : bool
        Whether rebounds of this pair do not depend on the speed.
    count, seed, wall_tilt_deg
        As for `compare`.
    means, spreads : mapping of str to Agreement
        For each quantity that was measured.
    """

    pair: str
    shape: str | None
    measured: Measurements
    speed: FloatArray
    speed_independent: bool
    count: int
    seed: int
    wall_tilt_deg: float
    means: Mapping[str, Agreement]
    spreads: Mapping[str, Agreement]


def compare(
    config: Config,
    measured: Measurements | str,
    *,
    count: int = COMPARE_COUNT,
    seed: int = 1,
    speed: float | None = None,
    wall_tilt_deg: float = 0.0,
    shape: str | None = None,
    threads: int | None = None,
    progress: bool = False,
) -> MeasuredComparison:
    """Simulate what was measured, and put both side by side.

    Parameters
    ----------
    config : Config
        From `tablegen.load_config`: laws, particles and numerical parameters.
    measured : Measurements or str
        From `tablegen.read_measurements`, or its argument.
    count : int
        Particles of each shape at each condition, 2 or more.
    seed : int
        0 to 2**64 - 1.
    speed : float, optional
        Impact speed of the rows that state none, m/s.
    wall_tilt_deg : float
        Standard deviation of the tilt of the facets of a rough wall, degrees, up to 28.65.
    shape : str, optional
        Part of the population, as for `tablegen.config.population.Population.restricted_to`.
    threads : int, optional
        Default: one a processor. The result does not depend on it.
    progress : bool
        Show a progress bar on standard error.

    Returns
    -------
    MeasuredComparison

    Raises
    ------
    InputError
        If an argument is out of range, the measurements cannot be used, or a row states no speed,
        none is given and the rebounds depend on it.
    RuntimeError
        If a particle is still in contact after 10**8 collisions.
    """
    data = measured if isinstance(measured, Measurements) else read_measurements(measured)
    speeds = impact_speeds(config.pair, data, speed)
    population: Population = config.population
    if shape is not None:
        population = population.restricted_to(shape)
    found = SimulatedRows(
        config.pair,
        population,
        data.alpha_deg,
        speeds,
        seed=seed,
        numerics=config.model,
        wall_tilt_deg=wall_tilt_deg,
        threads=threads,
    ).moments(count, progress)
    means, spreads = _agreements(data, found)
    return MeasuredComparison(
        pair=config.pair_name,
        shape=shape,
        measured=data,
        speed=speeds,
        speed_independent=not config.pair.restitution.depends_on_speed,
        count=count,
        seed=seed,
        wall_tilt_deg=wall_tilt_deg,
        means=means,
        spreads=spreads,
    )


def _agreements(
    measured: Measurements, simulated: SimulatedMoments
) -> tuple[dict[str, Agreement], dict[str, Agreement]]:
    """Means and spreads of what was measured, beside those of the simulation."""
    means, spreads = {}, {}
    for name in QUANTITIES:
        moments = measured.moments[name]
        if not np.isfinite(moments.mean).any():
            continue
        error = moments.std / np.sqrt(measured.count)
        ours = simulated.mean[name], simulated.mean_error[name]
        means[name] = Agreement(moments.mean, error, *ours)
        # the error of a spread is taken to be that of a normal law
        ours = simulated.std[name], simulated.std_error[name]
        spreads[name] = Agreement(moments.std, error / np.sqrt(2.0), *ours)
    return means, spreads
