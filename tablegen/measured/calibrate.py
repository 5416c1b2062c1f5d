"""Calibration: the smoothest contact laws that give the measured means, for given grains."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from sampler.errors import InputError
from sampler.files import check_output, write_text
from tablegen.config.config import Config, load_population
from tablegen.config.grains import GRAINS
from tablegen.measured.fits import Fitter, Target, make_targets
from tablegen.measured.free_numbers import chosen_names
from tablegen.measured.measurements import Measurements
from tablegen.measured.pair_file import starting_config, with_angles, with_comments
from tablegen.measured.reader import read_measurements
from tablegen.measured.result import Calibration, Fit
from tablegen.measured.smoothest import HOPELESS
from tablegen.progress import bar
from tablegen.simulation.simulate import check_run

#: Most rows of a fit, whose time grows with them; and most that a line names.
_MOST_ROWS, _NAMED = 400, 6

#: Pairs of quantities that decide restitution and resistance together.
_BOTH_LAWS = [
    {"e_n", "e_t"},
    {"e_n", "omega_z"},
    {"e_n", "rebound_angle_deg"},
    {"rebound_angle_deg", "e_t"},
    {"rebound_angle_deg", "omega_z"},
]


def calibrate(
    measured: Measurements | str | Path,
    output: str | Path | None = None,
    *,
    grains: str | Path | None = None,
    start: Config | None = None,
    free: Sequence[str] = (),
    seed: int = 1,
    speed: float | None = None,
    threads: int | None = None,
    progress: bool = False,
) -> Calibration:
    """Find the smoothest contact laws that give measured means.

    The grains are not fitted. For each of five named populations, or for the grains that are given,
    the restitution and the resistance are tables over the angle at the contact. The population
    with the least misfit is chosen, which weighs means and spreads together (`Fit.misfit`). Spreads
    have no effect on the laws.

    Parameters
    ----------
    measured : Measurements, str or Path
        Measured rebounds from `tablegen.read_measurements`, or the name or path of a file. A fit
        takes at most 400 rows.
    output : str or Path, optional
        File to which the chosen pair is written.
    grains : str or Path, optional
        Grains to use: one of the named populations, a file with a population, or the name of a pair
        that comes with the package.
    start : Config, optional
        Pair whose form of the laws is kept, while their numbers are fitted. It also gives the
        grains, unless `grains` does.
    free : sequence of str, optional
        Fields of `start` to fit (`tablegen.measured.free_numbers`). By default all fields that have
        an effect are fitted; ``+NAME`` adds a field to these.
    seed : int, optional
        Seed of the simulation, 0 to 2**64 - 1.
    speed : float, optional
        Impact speed of rows that state none [m/s]. It is needed if the law of `start` depends on
        the speed.
    threads : int, optional
        Number of threads, which does not change the result. By default one for each processor.
    progress : bool, optional
        Whether to show a progress bar on standard error.

    Returns
    -------
    Calibration
        All fits, and the one that was chosen. `Calibration.missed` says whether means are missed.

    Raises
    ------
    InputError
        If the measurements cannot be used, if measurements, pair, grains and free fields do not go
        together, or if the output cannot be written.

    Notes
    -----
    docs/calibration.md explains the tolerances of the means and the choice of the grains.

    Examples
    --------
    A calibration takes a minute, so this example is not run by the tests:

    >>> from tablegen import calibrate
    >>> fit = calibrate("grant-tabakoff-1975", "my-sand.toml")  # doctest: +SKIP
    >>> fit.chosen.grains, fit.missed  # doctest: +SKIP
    ('rounded', False)
    """
    check_run(1, seed, 0, threads)
    data = measured if isinstance(measured, Measurements) else read_measurements(measured)
    if len(data.alpha_deg) > _MOST_ROWS:
        raise InputError(
            "",
            f"{len(data.alpha_deg)} rows to fit",
            f"up to {_MOST_ROWS}",
            remedy="average over ranges of angle and speed",
            source=data.name,
        )
    targets = make_targets(data)
    _check_rows(data, targets, start, speed)
    if free and start is None:
        remedy = "give the pair that has these fields, --pair START.toml"
        raise InputError("free", problem="is given without a pair", remedy=remedy)
    path = check_output(output) if output is not None else None
    name = _pair_name(path) if path else "fitted"
    starts = _make_starts(data, grains, start)
    with (
        threadpool_limits(limits=1, user_api="blas"),
        bar(progress, "population", total=len(starts)) as counted,
    ):
        fitter, fits = Fitter(data, targets, speed, seed, threads), list[Fit]()
        several = len(starts) > 1
        for label, config in starts.items():
            counted.set_description_str(label)
            fits.append(fitter.fit(label, config, chosen_names(config, free), name, several))
            counted.update(1)
        chosen = _choose_fit(fits)
        if not chosen.holds:
            config = starts[chosen.grains]
            if several and chosen.means[0].miss > HOPELESS:
                # its search was perhaps given up, and the advice names the rows that it misses
                chosen = fitter.fit(chosen.grains, config, chosen_names(config, free), name)
            if start is None:
                chosen = _fit_with_more_knots(fitter, chosen, config, name)
            fits = [chosen if fit.grains == chosen.grains else fit for fit in fits]
    calibration = Calibration(tuple(fits), chosen, _advice(data, chosen))
    config = with_comments(calibration, data, seed)
    calibration = replace(calibration, chosen=replace(chosen, config=config))
    if path is not None:
        write_text(path, calibration.config.text)
    return calibration


def _check_rows(
    data: Measurements, targets: Sequence[Target], start: Config | None, speed: float | None
) -> None:
    """Refuse means that cannot determine both laws, and rows of which some state a speed."""
    followed = {target.quantity for target in targets}
    if start is None and not any(pair <= followed for pair in _BOTH_LAWS):
        problem = f"{' and '.join(sorted(followed))} alone cannot determine both laws"
        remedy = (
            "give e_n or rebound_angle_deg, and a second quantity, or fit one law with --pair "
            "START.toml and --free"
        )
        raise InputError("", problem=problem, remedy=remedy, source=data.name)
    unstated = np.isnan(data.speed)
    if speed is None and unstated.any() and not unstated.all():
        angles = ", ".join(f"{a:g}" for a in np.unique(data.alpha_deg[unstated])[:_NAMED])
        raise InputError(
            "speed",
            problem=f"is missing in {unstated.sum()} of {unstated.size} rows, at {angles} degrees",
            remedy="give a speed in all rows or in none, or --speed for these rows",
            source=data.name,
        )


def _pair_name(path: Path) -> str:
    """Name a pair after its file, with the characters that names have."""
    plain = "".join(c if c.isascii() and (c.isalnum() or c in "._-") else "-" for c in path.stem)
    return plain.lstrip("._-")[:100] or "fitted"


def _make_starts(
    data: Measurements, grains: str | Path | None, start: Config | None
) -> dict[str, Config]:
    """Make the configurations to start from, by the names of their grains."""
    if start is not None and grains is None:
        return {start.name: start}
    names = GRAINS if grains is None else (str(grains),)
    populations = {name: load_population(name) for name in names}
    if start is not None:
        return {n: start.with_changes({"population": p}) for n, p in populations.items()}
    return {name: starting_config(data, tree) for name, tree in populations.items()}


def _choose_fit(fits: Sequence[Fit]) -> Fit:
    """Choose the fit with the least misfit; of equal ones the most angular, which comes first.

    Spheres follow means most easily, so smooth laws would always ask for round grains.
    """
    return min(fits, key=lambda fit: fit.misfit)


def _fit_with_more_knots(fitter: Fitter, fit: Fit, start: Config, name: str) -> Fit:
    """Fit again with knots of the laws at the angles of missed rows too; return the better fit.

    A law that bends between its knots cannot be followed there.
    """
    angles = {one.alpha_deg for one in fit.means if one.miss > 1.0}
    config = with_angles(start, angles)
    if config is start:
        return fit
    again = fitter.fit(fit.grains, config, chosen_names(config, ()), name)
    return again if again.means[0].miss < fit.means[0].miss else fit


def _advice(data: Measurements, chosen: Fit) -> str:
    """Say what looks wrong in the measurements, and which rows no grains give; "" if nothing."""
    missed = sorted((one for one in chosen.means if one.miss > 1.0), key=lambda one: one.row)
    places = list(dict.fromkeys(one.place for one in missed))
    rows = ", ".join(places[:_NAMED]) + f" and {len(places) - _NAMED} more" * (len(places) > _NAMED)
    parts = [f"{chosen.grains} grains come nearest, but miss {rows}"] if missed else []
    if data.doubt:
        parts.append(data.doubt)
    elif missed and np.isnan(data.speed).all() and len(set(data.alpha_deg)) < data.alpha_deg.size:
        parts.append("state the speeds of the rows, so that the laws may depend on the speed")
    elif missed:
        parts.append("check these rows, or leave them out")
    return "; ".join(parts)
