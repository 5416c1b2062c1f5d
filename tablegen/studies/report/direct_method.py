"""Direct simulation as a way to get rebound states: by contact resolution and flight tolerance."""

from functools import partial

import numpy as np

from tablegen.accuracy.samples import FloatArray
from tablegen.config import Config
from tablegen.simulate import make_condition, simulate_condition
from tablegen.studies.report.sampling_methods import DOMAIN, Prepared, Scene, Way

FAMILY = "direct simulation"

#: Settings that are compared; the other one keeps what the configuration says.
RESOLUTIONS = (1e-1, 1e-2, 1e-4)
TOLERANCES = (1e-4, 1e-6)


def direct_states(
    config: Config,
    alpha_deg: float,
    speed: float,
    count: int,
    seed: int,
    *,
    resolution: float | None = None,
    tolerance: float | None = None,
    threads: int | None = None,
) -> FloatArray:
    """Simulate states at a condition, with the numerics of the configuration unless given.

    Parameters
    ----------
    config : Config
    alpha_deg, speed : float
        Impact angle [degrees] and speed [m/s].
    count, seed : int
    resolution, tolerance : float, optional
        Contact resolution and flight tolerance.
    threads : int, optional
        Default: one a processor.

    Returns
    -------
    float64 array, shape (count, 6)
    """
    model = config.model
    condition = make_condition(
        np.radians(alpha_deg),
        speed,
        resolution=resolution or model.contact_resolution,
        tolerance=tolerance or model.tolerance,
    )
    made = simulate_condition(
        config.pair, config.population, condition, count, seed=seed, threads=threads
    )
    return made.state


def _prepare(scene: Scene, resolution: float | None, tolerance: float | None) -> Prepared:
    def draw(count: int, seed: int) -> FloatArray:
        return direct_states(
            scene.config,
            scene.alpha_deg,
            scene.speed,
            count,
            seed,
            resolution=resolution,
            tolerance=tolerance,
            threads=1,
        )

    return Prepared(draw, 0)


def direct_ways() -> list[Way]:
    """Direct simulation as configured, then by resolution, then by tolerance."""
    default = Way(
        FAMILY, "as configured", DOMAIN, partial(_prepare, resolution=None, tolerance=None)
    )
    by_resolution = [
        Way(
            FAMILY,
            f"contact resolution {x:g}",
            DOMAIN,
            partial(_prepare, resolution=x, tolerance=None),
            {"contact_resolution": x},
        )
        for x in RESOLUTIONS
    ]
    by_tolerance = [
        Way(
            FAMILY,
            f"flight tolerance {x:g}",
            DOMAIN,
            partial(_prepare, resolution=None, tolerance=x),
            {"tolerance": x},
        )
        for x in TOLERANCES
    ]
    return [default, *by_resolution, *by_tolerance]
