"""Error of the direct model against its cost: contact resolution and flight tolerance.

Every setting follows the same particles as a much finer one, so the differences hold no sampling
noise but that of the few particles whose course a setting changes. Error is the largest change of
a statistic: mean, standard deviation and the 1, 10, 50, 90 and 99 per cent quantiles of each
variable of the state (in V and V/a), and each correlation. Next to it stands the standard error
of the largest change of a mean. Cost is processor time on one thread.
"""

import math
import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tablegen.config.config import Config
from tablegen.model.float_array import FloatArray
from tablegen.simulation.simulate import CONTACT_RESOLUTION, TOLERANCE, simulate

#: Settings compared: one of the two is varied, the other has its default.
RESOLUTIONS = (1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4)
TOLERANCES = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12)

#: The setting that stands for the truth.
FINEST = (1e-6, 1e-13)

QUANTILES = (0.01, 0.1, 0.5, 0.9, 0.99)

RESOLUTION, TOLERANCE_VARIED = "resolution", "tolerance"


@dataclass(frozen=True)
class Setting:
    """One point of the curve."""

    shape: str
    alpha_deg: float
    speed: float
    varied: str
    resolution: float
    tolerance: float
    nanoseconds: float
    error: float
    statistic: str
    noise: float

    @property
    def is_default(self) -> bool:
        """Whether both settings are the defaults."""
        return (self.resolution, self.tolerance) == (CONTACT_RESOLUTION, TOLERANCE)


def summary_statistics(state: FloatArray) -> dict[str, FloatArray]:
    """Every statistic of (n, 6) states whose error is measured."""
    quantiles = np.quantile(state, QUANTILES, axis=0)
    upper = np.triu_indices(6, 1)
    return {
        "mean": state.mean(axis=0),
        "deviation": state.std(axis=0),
        "correlation": np.asarray(np.corrcoef(state.T))[upper],
        **{f"quantile {q:g}": row for q, row in zip(QUANTILES, quantiles, strict=True)},
    }


def largest_change(one: dict[str, FloatArray], other: dict[str, FloatArray]) -> tuple[float, str]:
    """Largest difference of two sets of statistics, and of which it is."""
    changes = {name: float(np.abs(one[name] - other[name]).max()) for name in one}
    name = max(changes, key=changes.__getitem__)
    return changes[name], name


def settings() -> Iterator[tuple[str, float, float]]:
    """Yield what is varied, resolution and tolerance of every point."""
    for resolution in RESOLUTIONS:
        yield RESOLUTION, resolution, TOLERANCE
    for tolerance in TOLERANCES:
        yield TOLERANCE_VARIED, CONTACT_RESOLUTION, tolerance


def curve(
    config: Config, shape: str, alpha_deg: float, speed: float, count: int, seed: int
) -> Iterator[Setting]:
    """Error and cost of every setting at one condition.

    Parameters
    ----------
    config : Config
    shape : str
        A shape, or "mixture".
    alpha_deg, speed : float
        Impact angle [degrees] and speed [m/s].
    count : int
        Particles that every setting follows.
    seed : int

    Yields
    ------
    Setting
    """
    alpha1, particles = math.radians(alpha_deg), config.population.restricted_to(shape)

    def run(resolution: float, tolerance: float) -> tuple[FloatArray, float]:
        numerics = {"contact_resolution": resolution, "tolerance": tolerance}
        changed = config.with_changes({"model": numerics})
        start = time.process_time()
        made = simulate(changed, alpha1, speed, count, seed=seed, threads=1, population=particles)
        return made.state, 1e9 * (time.process_time() - start) / count

    true_state, _ = run(*FINEST)
    truth = summary_statistics(true_state)
    for varied, resolution, tolerance in settings():
        state, nanoseconds = run(resolution, tolerance)
        error, statistic = largest_change(summary_statistics(state), truth)
        yield Setting(
            shape=shape,
            alpha_deg=alpha_deg,
            speed=speed,
            varied=varied,
            resolution=resolution,
            tolerance=tolerance,
            nanoseconds=nanoseconds,
            error=error,
            statistic=statistic,
            noise=float(np.std(state - true_state, axis=0).max() / math.sqrt(count)),
        )
