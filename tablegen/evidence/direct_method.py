"""Direct simulation as a method of sampling: by contact resolution and flight tolerance."""

from functools import partial
from typing import Any

import numpy as np

from tablegen.evidence.sampling_methods import (
    DOMAIN,
    BenchmarkCase,
    FittedMethod,
    SamplingMethod,
)
from tablegen.model.float_array import FloatArray
from tablegen.simulation.simulate import simulate

FAMILY = "direct simulation"

#: Settings that are compared; the other one keeps what the configuration says.
RESOLUTIONS = (1e-1, 1e-2, 1e-4)
TOLERANCES = (1e-4, 1e-6)


def simulated(case: BenchmarkCase, **numerics: float) -> FittedMethod:
    """Direct simulation of a case, with other numerics than the configuration's if given.

    Parameters
    ----------
    case : BenchmarkCase
    **numerics
        Fields of `tablegen.config.config.ModelSettings`.
    """
    config = case.config.with_changes({"model": numerics}) if numerics else case.config
    alpha1 = np.radians(case.alpha_deg)

    def draw(count: int, seed: int) -> FloatArray:
        return simulate(config, alpha1, case.speed, count, seed=seed, threads=1).state

    return FittedMethod(draw, 0)


def direct_methods() -> list[SamplingMethod]:
    """Direct simulation as configured, then by resolution, then by tolerance."""
    varied: list[tuple[str, dict[str, Any]]]
    varied = [("contact resolution", {"contact_resolution": x}) for x in RESOLUTIONS]
    varied += [("flight tolerance", {"tolerance": x}) for x in TOLERANCES]
    methods = [SamplingMethod(FAMILY, "as configured", DOMAIN, simulated)]
    for words, numerics in varied:
        (value,) = numerics.values()
        prepare = partial(simulated, **numerics)
        methods.append(SamplingMethod(FAMILY, f"{words} {value:g}", DOMAIN, prepare, numerics))
    return methods
