"""One fit of a calibration: laws for given grains, simulated beside the measured numbers."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from sampler.errors import InputError
from tablegen.config.config import Config
from tablegen.measured.free_numbers import FreeNumbers
from tablegen.measured.measurements import QUANTITIES, SPREAD, Measurements, impact_speeds
from tablegen.measured.moments import SimulatedMoments
from tablegen.measured.pair_file import fitted_config
from tablegen.measured.result import ComparedNumber, Fit
from tablegen.measured.simulated_rows import SimulatedRows
from tablegen.measured.smoothest import Penalty, bootstrapped, polished, smoothest
from tablegen.model.float_array import FloatArray

#: Rebounds of a search: least and most at a row, and in all rows; the report has four times them.
_LEAST_REBOUNDS, _MOST_REBOUNDS, _ALL_REBOUNDS, _REPORT_FACTOR = 600, 6000, 60_000, 4

#: Angle [degrees] from which e_t is the ratio of two small velocities, and is not followed.
_STEEP = 88.0

#: Angle without a mean.
_OUT_OF_PLANE = "out_of_plane_deg"

#: Bits in which the seeds of the last steps and of the report differ from that of the search.
_LAST_SEED, _REPORT_SEED = 0x510E, 0x5EED

#: Share of a number that the data must determine, and not smoothness, for a standard error; and the
#: least one. A smaller one is that of a number at a bound.
_DETERMINED_SHARE, _LEAST_ERROR = 0.5, 1e-6

#: Last steps; and the worst miss from which they cannot reach the means.
_LAST_STEPS, _FAR = 4, 2.0


class Target(NamedTuple):
    """A measured mean that a fit follows."""

    row: int
    quantity: str
    measured: float
    tolerance: float


def make_targets(data: Measurements) -> list[Target]:
    """List the means; one is held within two standard errors by its count, if that is more."""
    targets = []
    for row, alpha in enumerate(data.alpha_deg):
        for name, quantity in QUANTITIES.items():
            mean = float(data.moments[name].mean[row])
            # by symmetry there is no mean out of the plane
            if np.isfinite(mean) and name != _OUT_OF_PLANE and _is_followed(name, alpha):
                error = data.errors(name).mean[row]
                tolerance = float(np.fmax(quantity.tolerance, 2.0 * error))
                targets.append(Target(row, name, mean, tolerance))
    if not targets:
        names = ", ".join(name for name in QUANTITIES if name != _OUT_OF_PLANE)
        remedy = f"give a mean of {names} (e_t: below {_STEEP:g} degrees)"
        raise InputError("", problem="has no mean to fit", remedy=remedy, source=data.name)
    return targets


def _is_followed(name: str, alpha_deg: float) -> bool:
    """Tell whether a quantity means something at an angle."""
    return name != "e_t" or alpha_deg < _STEEP


@dataclass(frozen=True)
class Fitter:
    """What all fits to some measurements share."""

    data: Measurements
    targets: list[Target]
    #: Impact speed of rows that state none.
    speed: float | None
    seed: int
    threads: int | None

    def fit(
        self, grains: str, start: Config, names: Sequence[str], name: str, give_up: bool = False
    ) -> Fit:
        """Fit free fields of a pair, and simulate the result with other random numbers.

        With ``give_up``, grains that miss a mean by far are left early.
        """
        numbers = FreeNumbers(start, names)
        speeds = impact_speeds(start.pair, self.data, self.speed)
        count = min(_MOST_REBOUNDS, max(_ALL_REBOUNDS // len(speeds), _LEAST_REBOUNDS)) // len(
            start.population.strata()
        )

        def misses(x: FloatArray, count: int = count, seed: int = self.seed) -> FloatArray:
            trial = start.model_copy(update={"pair": numbers.pair(x)})
            mean = self._moments(trial, speeds, count, seed).mean
            off = [(mean[t.quantity][t.row] - t.measured) / t.tolerance for t in self.targets]
            return np.array(off)

        solution = smoothest(numbers, misses, give_up)
        if solution.worst < _FAR:
            last = self.seed ^ _LAST_SEED
            solution = polished(
                numbers, lambda x: misses(x, _REPORT_FACTOR * count, last), solution, _LAST_STEPS
            )
        samples = bootstrapped(numbers, solution, [t.row for t in self.targets], self.seed)
        errors = np.std([numbers.numbers(x) for x in samples], axis=0)
        known = Penalty(numbers).determined(solution) > _DETERMINED_SHARE
        config = fitted_config(start, numbers.changes(solution.x), name, self.data, speeds)
        report = self.seed ^ _REPORT_SEED
        simulated = self._moments(config, speeds, _REPORT_FACTOR * count, report)
        return Fit(
            grains=grains,
            config=config,
            labels=numbers.labels,
            values=numbers.numbers(solution.x),
            errors=np.where(known & (errors > _LEAST_ERROR), errors, np.nan),
            numbers=tuple(self._compared(simulated)),
        )

    def _moments(
        self, config: Config, speeds: FloatArray, count: int, seed: int
    ) -> SimulatedMoments:
        """Simulate the rows; all spheres rebound alike."""
        angles = self.data.alpha_deg
        rows = SimulatedRows(config, angles, speeds, seed=seed, threads=self.threads)
        return rows.moments(2 if config.population.only_spheres else count)

    def _compared(self, simulated: SimulatedMoments) -> Iterator[ComparedNumber]:
        """Put measured means and spreads beside simulated ones."""
        for one in self.targets:
            number = self._number(simulated, one.row, one.quantity, "mean")
            yield replace(number, tolerance=one.tolerance)
        for name, moments in self.data.moments.items():
            for row, alpha in enumerate(self.data.alpha_deg):
                if np.isfinite(moments.std[row]) and _is_followed(name, alpha):
                    yield self._number(simulated, row, name, "std")

    def _number(self, ours: SimulatedMoments, row: int, name: str, part: str) -> ComparedNumber:
        """Put a measured mean or spread beside the simulated one."""
        data = self.data
        speed, error = data.speed[row], getattr(data.errors(name), part)[row]
        return ComparedNumber(
            row=row,
            alpha_deg=float(data.alpha_deg[row]),
            speed=float(speed) if np.isfinite(speed) else None,
            column=name + (SPREAD if part == "std" else ""),
            measured=float(getattr(data.moments[name], part)[row]),
            error=float(error) if np.isfinite(error) else None,
            simulated=float(getattr(ours, part)[name][row]),
            chance=float(getattr(ours, f"{part}_error")[name][row]),
        )
