"""Stability study: simulate every case three times, and check each against the laws."""

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

import sampler
from sampler.errors import InputError
from tablegen.config.config import Config
from tablegen.config.defaults import STABILITY_COUNT
from tablegen.evidence.stability_cases import Case
from tablegen.evidence.stability_chains import ChainOutcome, run_chains
from tablegen.evidence.stability_friction import FrictionOutcome, failures_of, run_friction
from tablegen.parallel import in_threads
from tablegen.progress import bar
from tablegen.simulation.simulate import Simulation, make_condition, simulate_condition

#: Energy that rounding may add, relative to the energy before, or to V^2 per unit mass.
MOST_GROWTH = 1e-12


@dataclass(frozen=True)
class Figures:
    """Quantities measured over the particles of a case."""

    #: Largest gain of energy over a rebound, over the energy before.
    growth: float
    #: Largest share of the energy before that neither a particle keeps nor the impulses take.
    unaccounted: float
    #: Smallest v+ [V].
    least_velocity: float
    most_collisions: int
    mean_collisions: float
    #: Mean change of a particle's most changed variable [V or V/a], by half the contact
    #: resolution and by half the flight tolerance; None if that run did not finish.
    contact: float | None
    flight: float | None


@dataclass(frozen=True)
class Outcome:
    """Outcome of a case."""

    case: Case
    #: Of the simulation; particle i has the index i and the stream 0.
    seed: int
    particles: int
    #: Runs, of three, in which a particle is not finite or was still in contact at the alarm.
    unfinished: int
    #: None if the run with the usual parameters did not finish.
    figures: Figures | None

    def __str__(self) -> str:
        return str(self.case)

    @property
    def failures(self) -> dict[str, str]:
        """Failures of the model by kind, a line each."""
        figures, failed = self.figures, {}
        if self.unfinished:
            failed["unfinished"] = "a particle is unfinished"
        if figures is not None:
            failed |= failures_of(figures.growth, MOST_GROWTH, figures.least_velocity)
        return failed

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers and names, for JSON."""
        data = asdict(self)
        return {**data.pop("case"), **data, "failures": list(self.failures.values())}


@dataclass(frozen=True)
class Study:
    """Outcomes of all cases; case k has the seed (seed + k) mod 2**64 and `count` particles."""

    pair: str
    contact_resolution: float
    tolerance: float
    seed: int
    count: int
    outcomes: tuple[Outcome, ...]
    #: Random impacts under Coulomb's law, if they were asked for.
    friction: tuple[FrictionOutcome, ...] = ()
    #: Grains through many hits, if they were asked for.
    chains: tuple[ChainOutcome, ...] = ()

    @property
    def failed(self) -> tuple[Outcome | FrictionOutcome | ChainOutcome, ...]:
        """Outcomes in which the model failed."""
        every = self.outcomes + self.friction + self.chains
        return tuple(outcome for outcome in every if outcome.failures)

    @property
    def holds(self) -> bool:
        """Whether the model failed in no case."""
        return not self.failed

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers and names, for JSON: degrees, m/s and s."""
        data = {name: value for name, value in vars(self).items() if name != "outcomes"}
        data["friction"] = [outcome.to_dict() for outcome in self.friction]
        data["chains"] = [outcome.to_dict() for outcome in self.chains]
        cases = [outcome.to_dict() for outcome in self.outcomes]
        version = {"software_version": sampler.__version__}
        return {**version, **data, "holds": self.holds, "cases": cases}


def run_case(config: Config, case: Case, count: int, seed: int) -> Outcome:
    """Simulate and check one case with some particles."""
    usual = _simulated(config, case, count, seed)
    contact = _simulated(config, case, count, seed, contact=0.5)
    flight = _simulated(config, case, count, seed, flight=0.5)
    unfinished = sum(run is None for run in (usual, contact, flight))
    figures = None if usual is None else _figures(usual, contact, flight)
    return Outcome(case, seed, count, unfinished, figures)


def _simulated(
    config: Config,
    case: Case,
    count: int,
    seed: int,
    *,
    contact: float = 1.0,
    flight: float = 1.0,
) -> Simulation | None:
    """Simulate a case with scaled numerical parameters; None if a particle does not finish."""
    resolution = contact * config.model.contact_resolution
    tolerance, spin = flight * config.model.tolerance, (0.0, 0.0, case.spin)
    condition = make_condition(
        math.radians(case.alpha_deg), case.speed, spin, resolution, tolerance
    )
    run = (config.pair, case.population(config), condition, count)
    try:
        return simulate_condition(*run, seed=seed, threads=1)
    except RuntimeError:
        return None


def _figures(usual: Simulation, contact: Simulation | None, flight: Simulation | None) -> Figures:

    def change(halved: Simulation | None) -> float | None:
        if halved is None:
            return None
        return float(np.abs(halved.state - usual.state).max(axis=1).mean())

    kept = usual.energy.sum(axis=1)
    return Figures(
        growth=float(kept.max()) - 1.0,
        unaccounted=float(np.abs(1.0 - kept - usual.work.sum(axis=1)).max()),
        least_velocity=float(usual.state[:, 1].min()),
        most_collisions=int(usual.collisions.max()),
        mean_collisions=float(usual.collisions.mean()),
        contact=change(contact),
        flight=change(flight),
    )


def run_study(
    config: Config,
    cases: Sequence[Case],
    *,
    count: int = STABILITY_COUNT,
    friction: int = 0,
    chained: int = 0,
    seed: int = 1,
    threads: int | None = None,
    progress: bool = False,
) -> Study:
    """Simulate and check cases of ``count`` particles.

    ``friction`` is the number of particles under each law of Coulomb friction
    (`tablegen.evidence.stability_friction`), ``chained`` that of grains of each kind in chains of
    hits (`tablegen.evidence.stability_chains`). Threads change nothing but the run time. Raises
    `InputError` if the tolerance cannot be halved.
    """
    numerics = config.model
    if numerics.tolerance < 2e-14:
        allowed = "2e-14 to 1e-4 in a stability study, which halves it"
        raise InputError("model.tolerance", f"{numerics.tolerance:g}", allowed)
    # a random order mixes cheap and expensive cases, for an even progress
    order = np.random.default_rng(0).permutation(len(cases)).tolist()

    def check(number: int) -> Outcome:
        return run_case(config, cases[number], count, (seed + number) % 2**64)

    with bar(progress, "case", total=len(cases), desc="checking") as counted:
        checked = dict(zip(order, in_threads(check, order, counted.update, threads), strict=True))
    outcomes = tuple(checked[number] for number in range(len(cases)))
    pair, resolution = config.pair_name, numerics.contact_resolution
    rubbed = run_friction(config, friction, seed, threads, progress) if friction else ()
    hit = run_chains(config, chained, seed, progress) if chained else ()
    return Study(pair, resolution, numerics.tolerance, seed, count, outcomes, rubbed, hit)
