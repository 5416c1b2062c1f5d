"""Outcome of one case of the stability study, and what counts as a failure of the model."""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tablegen.evidence.cases import Case
from tablegen.model.audit import (
    ANGULAR,
    ENERGY,
    FLIGHT_ENERGY,
    FLIGHT_MOMENTUM,
    NORMAL,
    PENETRATION,
    TANGENTIAL,
)
from tablegen.simulation.simulate import Simulation

#: Energy that rounding may add, in units of V^2 per unit mass and of the energy before.
MOST_GROWTH = 1e-12

#: Depth below the wall, in a, to which a contact may be overshot: the height within which vertices
#: count as touching together. The flight's tolerance leaves some 1e-11.
MOST_DEPTH = 1e-9


@dataclass(frozen=True)
class Change:
    """Effect of a halved tolerance on the states of the same particles.

    A particle's change is that of the component that changed most, in V or V / a. The mean over
    the particles bounds the change of the mean of every component.
    """

    mean: float
    largest: float


@dataclass(frozen=True)
class Figures:
    """Measured over the particles of a case with a finite state.

    Attributes
    ----------
    growth : float
        Largest gain of energy, in a collision [V^2] or over a whole rebound [energy before].
    residual : float
        Largest violation of equations (5)-(7) or of J dW = r x S in a collision [V].
    drift : float
        Largest relative change of energy or angular momentum in a free flight.
    depth : float
        Largest depth of a particle below the wall at a contact [a].
    least_velocity : float
        Least v+ [V].
    most_collisions : int
    mean_collisions : float
    contact : Change or None
        By half the contact resolution; None if that run did not finish.
    flight : Change or None
        By half the tolerance of the flight.
    """

    growth: float
    residual: float
    drift: float
    depth: float
    least_velocity: float
    most_collisions: int
    mean_collisions: float
    contact: Change | None
    flight: Change | None


@dataclass(frozen=True)
class Outcome:
    """A case, its particles, and what was measured.

    Attributes
    ----------
    case : Case
    seed : int
        Of the simulation; particle i has the index i and the stream 0.
    extrapolated : bool
        Whether the case is outside the speeds in which the restitution law was measured.
    particles : int
    non_finite : int
        Particles with a state or energy that is not finite, in any run of the case.
    unfinished : int
        Runs of the case, of three, in which a particle was still in contact at the alarm.
    figures : Figures or None
        None if there is no particle to measure.
    cost : float or None
        Run time [s] of a rebound on one thread, without audit; None if not measured.
    """

    case: Case
    seed: int
    extrapolated: bool
    particles: int
    non_finite: int
    unfinished: int
    figures: Figures | None
    cost: float | None = None

    @property
    def grows(self) -> bool:
        """Whether a particle gained energy."""
        return self.figures is not None and self.figures.growth > MOST_GROWTH

    @property
    def separated(self) -> bool:
        """Whether every measured particle left the wall, and none was inside it."""
        f = self.figures
        return f is None or (f.least_velocity > 0.0 and f.depth <= MOST_DEPTH)

    @property
    def failures(self) -> list[str]:
        """Failures of the model, a line each."""
        f = self.figures
        lines = []
        if self.non_finite:
            lines.append(f"{self.non_finite} of {self.particles} particles are not finite")
        if self.unfinished:
            lines.append("a particle is unfinished")
        if f is not None and self.grows:
            lines.append(f"energy grows by {f.growth:.3g}, allowed: {MOST_GROWTH:g}")
        if f is not None and f.least_velocity <= 0.0:
            lines.append(f"a particle leaves with v+ = {f.least_velocity:.3g} V, allowed: above 0")
        if f is not None and f.depth > MOST_DEPTH:
            lines.append(f"a contact is {f.depth:.3g} a deep, allowed: {MOST_DEPTH:g}")
        return lines

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers and names, for JSON."""
        data = asdict(self)
        return {**data.pop("case"), **data, "failures": self.failures}


def _finite(run: Simulation) -> NDArray[np.bool_]:
    """Which particles have a finite state and energy, (n,)."""
    if not np.isfinite(run.audit).all():
        return np.zeros(len(run.state), dtype=np.bool_)
    numbers = np.column_stack([run.state, run.energy])
    return np.asarray(np.isfinite(numbers).all(axis=1))


def _change(usual: Simulation, halved: Simulation | None, kept: NDArray[np.bool_]) -> Change | None:
    """Effect of a halved tolerance on the particles that are kept."""
    if halved is None:
        return None
    moved = np.abs(halved.state - usual.state)[kept].max(axis=1)
    return Change(float(moved.mean()), float(moved.max()))


def _figures(
    usual: Simulation,
    contact: Simulation | None,
    flight: Simulation | None,
    kept: NDArray[np.bool_],
) -> Figures:
    audit = usual.audit
    energy = usual.energy[kept].sum(axis=1)
    return Figures(
        growth=float(max(audit[ENERGY], energy.max() - 1.0)),
        residual=float(audit[[ANGULAR, NORMAL, TANGENTIAL]].max()),
        drift=float(audit[[FLIGHT_ENERGY, FLIGHT_MOMENTUM]].max()),
        depth=float(audit[PENETRATION]),
        least_velocity=float(usual.state[kept, 1].min()),
        most_collisions=int(usual.collisions[kept].max()),
        mean_collisions=float(usual.collisions[kept].mean()),
        contact=_change(usual, contact, kept),
        flight=_change(usual, flight, kept),
    )


def outcome_of(
    case: Case,
    seed: int,
    extrapolated: bool,
    particles: int,
    runs: tuple[Simulation | None, Simulation | None, Simulation | None],
) -> Outcome:
    """Measure a case.

    Parameters
    ----------
    case : Case
    seed : int
    extrapolated : bool
    particles : int
    runs : tuple of three Simulation or None
        The same particles with the usual numerical parameters, audited; with half the contact
        resolution; and with half the flight tolerance. None for a run that did not finish.

    Returns
    -------
    Outcome
    """
    usual, contact, flight = runs
    finished = [run for run in runs if run is not None]
    kept = np.ones(particles, dtype=np.bool_)
    for run in finished:
        kept &= _finite(run)
    return Outcome(
        case=case,
        seed=seed,
        extrapolated=extrapolated,
        particles=particles,
        non_finite=particles - int(np.count_nonzero(kept)),
        unfinished=len(runs) - len(finished),
        figures=None if usual is None or not kept.any() else _figures(usual, contact, flight, kept),
    )
