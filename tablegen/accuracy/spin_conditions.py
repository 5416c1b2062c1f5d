"""Where a spin law is measured one condition at a time: even over angle, speed and spin."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.stats import qmc

from sampler.arguments import told_apart
from sampler.errors import InputError
from sampler.formats.hdf5 import TableContents
from tablegen.config.config import Config
from tablegen.config.defaults import GENERATE_SPIN_CONDITIONS
from tablegen.simulation.impact_chains import energy_factor, speeds_measured

#: Angles [degrees] that are of interest, and the largest spin before the impact, times V/a.
ANGLES_DEG = (5.0, 85.0)
MOST_SPIN = 2.0

#: Spinning conditions for each of the others, up to `GENERATE_SPIN_CONDITIONS`.
_FOR_EACH = 3

#: Purpose of the random numbers, next to the seed.
_KEY = 2**31 + 2


class SpinCondition(NamedTuple):
    """An impact of a particle that spins."""

    #: Impact angle [degrees] and speed [m/s].
    alpha_deg: float
    speed: float
    #: Angular velocity before the impact times a/V, wall axes.
    spin: tuple[float, float, float]


def pick_spin_conditions(config: Config, count: int, seed: int) -> list[SpinCondition]:
    """Choose conditions of spinning particles, evenly spread.

    A Latin hypercube over the angle from 5 to 85 degrees, the speed where the law of restitution
    was measured, the size of the spin up to 2 V/a, and its direction, uniform on the sphere.

    Parameters
    ----------
    config : Config
        Of the table, whose domain limits angles and speeds further.
    count : int
    seed : int

    Returns
    -------
    list of SpinCondition
        By increasing angle.
    """
    if count == 0:
        return []
    rng = np.random.default_rng([seed, _KEY])
    points = qmc.LatinHypercube(5, seed=rng).random(count)
    points = points[np.argsort(points[:, 0])]
    low, high = (float(np.clip(end, *config.domain.alpha_deg)) for end in ANGLES_DEG)
    slow, fast = speeds_measured(config)
    size, y, turn = MOST_SPIN * points[:, 2], 2.0 * points[:, 3] - 1.0, 2.0 * np.pi * points[:, 4]
    radius = np.sqrt(1.0 - y * y)
    spins = size[:, None] * np.column_stack([radius * np.cos(turn), y, radius * np.sin(turn)])
    return [
        SpinCondition(low + (high - low) * a, slow + (fast - slow) * v, (x, y, z))
        for a, v, (x, y, z) in zip(*points[:, :2].T.tolist(), spins.tolist(), strict=True)
    ]


def spin_conditions_beside(conditions: int) -> int:
    """Count the spinning conditions at which a new table is measured, beside so many others."""
    return min(GENERATE_SPIN_CONDITIONS, _FOR_EACH * conditions)


def check_spin_conditions(
    contents: TableContents, conditions: Sequence[SpinCondition]
) -> list[SpinCondition]:
    """Refuse spinning conditions that a table does not cover.

    Parameters
    ----------
    contents : TableContents
        With a spin law.
    conditions : sequence of SpinCondition

    Raises
    ------
    InputError
        If an angle or an effective speed V_e is outside of the law's range, or no number.
    """
    for place in conditions:
        spin = np.asarray(place.spin, dtype=np.float64)
        if spin.shape != (3,) or not np.isfinite(spin).all():
            raise InputError(f"spin: got {place.spin}, allowed: three finite numbers")
        effective = place.speed * float(energy_factor(spin[None])[0])
        for name, value, path, unit in (
            ("alpha", place.alpha_deg, "spin/alpha_range_deg", "degrees"),
            ("speed with the spin's energy", effective, "spin/speed_range", "m/s"),
        ):
            low, high = contents[path].tolist()
            if not low <= value <= high:
                raise InputError(
                    f"{name}: got {told_apart(value, low, high, digits=6)} {unit}, "
                    f"allowed: {low:g} to {high:g} {unit}, which the spin law covers"
                )
    return list(conditions)
