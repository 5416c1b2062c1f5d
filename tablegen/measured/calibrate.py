"""Fit a material pair to measured rebounds."""

import hashlib
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from sampler.arguments import as_integer
from sampler.errors import InputError
from sampler.files import check_output, find_measurements, write_text
from tablegen.checkpoints import CheckpointStore, software
from tablegen.config.config import Config, parse_config
from tablegen.config.defaults import CALIBRATE_COUNT
from tablegen.measured.ends import (
    Rows,
    errors_of_fit,
    errors_of_numbers,
    numbers_beside,
    particles_of_end,
    settled,
)
from tablegen.measured.evaluations import Evaluations
from tablegen.measured.impact_speeds import impact_speeds
from tablegen.measured.pair_file import (
    Provenance,
    comment_text,
    fitted_config,
)
from tablegen.measured.parameters import default_names, make_parameters
from tablegen.measured.reader import read_measurements
from tablegen.measured.records import Measurements
from tablegen.measured.result import Calibration
from tablegen.measured.rows import check_spreads, chosen_rows, split_rows
from tablegen.measured.search import STAGES, Search, Stage, most_particles
from tablegen.measured.simulated_moments import SimulatedRows
from tablegen.measured.targets import make_targets
from tablegen.measured.trial_pairs import TrialPairs
from tablegen.measured.uncertainty import correlations
from tablegen.model.float_array import FloatArray
from tablegen.progress import bar
from tablegen.simulation.simulate import check_run

#: Fewest particles of each shape at each condition in the last stage of a search.
_FEWEST = 200


@dataclass(frozen=True)
class _Task:
    """What is asked for, checked."""

    measurements: Measurements
    checksum: str
    start: Config
    free: tuple[str, ...]
    used: list[int]
    held: list[int]
    speeds: FloatArray
    speed: float | None
    wall_tilt_deg: float
    count: int
    seed: int
    threads: int | None

    @property
    def fingerprint(self) -> str:
        """Everything that decides the result."""
        m = self.measurements
        data = [m.alpha_deg, self.speeds, m.count]
        data += [part for one in m.moments.values() for part in (one.mean, one.std)]
        numbers = hashlib.sha256(b"".join(a.astype("<f8").tobytes() for a in data)).hexdigest()
        rest = (self.free, self.held, self.wall_tilt_deg, self.count, self.seed)
        return f"{software()}\n{self.start.text}\n{numbers}\n{rest}"


def calibrate(
    measured: Measurements | str | Path,
    start: Config,
    output: str | Path | None = None,
    *,
    free: Sequence[str] | None = None,
    hold_out: Sequence[float] = (),
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

    Means and, where measured, spreads are weighted by their accuracies, which follow from measured
    spread and count of particles. Where no count is stated all rows weigh the same, e_n and e_t as
    if accurate to 0.02 and their spreads to 0.05 (`tablegen.measured.targets`), and the errors
    of the fit follow from its residuals.

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
        Paths of the fields that are free (`tablegen.measured.parameters.allowed_names`); by
        default the coefficients of both laws and the mean aspect ratio.
    hold_out : sequence of float
        Angles [degrees] whose rows are predicted and not used.
    count : int
        Particles of each shape at each condition, 200 or more.
    seed : int
        0 to 2**64 - 1, of the particles and of the random starts.
    speed : float, optional
        Impact speed [m/s] of rows that state none; needed if the law depends on it.
    wall_tilt_deg : float
        Roughness of the wall, degrees: fixed, or where the search starts if it is free.
    resume, discard : bool
        Use, or remove, the simulations of an interrupted run. With neither, they are refused.
    threads : int, optional
        Default: one a processor. The result does not depend on it.
    progress : bool
        Show a progress bar on standard error.

    Returns
    -------
    Calibration

    Raises
    ------
    InputError
        If measurements, pair and free parameters do not go together, or the output cannot be
        written; one line with what was given and what is allowed.
    """
    as_integer("count", count, _FEWEST, 2**31, f"{_FEWEST} or more")
    check_run(count, seed, 0, threads)
    task = _task(measured, start, free, hold_out, count, seed, speed, wall_tilt_deg, threads)
    path = check_output(output) if output is not None else None
    trials = TrialPairs(start, make_parameters(start, task.free, wall_tilt_deg), wall_tilt_deg)
    with ExitStack() as stack:
        store = None
        if path is not None:
            store = CheckpointStore(path, task.fingerprint, resume=resume, discard=discard)
            stack.enter_context(store)
        stack.enter_context(threadpool_limits(limits=1, user_api="blas"))
        made = _fitted(task, trials, store, path, progress)
        if path is not None and store is not None:
            write_text(path, made.config.text)
            store.remove()
    return made


def _task(
    measured: Measurements | str | Path,
    start: Config,
    free: Sequence[str] | None,
    hold_out: Sequence[float],
    count: int,
    seed: int,
    speed: float | None,
    wall_tilt_deg: float,
    threads: int | None,
) -> _Task:
    """Check what belongs together."""
    checksum = ""
    if not isinstance(measured, Measurements):
        checksum = hashlib.sha256(find_measurements(measured).read_bytes()).hexdigest()
        measured = read_measurements(measured)
    names = tuple(default_names(start) if free is None else free)
    used, held = split_rows(measured, hold_out)
    check_spreads(measured, start, names, wall_tilt_deg)
    speeds = impact_speeds(start.pair, measured, speed)
    return _Task(
        measured,
        checksum,
        start,
        names,
        used,
        held,
        speeds,
        speed if not np.isfinite(measured.speed).all() else None,
        wall_tilt_deg,
        count,
        seed,
        threads,
    )


def _fitted(
    task: _Task,
    trials: TrialPairs,
    store: CheckpointStore | None,
    path: Path | None,
    progress: bool,
) -> Calibration:
    """Search, and work out what is known of the end."""
    totals = [most_particles(stage, trials, task.count) for stage in STAGES]
    # slopes are taken of rows that are held out as well
    totals.append((1 + bool(task.held)) * particles_of_end(trials, task.count))
    with bar(progress, "particle", total=sum(totals), unit_scale=True) as counted:
        rows, held = (
            _rows(task, trials, at, store, counted.update) for at in (task.used, task.held)
        )
        _check_enough(rows, trials)
        search = Search(rows.evaluations, rows.targets, task.count)
        x = search.run(task.seed, _stage_by_stage(counted, totals))
        counted.set_description_str("errors", refresh=False)
        x, slopes = settled(rows, search, x, task.count)
        found = errors_of_fit(rows, search, x, slopes, task.count)
        name = "fitted" if path is None else _pair_name(path)
        config = fitted_config(task.start, trials.changes(x), name, task.measurements, task.used)
        numbers = [
            one
            for part, held_out in ((rows, False), (held, True))
            for one in numbers_beside(part, config, x, found.covariance, task.count, held_out)
        ]
    errors, covariance = errors_of_numbers(trials, x, found)
    made = Calibration(
        config=config,
        labels=trials.labels,
        given=trials.numbers(trials.start),
        values=trials.numbers(x),
        errors=errors,
        correlation=correlations(covariance),
        numbers=tuple(numbers),
        scatter=found.scatter,
        freedom=found.freedom,
        warnings=found.warnings,
        wall_tilt_deg=trials.wall_tilt_deg(x),
    )
    return _with_comments(made, task)


def _rows(
    task: _Task,
    trials: TrialPairs,
    at: list[int],
    store: CheckpointStore | None,
    on_simulated: Callable[[int], Any],
) -> Rows:
    """Take some rows, with their simulations."""
    part = chosen_rows(task.measurements, at)
    speed = task.speeds[at]
    evaluations = Evaluations(
        trials, part.alpha_deg, speed, task.seed, task.threads, store, on_simulated
    )
    if not at:
        return Rows(part, at, evaluations, make_targets(part, None))
    first = SimulatedRows(
        task.start.pair,
        task.start.population,
        part.alpha_deg,
        speed,
        seed=task.seed,
        numerics=task.start.model,
        wall_tilt_deg=task.wall_tilt_deg,
        threads=task.threads,
    ).moments(_FEWEST)
    return Rows(part, at, evaluations, make_targets(part, first))


def _check_enough(rows: Rows, trials: TrialPairs) -> None:
    """Refuse fewer measured numbers than free ones."""
    m, p = len(rows.targets.measured), len(trials.start)
    if m < p:
        raise InputError(
            f"free: got {p} free numbers for {m} measured means and spreads in "
            f"{len(rows.at)} rows, allowed: up to {m}"
        )


def _stage_by_stage(counted: Any, totals: Sequence[int]) -> Callable[[Stage], None]:
    """Tell a progress bar what a stage that begins will take, and those after it, at most."""

    def begin(stage: Stage) -> None:
        counted.total = counted.n + sum(totals[STAGES.index(stage) :])
        counted.set_description_str(stage.name, refresh=False)

    return begin


def _pair_name(path: Path) -> str:
    """Name of a pair after its file, with the characters that names have."""
    plain = "".join(c if c.isascii() and (c.isalnum() or c in "._-") else "-" for c in path.stem)
    return plain.lstrip("._-")[:100] or "fitted"


def _with_comments(made: Calibration, task: _Task) -> Calibration:
    """Calibration whose pair has a text that says how it was made."""
    provenance = Provenance(
        task.measurements,
        task.checksum,
        task.start.name,
        task.free,
        task.count,
        task.seed,
        task.speed,
    )
    comments = comment_text(made, provenance)
    config = parse_config(f"{comments}\n{made.config.text}", made.config.name)
    return replace(made, config=config)
