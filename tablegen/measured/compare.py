"""Comparison of simulated means and spreads with measured ones."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tablegen.config.config import Config
from tablegen.config.defaults import COMPARE_COUNT
from tablegen.measured.measurements import QUANTITIES, Measurements, impact_speeds
from tablegen.measured.moments import SimulatedMoments
from tablegen.measured.reader import read_measurements
from tablegen.measured.simulated_rows import Scenario, SimulatedRows
from tablegen.model.float_array import FloatArray


@dataclass(frozen=True)
class Agreement:
    """Means, or standard deviations, of one quantity at n conditions; arrays of shape (n,).

    NaN if nothing was measured, or a standard error is not known.
    """

    measured: FloatArray
    #: Standard error, from the count and the spread of the row.
    measured_error: FloatArray
    simulated: FloatArray
    #: One standard deviation of the results of other seeds.
    simulated_error: FloatArray

    @property
    def deviation(self) -> FloatArray:
        """Simulated less measured values."""
        return self.simulated - self.measured

    @property
    def in_errors(self) -> FloatArray:
        """Deviation over the standard error of both together."""
        error = np.hypot(self.measured_error, self.simulated_error)
        return self.deviation / np.where(error > 0.0, error, np.nan)

    @property
    def rms(self) -> float | None:
        """Root mean square of the deviations; None if nothing was measured."""
        known = self.deviation[np.isfinite(self.deviation)]
        return float(np.sqrt(np.mean(known**2))) if known.size else None

    @property
    def largest(self) -> float | None:
        """Largest absolute deviation; None if nothing was measured."""
        known = np.abs(self.deviation[np.isfinite(self.deviation)])
        return float(known.max()) if known.size else None


@dataclass(frozen=True)
class MeasuredComparison:
    """Simulated and measured rebounds; arguments as for `compare`."""

    #: Name of the material pair.
    pair: str
    #: Simulated part of the pair's population; None: all.
    shape: str | None
    measured: Measurements
    #: Impact speeds of the simulation, m/s, (n,).
    speed: FloatArray
    #: Whether rebounds of this pair do not depend on the speed.
    speed_independent: bool
    count: int
    seed: int
    wall_tilt_deg: float
    #: For each quantity that was measured.
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
    """Simulate measured impacts and compare the rebounds.

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
    scenario = Scenario.of(config, wall_tilt_deg)
    if shape is not None:
        scenario = scenario._replace(population=config.population.restricted_to(shape))
    rows = SimulatedRows(scenario, data.alpha_deg, speeds, seed=seed, threads=threads)
    means, spreads = _agreements(data, rows.moments(count, progress))
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
    """Pair measured means and spreads with simulated ones."""
    means, spreads = {}, {}
    for name in QUANTITIES:
        moments = measured.moments[name]
        if not np.isfinite(moments.mean).any():
            continue
        error = moments.std / np.sqrt(measured.count)
        means[name] = Agreement(
            moments.mean, error, simulated.mean[name], simulated.mean_error[name]
        )
        # the error of a spread is taken to be that of a normal law
        spreads[name] = Agreement(
            moments.std, error / np.sqrt(2.0), simulated.std[name], simulated.std_error[name]
        )
    return means, spreads
