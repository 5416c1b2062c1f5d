"""One fit of a calibration: laws for given grains, simulated beside the measured numbers."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from time import process_time

import numpy as np

from sampler.errors import InputError
from tablegen.config.config import Config
from tablegen.measured.free_numbers import FreeNumbers
from tablegen.measured.measurements import QUANTITIES, SPREAD, Measurements, impact_speeds
from tablegen.measured.moments import SimulatedMoments
from tablegen.measured.pair_file import fitted_config
from tablegen.measured.result import ComparedNumber, Fit
from tablegen.measured.simulated_rows import Scenario, SimulatedRows
from tablegen.measured.smoothest import Penalty, bootstrapped, polished, smoothest
from tablegen.model.float_array import FloatArray

#: Rebounds at a row in a search, least and most, and in all rows; and those of the report over it.
_LEAST, _MOST, _ALL, _REPORT = 600, 6000, 60_000, 4

#: Angles [degrees] from which e_t is hardly anything over hardly anything.
_STEEP = 88.0

#: Seeds differ by these from that of the search: of the last steps, and of the report.
_LAST_SEED, _REPORT_SEED = 0x510E, 0x5EED

#: Last steps; and the worst miss from which they cannot hold the means.
_LAST_STEPS, _FAR = 4, 2.0


@dataclass(frozen=True)
class Targets:
    """The m measured means that a fit follows; arrays of shape (m,)."""

    rows: list[int]
    quantities: list[str]
    measured: FloatArray
    tolerance: FloatArray

    def misses(self, simulated: SimulatedMoments) -> FloatArray:
        """Subtract measured from simulated means, over the tolerances."""
        places = zip(self.quantities, self.rows, strict=True)
        values = np.array([simulated.mean[name][row] for name, row in places])
        return (values - self.measured) / self.tolerance


def make_targets(data: Measurements) -> Targets:
    """List the means; one is held within two standard errors by its count, if that is more."""
    found = []
    for row, alpha in enumerate(data.alpha_deg):
        for name, quantity in QUANTITIES.items():
            mean, error = float(data.moments[name].mean[row]), data.errors(name).mean[row]
            # by symmetry there is no mean out of the plane
            if np.isfinite(mean) and name != "out_of_plane_deg" and _has(name, alpha):
                tolerance = float(np.fmax(quantity.tolerance, 2.0 * error))
                found.append((row, name, mean, tolerance))
    if not found:
        words = f"a mean of {', '.join(QUANTITIES)} (e_t: below {_STEEP:g} degrees)"
        raise InputError(f"{data.name}: got no mean to follow, allowed: {words}")
    rows, names, measured, tolerance = zip(*found, strict=True)
    return Targets(list(rows), list(names), np.array(measured), np.array(tolerance))


def _has(name: str, alpha_deg: float) -> bool:
    """Tell whether a quantity means something at an angle."""
    return name != "e_t" or alpha_deg < _STEEP


@dataclass(frozen=True)
class Fitter:
    """What all fits to some measurements share."""

    data: Measurements
    targets: Targets
    #: Impact speed of rows that state none.
    speed: float | None
    seed: int
    threads: int | None

    def fit(self, grains: str, start: Config, names: Sequence[str], name: str) -> Fit:
        """Fit free fields of a pair, and simulate the result with other random numbers."""
        begun, numbers = process_time(), FreeNumbers(start, names)
        speeds = impact_speeds(start.pair, self.data, self.speed)
        count = min(_MOST, max(_ALL // len(speeds), _LEAST)) // len(start.population.strata())

        def misses(x: FloatArray, count: int = count, seed: int = self.seed) -> FloatArray:
            trial = start.model_copy(update={"pair": numbers.pair(x)})
            return self.targets.misses(self._moments(trial, speeds, count, seed))

        found = smoothest(numbers, misses)
        if found.worst < _FAR:
            last = self.seed ^ _LAST_SEED
            found = polished(
                numbers, lambda x: misses(x, _REPORT * count, last), found, _LAST_STEPS
            )
        samples = bootstrapped(numbers, found, self.targets.rows, self.seed)
        config = fitted_config(start, numbers.changes(found.x), name, self.data, speeds)
        report = self.seed ^ _REPORT_SEED
        simulated = self._moments(config, speeds, _REPORT * count, report)
        return Fit(
            grains=grains,
            config=config,
            labels=numbers.labels,
            values=numbers.numbers(found.x),
            errors=np.std([numbers.numbers(x) for x in samples], axis=0),
            determined=Penalty(numbers).determined(found),
            numbers=tuple(self._compared(simulated)),
            cpu_seconds=process_time() - begun,
        )

    def _moments(
        self, config: Config, speeds: FloatArray, count: int, seed: int
    ) -> SimulatedMoments:
        """Simulate the rows; all spheres rebound alike."""
        scenario, angles = Scenario.of(config, 0.0), self.data.alpha_deg
        rows = SimulatedRows(scenario, angles, speeds, seed=seed, threads=self.threads)
        return rows.moments(2 if config.population.only_spheres else count)

    def _compared(self, simulated: SimulatedMoments) -> Iterator[ComparedNumber]:
        """Put measured means and spreads beside simulated ones."""
        targets = self.targets
        followed = zip(targets.rows, targets.quantities, targets.tolerance.tolist(), strict=True)
        for row, name, allowed in followed:
            yield self._number(simulated, row, name, "mean", allowed)
        for name, moments in self.data.moments.items():
            for row, alpha in enumerate(self.data.alpha_deg):
                if np.isfinite(moments.std[row]) and _has(name, alpha):
                    yield self._number(simulated, row, name, "std")

    def _number(
        self,
        simulated: SimulatedMoments,
        row: int,
        name: str,
        part: str,
        allowed: float | None = None,
    ) -> ComparedNumber:
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
            simulated=float(getattr(simulated, part)[name][row]),
            chance=float(getattr(simulated, f"{part}_error")[name][row]),
            tolerance=allowed,
        )
