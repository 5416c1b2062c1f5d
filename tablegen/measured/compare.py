"""Comparison of simulated means and spreads with measured ones, as a record, text and JSON."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tablegen.config.config import Config
from tablegen.config.defaults import COMPARE_COUNT
from tablegen.measured.measurements import QUANTITIES, SPREAD, Measurements, impact_speeds
from tablegen.measured.moments import SimulatedMoments
from tablegen.measured.reader import read_measurements
from tablegen.measured.result import ComparedNumber
from tablegen.measured.simulated_rows import SimulatedRows
from tablegen.model.float_array import FloatArray
from tablegen.presentation import TextTable, table_lines

#: Quantities by which pairs are ranked.
_RANKED = ("e_n", "e_t")

#: Heads of the columns of means, and of spreads.
_HEAD = ("measured", "simulated", "+-", "diff", "in errors")


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
    """Simulated rebounds beside measured ones, from `compare`.

    Attributes
    ----------
    pair : str
        Name of the material pair.
    shape : str or None
        Simulated part of the population; None for all of it.
    measured : Measurements
        The measured rebounds, at n conditions.
    speed : float64 array, shape (n,)
        Impact speeds of the simulation [m/s].
    count : int
        Argument of `compare`.
    seed : int
        Argument of `compare`.
    wall_tilt_deg : float
        Argument of `compare`.
    means : dict of Agreement
        Means, measured and simulated, by the name of the quantity.
    spreads : dict of Agreement
        Standard deviations, measured and simulated, by the name of the quantity.
    """

    pair: str
    shape: str | None
    measured: Measurements
    speed: FloatArray
    count: int
    seed: int
    wall_tilt_deg: float
    means: Mapping[str, Agreement]
    spreads: Mapping[str, Agreement]

    def numbers(self) -> Iterator[ComparedNumber]:
        """List all measured means and spreads beside the simulated ones."""
        for agreements, end in ((self.means, ""), (self.spreads, SPREAD)):
            for name, agreement in agreements.items():
                for row in np.flatnonzero(np.isfinite(agreement.measured)).tolist():
                    yield ComparedNumber(
                        row=row,
                        alpha_deg=float(self.measured.alpha_deg[row]),
                        speed=float(self.speed[row]),
                        column=name + end,
                        measured=float(agreement.measured[row]),
                        error=_number(agreement.measured_error[row]),
                        simulated=float(agreement.simulated[row]),
                        chance=float(agreement.simulated_error[row]),
                    )

    @property
    def rms(self) -> float:
        """Root mean square deviation of all means of e_n and e_t; NaN if none was measured."""
        deviations = [self.means[name].deviation for name in _RANKED if name in self.means]
        known = np.concatenate([[], *deviations])
        known = known[np.isfinite(known)]
        return float(np.sqrt(np.mean(np.square(known)))) if known.size else math.nan


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
    """Simulate rebounds at measured conditions, and compare them with the measurements.

    Parameters
    ----------
    config : Config
        Configuration with laws, particles and numerical parameters, from `tablegen.load_config`.
    measured : Measurements or str
        Measured rebounds from `tablegen.read_measurements`, or the name or path of a file.
    count : int, optional
        Number of particles of each shape at each condition, 2 or more.
    seed : int, optional
        Seed of the simulation, 0 to 2**64 - 1.
    speed : float, optional
        Impact speed of rows that state none [m/s].
    wall_tilt_deg : float, optional
        Standard deviation of the tilt of the facets of a rough wall [degrees], 0 to 28.65. By
        default the wall is smooth.
    shape : str, optional
        One shape to simulate alone, such as "prism", or "mixture" for all shapes but the sphere. By
        default the particles are those of the configuration.
    threads : int, optional
        Number of threads, which does not change the result. By default one for each processor.
    progress : bool, optional
        Whether to show a progress bar on standard error.

    Returns
    -------
    MeasuredComparison
        Means and standard deviations, measured and simulated, with their errors.

    Raises
    ------
    InputError
        If an argument is out of range, if the measurements cannot be used, or if the rebounds
        depend on the speed and a row has none.
    RuntimeError
        If a particle is still in contact after 10**8 collisions.

    Examples
    --------
    >>> from tablegen import compare, load_config
    >>> result = compare(load_config("kharaz-2001"), "kharaz-2001", count=2)
    >>> sorted(result.means)
    ['e_t', 'omega_z', 'rebound_angle_deg']
    """
    data = measured if isinstance(measured, Measurements) else read_measurements(measured)
    speeds = impact_speeds(config.pair, data, speed)
    if shape is not None:
        part = config.population.restricted_to(shape)
        config = config.model_copy(update={"population": part})
    rows = SimulatedRows(
        config, data.alpha_deg, speeds, seed=seed, wall_tilt_deg=wall_tilt_deg, threads=threads
    )
    means, spreads = _agreements(data, rows.moments(count, progress))
    return MeasuredComparison(
        pair=config.pair_name,
        shape=shape,
        measured=data,
        speed=speeds,
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
    for name, (mean, std) in measured.moments.items():
        if np.isfinite(mean).any():
            errors = measured.errors(name)
            ours = simulated.mean[name], simulated.mean_error[name]
            means[name] = Agreement(mean, errors.mean, *ours)
            ours = simulated.std[name], simulated.std_error[name]
            spreads[name] = Agreement(std, errors.std, *ours)
    return means, spreads


def ranking_text(comparisons: Sequence[MeasuredComparison]) -> str:
    """Write one table of several pairs in the given order."""
    rows = []
    for one in comparisons:
        parts = [one.means[name].rms if name in one.means else None for name in _RANKED]
        cells = ["-" if x is None or math.isnan(x) else f"{x:.3f}" for x in (*parts, one.rms)]
        rows.append([one.pair, *cells])
    title = f"rms deviations of the means of {comparisons[0].measured.name}"
    if any(math.isfinite(one.rms) for one in comparisons):
        title += ", the nearest pair first"
    else:
        title += ": not ranked, because neither e_n nor e_t was measured"
    return str(TextTable(title, ("pair", *_RANKED, "both"), rows))


def comparison_text(comparison: MeasuredComparison) -> str:
    """Write a table for each measured quantity."""
    shape, tilt = comparison.shape or "all shapes", comparison.wall_tilt_deg
    wall = f"facets tilted by {tilt:g} degrees" if tilt else "smooth"
    lines = [
        f"{comparison.pair} ({shape}; wall {wall}) beside {comparison.measured.name}",
        f"{comparison.count} particles of each shape at each condition, seed {comparison.seed}",
    ]
    for name in comparison.means:
        lines += ["", *_quantity_lines(comparison, name)]
    lines += ["", "+-: chance error of the simulation, one standard deviation"]
    lines += ["diff: simulated less measured; in errors: over the standard error of both"]
    return "\n".join(lines)


def _quantity_lines(comparison: MeasuredComparison, name: str) -> list[str]:
    """Write the table of a quantity, and a summary of the means and one of the spreads."""
    digits = QUANTITIES[name].digits
    head = ["angle", "m/s"]
    conditions = comparison.measured.alpha_deg, comparison.speed
    columns = [[f"{x:.4g}" for x in part] for part in conditions]
    summary = []
    for part, agreement in (("mean", comparison.means[name]), ("spread", comparison.spreads[name])):
        if agreement.rms is None:
            continue
        # errors of measurements are seldom known
        shown = len(_HEAD) if np.isfinite(agreement.in_errors).any() else len(_HEAD) - 1
        head += [f"{part} {_HEAD[0]}", *_HEAD[1:shown]]
        columns += _columns(agreement, digits)[:shown]
        summary.append(
            f"  {part}: rms deviation {agreement.rms:.{digits}f}, "
            f"largest {agreement.largest:.{digits}f}"
        )
    cells = list(zip(*columns, strict=True))
    rows = [cells[k] for k in np.flatnonzero(np.isfinite(comparison.means[name].measured))]
    return [QUANTITIES[name].title, *(f"  {line}" for line in table_lines(head, rows)), *summary]


def _columns(agreement: Agreement, digits: int) -> list[list[str]]:
    """Write the columns of means, or of spreads, in the order of `_HEAD`."""
    columns = (
        (agreement.measured, digits),
        (agreement.simulated, digits),
        (agreement.simulated_error, digits + 1),
        (agreement.deviation, digits),
        (agreement.in_errors, 1),
    )
    return [
        ["-" if math.isnan(value) else f"{value:.{places}f}" for value in values]
        for values, places in columns
    ]


def comparison_tree(comparison: MeasuredComparison) -> dict[str, Any]:
    """Give everything as plain data for JSON; None: not measured, undefined or unknown."""
    parts, data = {"mean": comparison.means, "spread": comparison.spreads}, comparison.measured
    summary = {
        name: {
            f"{part}_{measure}_deviation": getattr(agreements[name], measure)
            for part, agreements in parts.items()
            for measure in ("rms", "largest")
        }
        for name in comparison.means
    }
    rows = [
        {
            "alpha_deg": float(data.alpha_deg[row]),
            "speed": float(comparison.speed[row]),
            "speed_stated": not math.isnan(data.speed[row]),
            "count": _number(data.count[row]),
            "source": data.source[row],
            "remarks": data.remarks[row],
            **{
                name: {
                    part: _agreement_at(agreements[name], row) for part, agreements in parts.items()
                }
                for name in comparison.means
            },
        }
        for row in range(len(comparison.speed))
    ]
    return {
        "pair": comparison.pair,
        "shape": comparison.shape,
        "measurements": data.name,
        "about": dict(data.about),
        "count": comparison.count,
        "seed": comparison.seed,
        "wall_tilt_deg": comparison.wall_tilt_deg,
        "summary": summary,
        "rows": rows,
    }


def _agreement_at(agreement: Agreement, row: int) -> dict[str, float | None]:
    """Collect the numbers of a mean, or of a spread."""
    names = ("measured", "measured_error", "simulated", "simulated_error", "deviation")
    numbers = {name: _number(getattr(agreement, name)[row]) for name in names}
    return numbers | {"deviation_over_error": _number(agreement.in_errors[row])}


def _number(value: float) -> float | None:
    """Turn NaN into None."""
    return None if math.isnan(value) else float(value)
