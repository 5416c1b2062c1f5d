"""Rows of measurements that a calibration uses, and those it holds out."""

from collections.abc import Sequence

import numpy as np

from sampler.errors import InputError
from tablegen.config.config import Config
from tablegen.measured.parameters import SHAPES, WALL_TILT
from tablegen.measured.records import SPREAD, Measurements, Moments

#: Angles [degrees] that differ by less count as the same.
_SAME_ANGLE = 1e-6


def chosen_rows(measurements: Measurements, rows: Sequence[int]) -> Measurements:
    """Measurements with some of their rows only."""
    at = np.asarray(rows, dtype=np.int64)
    return Measurements(
        name=measurements.name,
        alpha_deg=measurements.alpha_deg[at],
        speed=measurements.speed[at],
        moments={n: Moments(m.mean[at], m.std[at]) for n, m in measurements.moments.items()},
        count=measurements.count[at],
        source=tuple(measurements.source[k] for k in at),
        remarks=tuple(measurements.remarks[k] for k in at),
        about=measurements.about,
    )


def split_rows(
    measurements: Measurements, hold_out: Sequence[float]
) -> tuple[list[int], list[int]]:
    """Rows that a fit uses, and those at held-out angles [degrees].

    Raises
    ------
    InputError
        If an angle is none of the measured ones, or no row is left.
    """
    angles = measurements.alpha_deg
    for angle in hold_out:
        if not np.any(np.abs(angles - angle) < _SAME_ANGLE):
            there = ", ".join(f"{a:g}" for a in np.unique(angles))
            raise InputError(f"hold_out: got {angle:g} degrees, allowed: {there}")
    held = [
        k for k, a in enumerate(angles) if any(abs(a - angle) < _SAME_ANGLE for angle in hold_out)
    ]
    used = [k for k in range(len(angles)) if k not in held]
    if not used:
        raise InputError(f"hold_out: got all {len(held)} rows, allowed: fewer, so that some remain")
    return used, held


def check_spreads(
    measurements: Measurements, config: Config, free: Sequence[str], wall_tilt_deg: float
) -> None:
    """Refuse measured spreads of a pair all of whose rebounds are equal.

    Raises
    ------
    InputError
        If there are spheres only, on a smooth wall, and nothing that would change that is free.
    """
    population = config.population
    spheres = set(population.shapes.positive()) == {"sphere"} and not population.meshes
    varied = wall_tilt_deg > 0.0 or any(n == WALL_TILT or n.startswith(SHAPES) for n in free)
    spread = [n for n, m in measurements.moments.items() if np.isfinite(m.std).any()]
    if spheres and not varied and spread:
        raise InputError(
            f"{spread[0]}{SPREAD}: got spreads, which spheres on a smooth wall do not have, "
            f"allowed: other shapes, or {WALL_TILT} among the free parameters"
        )
