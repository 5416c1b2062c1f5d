"""Cases of the stability study: particles, impacts and spins up to the extremes.

Each case is simulated three times with the same particles: as usual, with half the contact
resolution, and with half the tolerance of the flight.
"""

import math
from dataclasses import dataclass
from itertools import product
from typing import Any, ClassVar

import numpy as np

from sampler.formats.shape_codes import SHAPE_NAMES
from tablegen.config.config import Config
from tablegen.evidence.checked import Checked
from tablegen.simulation.simulate import Simulation, make_condition, simulate_condition

#: b/a and c/b, impact angles [degrees], speeds [m/s], and spins before the impact [V/a]. The quick
#: study has ends and middles without the spins of 50 V/a, the most expensive cases.
_RATIOS = (1.0, 0.999, 0.5, 0.05, 0.02)
_FULL = (
    (0.01, 0.5, 1.0, 20.0, 45.0, 70.0, 89.99, 90.0),
    (1.0, 10.0, 50.0, 300.0, 3000.0),
    (0.0, 1.0, -1.0, 5.0, -5.0, 50.0, -50.0),
)
_QUICK = ((0.01, 1.0, 45.0, 90.0), (1.0, 50.0, 300.0, 3000.0), (0.0, 1.0, -1.0, 5.0))


@dataclass(frozen=True)
class Case:
    """One particle form at one impact condition; the spin is along the wall axis z."""

    shape: str
    #: b/a and c/b.
    aspect: tuple[float, float]
    #: Impact angle [degrees], speed [m/s], and spin before the impact [V/a].
    alpha_deg: float
    speed: float
    spin: float

    def __str__(self) -> str:
        ba, cb = self.aspect
        return (
            f"{self.shape} with b/a {ba:g} and c/b {cb:g}, {self.alpha_deg:g} degrees, "
            f"{self.speed:g} m/s, spin {self.spin:g} V/a"
        )


def all_cases(quick: bool = False) -> list[Case]:
    """List the cases in a fixed order; a sphere has the ratios 1 and 1 only."""
    ratios, axes = (_RATIOS[::2], _QUICK) if quick else (_RATIOS, _FULL)
    return [
        Case(shape, *values)
        for shape in SHAPE_NAMES
        for values in product(
            ((1.0, 1.0),) if shape == "sphere" else tuple(product(ratios, ratios)), *axes
        )
    ]


@dataclass(frozen=True, kw_only=True)
class CaseOutcome(Checked):
    """Outcome of a case; quantities are those of the run with the usual parameters."""

    case: Case
    #: Largest share of the energy before that neither a particle keeps nor the impulses take.
    unaccounted: float | None
    most_collisions: int | None
    #: Mean change of a particle's most changed variable [V or V/a], by half the contact
    #: resolution and by half the flight tolerance; None if that run did not finish.
    contact: float | None
    flight: float | None

    MOST_GROWTH: ClassVar[float] = 1e-12

    def __str__(self) -> str:
        return str(self.case)

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers and names, for JSON."""
        data = super().to_dict()
        return {**data.pop("case"), **data}


def run_case(config: Config, case: Case, count: int, seed: int) -> CaseOutcome:
    """Simulate and check one case with some particles."""
    usual = _simulated(config, case, count, seed)
    contact = _mean_change(usual, _simulated(config, case, count, seed, contact=0.5))
    flight = _mean_change(usual, _simulated(config, case, count, seed, flight=0.5))
    return CaseOutcome(
        case=case,
        seed=seed,
        rebounds=count,
        # at least one rebound of each run that did not end
        unfinished=sum(one is None for one in (usual, contact, flight)),
        contact=contact,
        flight=flight,
        **_quantities(usual),
    )


def _quantities(usual: Simulation | None) -> dict[str, Any]:
    """Measure the quantities of a run; None if it did not finish."""
    if usual is None:
        return dict.fromkeys(("growth", "least_velocity", "unaccounted", "most_collisions"))
    kept = usual.energy.sum(axis=1)
    return {
        "growth": float(kept.max()) - 1.0,
        "least_velocity": float(usual.state[:, 1].min()),
        "unaccounted": float(np.abs(1.0 - kept - usual.work.sum(axis=1)).max()),
        "most_collisions": int(usual.collisions.max()),
    }


def _simulated(
    config: Config, case: Case, count: int, seed: int, contact: float = 1.0, flight: float = 1.0
) -> Simulation | None:
    """Simulate a case with scaled numerical parameters; None if a particle does not finish."""
    numerics = contact * config.model.contact_resolution, flight * config.model.tolerance
    spin = 0.0, 0.0, case.spin
    condition = make_condition(math.radians(case.alpha_deg), case.speed, spin, *numerics)
    # prisms are truncated as in the configuration
    population = config.population.restricted_to(case.shape).with_aspect(*case.aspect)
    try:
        return simulate_condition(config.pair, population, condition, count, seed=seed, threads=1)
    except RuntimeError:
        return None


def _mean_change(usual: Simulation | None, halved: Simulation | None) -> float | None:
    if usual is None or halved is None:
        return None
    return float(np.abs(halved.state - usual.state).max(axis=1).mean())
