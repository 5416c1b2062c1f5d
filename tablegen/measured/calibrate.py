"""Calibration: fit a material pair to measured rebounds."""

import hashlib
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from time import process_time
from typing import Any, NamedTuple

import numpy as np
from threadpoolctl import threadpool_limits

from sampler.arguments import as_integer
from sampler.errors import InputError
from sampler.files import check_output, find_measurements, write_text
from tablegen.checkpoints import CheckpointStore
from tablegen.config.config import Config
from tablegen.config.defaults import CALIBRATE_COUNT
from tablegen.measured.measurements import SPREAD, Measurements, Spreads, impact_speeds
from tablegen.measured.pair_file import fitted_config, with_comments
from tablegen.measured.parameters import SHAPES, WALL_TILT, default_names, make_parameters
from tablegen.measured.reader import read_measurements
from tablegen.measured.result import Calibration, FittedNumber, Task
from tablegen.measured.search import STAGES, Search, Stage, make_targets, most_particles_after
from tablegen.measured.simulated_rows import Scenario, SimulatedRows
from tablegen.measured.trials import Evaluations, TrialPairs
from tablegen.measured.uncertainty import errors_of_numbers, uncertainty_of_fit
from tablegen.model.float_array import FloatArray
from tablegen.progress import bar
from tablegen.simulation.simulate import check_run

#: Fewest particles of each shape at each condition in the last stage of a search.
_FEWEST = 200

#: Most rows of a fit; two angles have 50 CPU seconds in eight rows, and these half an hour.
_MOST_ROWS = 400

#: Least and most time of a search over that of its most particles with the start pair; and the
#: particles of each shape at each condition that are timed.
_COST, _TIMED = (0.25, 1.5), 1000

#: Angles [degrees] that differ by less are the same.
_SAME_ANGLE = 1e-6

#: The seed of the reported numbers differs by this from that of the fit, whose coordinates follow
#: the chance of its own random numbers a little.
_OTHER_SEED = 0x5EED


class _Part(NamedTuple):
    """Rows of the measurements with their search."""

    rows: list[int]
    measurements: Measurements
    search: Search


def calibrate(
    measured: Measurements | str | Path,
    start: Config,
    output: str | Path | None = None,
    *,
    free: Sequence[str] | None = None,
    hold_out: Sequence[float] = (),
    spreads: Spreads = "upper-bound",
    count: int = CALIBRATE_COUNT,
    seed: int = 1,
    speed: float | None = None,
    wall_tilt_deg: float = 0.0,
    resume: bool = False,
    discard: bool = False,
    threads: int | None = None,
    progress: bool = False,
) -> Calibration:
    """Fit free parameters of a material pair to measured rebounds, by least squares.

    Means and, if measured, spreads are weighted by their accuracies, which follow from the measured
    spread and the count of particles. Without a count they are assumed
    (`tablegen.measured.search.make_targets`), and the errors of the fit follow from its residuals.

    The search begins at the given pair and at random ones, with few particles, and goes on from the
    best with more (`tablegen.measured.search`).

    Parameters
    ----------
    measured : Measurements, str or Path
        A record, a name such as "grant-tabakoff-1975", or the path of a file.
    start : Config
        The pair to start from: laws, population, and the rest of the new pair.
    output : str or Path, optional
        File to write the fitted pair to. Finished simulations stay in ``OUTPUT.parts`` until then.
    free : sequence of str, optional
        Paths of the free fields (`tablegen.measured.parameters.allowed_names`); by default the
        coefficients of both laws and the mean aspect ratio.
    hold_out : sequence of float
        Angles [degrees] whose rows are predicted and not used.
    spreads : str
        What measured spreads are for: "upper-bound", because they also hold those of size, speed
        and wall; "fit", to be followed like means; or "ignore".
    count : int
        Particles of each shape at each condition, 200 or more.
    seed : int
        0 to 2**64 - 1, for the particles and the random starts.
    speed : float, optional
        Impact speed [m/s] of rows that state none; needed if the law depends on it.
    wall_tilt_deg : float
        Roughness of the wall, degrees: fixed, or the start of the search if it is free.
    resume, discard : bool
        Use, or remove, the simulations of an interrupted run. With neither, they are refused.
    threads : int, optional
        Default: one a processor. The result does not depend on it.
    progress : bool
        Say the cost before the search, and show a progress bar, on standard error.

    Raises
    ------
    InputError
        If measurements, pair and free parameters do not go together, or the output cannot be
        written.
    """
    as_integer("count", count, _FEWEST, 2**31, f"{_FEWEST} or more")
    check_run(count, seed, 0, threads)
    checksum = ""
    if not isinstance(measured, Measurements):
        checksum = hashlib.sha256(find_measurements(measured).read_bytes()).hexdigest()
        measured = read_measurements(measured)
    used, held = _split_rows(measured, hold_out)
    means = sum(int(np.isfinite(m.mean[used]).sum()) for m in measured.moments.values())
    names = tuple(default_names(start, means) if free is None else free)
    _check_spreads(measured, start, names, wall_tilt_deg)
    task = Task(
        measurements=measured,
        checksum=checksum,
        start=start,
        free=names,
        used=used,
        held=held,
        speeds=impact_speeds(start.pair, measured, speed),
        speed=speed,
        wall_tilt_deg=wall_tilt_deg,
        spreads=spreads,
        count=count,
        seed=seed,
        threads=threads,
    )
    path = check_output(output) if output is not None else None
    trials = TrialPairs(start, make_parameters(start, names, wall_tilt_deg), wall_tilt_deg)
    with threadpool_limits(limits=1, user_api="blas"):
        if path is None:
            return _fitted(task, trials, None, "fitted", progress)
        store = CheckpointStore(path, task.fingerprint, resume=resume, discard=discard)
        with store:
            made = _fitted(task, trials, store, _pair_name(path), progress)
            write_text(path, made.config.text)
            store.remove()
    return made


def _split_rows(
    measurements: Measurements, hold_out: Sequence[float]
) -> tuple[list[int], list[int]]:
    """Separate the rows that a fit uses from those at held-out angles [degrees]."""
    angles = measurements.alpha_deg
    is_held = np.zeros(len(angles), dtype=bool)
    for angle in hold_out:
        same = np.abs(angles - angle) < _SAME_ANGLE
        if not same.any():
            allowed = ", ".join(f"{a:g}" for a in np.unique(angles))
            raise InputError(f"hold_out: got {angle:g} degrees, allowed: {allowed}")
        is_held |= same
    if is_held.all():
        raise InputError(
            f"hold_out: got all {len(angles)} rows, allowed: fewer, so that some remain"
        )
    return np.flatnonzero(~is_held).tolist(), np.flatnonzero(is_held).tolist()


def _check_spreads(
    measurements: Measurements, config: Config, free: Sequence[str], wall_tilt_deg: float
) -> None:
    """Refuse measured spreads if all rebounds of the pair are equal."""
    varied = wall_tilt_deg > 0.0 or any(n == WALL_TILT or n.startswith(SHAPES) for n in free)
    spread = [n for n, m in measurements.moments.items() if np.isfinite(m.std).any()]
    if config.population.only_spheres and not varied and spread:
        raise InputError(
            f"{spread[0]}{SPREAD}: got spreads, which spheres on a smooth wall do not have, "
            f"allowed: other shapes, or {WALL_TILT} among the free parameters"
        )


def _pair_name(path: Path) -> str:
    """Name a pair after its file, with the characters that names have."""
    plain = "".join(c if c.isascii() and (c.isalnum() or c in "._-") else "-" for c in path.stem)
    return plain.lstrip("._-")[:100] or "fitted"


def _fitted(
    task: Task, trials: TrialPairs, store: CheckpointStore | None, name: str, progress: bool
) -> Calibration:
    """Search, and work out the result."""
    totals = [stage.most_particles(trials, task.count) for stage in STAGES]
    # slopes are also taken of the rows that are held out
    totals.append((1 + bool(task.held)) * most_particles_after(trials, task.count))
    with bar(progress, "particle", total=sum(totals), unit_scale=True) as counted:
        used, held = (
            _part(task, trials, rows, store, counted.update) for rows in (task.used, task.held)
        )
        m, p = len(used.search.targets), len(trials.labels)
        if m < p:
            raise InputError(
                f"free: got {p} free numbers for {m} measured means and spreads in "
                f"{len(used.rows)} rows, allowed: up to {m}"
            )
        if progress:
            counted.write(_cost_text(used.search, sum(totals)), file=sys.stderr)

        def begin(stage: Stage) -> None:
            counted.total = counted.n + sum(totals[STAGES.index(stage) :])
            counted.set_description_str(stage.name, refresh=False)

        x = used.search.run(task.seed, begin)
        counted.set_description_str("errors", refresh=False)
        x, *slopes = used.search.settle(x)
        found = uncertainty_of_fit(used.measurements, used.search, x, *slopes)
        speeds = task.speeds[task.used]
        config = fitted_config(task.start, trials.changes(x), name, used.measurements, speeds)
        numbers = [
            *_numbers(used, config, x, found.covariance, held_out=False),
            *_numbers(held, config, x, found.covariance, held_out=True),
        ]
    errors, correlation = errors_of_numbers(trials, x, found)
    made = Calibration(
        config=config,
        labels=trials.labels,
        given=trials.numbers(trials.space.start),
        values=trials.numbers(x),
        errors=errors,
        correlation=correlation,
        numbers=tuple(numbers),
        scatter=found.scatter,
        freedom=found.freedom,
        warnings=found.warnings,
        of_means=(used.search.of_means(trials.space.start), used.search.of_means(x)),
        wall_tilt_deg=trials.wall_tilt_deg(x),
    )
    return replace(made, config=with_comments(made, task))


def _cost_text(search: Search, particles: int) -> str:
    """Quote the time of a search of at most some particles, from that of a short simulation."""
    rows = search.evaluations.rows(search.evaluations.trials.space.start)
    before = process_time()
    rows.moments(_TIMED)
    seconds = (process_time() - before) / _TIMED * particles
    return f"tablegen: {_COST[0] * seconds:.0f} to {_COST[1] * seconds:.0f} s of CPU time"


def _part(
    task: Task,
    trials: TrialPairs,
    rows: list[int],
    store: CheckpointStore | None,
    on_simulated: Callable[[int], Any],
) -> _Part:
    part, speed = task.measurements.rows(rows), task.speeds[rows]
    if len(rows) > _MOST_ROWS:
        words = f"up to {_MOST_ROWS}: averages over ranges of angle and speed"
        raise InputError(f"{part.name}: got {len(rows)} rows to fit, allowed: {words}")
    moments = None
    if rows:
        scenario = Scenario.of(task.start, task.wall_tilt_deg)
        first = SimulatedRows(scenario, part.alpha_deg, speed, seed=task.seed, threads=task.threads)
        moments = first.moments(_FEWEST)
    evaluations = Evaluations(
        trials, part.alpha_deg, speed, task.seed, task.threads, store, on_simulated
    )
    targets = make_targets(part, moments, task.spreads)
    return _Part(rows, part, Search(evaluations, targets, task.count))


def _numbers(
    part: _Part, config: Config, x: FloatArray, covariance: FloatArray, held_out: bool
) -> list[FittedNumber]:
    """Simulate the measured numbers of the fitted pair with other random numbers."""
    if not part.rows:
        return []
    evaluations, targets, count = part.search.evaluations, part.search.targets, part.search.count
    scenario = Scenario.of(config, evaluations.trials.wall_tilt_deg(x))
    rows = evaluations.simulated(scenario, evaluations.seed ^ _OTHER_SEED)
    values, chances = targets.pick(rows.moments(count))
    slopes = evaluations.slopes(x, count, targets.pick, central=True)
    variance = np.einsum("mp,pq,mq->m", slopes, covariance, slopes)
    predicted = np.sqrt(np.maximum(variance, 0.0) + chances**2)
    stated = part.measurements.speed
    return [
        FittedNumber(
            row=part.rows[target.row],
            alpha_deg=float(part.measurements.alpha_deg[target.row]),
            speed=float(stated[target.row]) if np.isfinite(stated[target.row]) else None,
            column=target.column,
            measured=target.measured,
            accuracy=float(target.accuracy),
            allowed=float(target.allowed),
            bound=target.bound,
            simulated=float(values[k]),
            chance=float(chances[k]),
            predicted=float(predicted[k]),
            held_out=held_out,
        )
        for k, target in enumerate(targets)
    ]
