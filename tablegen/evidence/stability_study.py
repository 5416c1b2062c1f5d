"""The stability study: every case simulated three times, checked and timed."""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

import sampler
from sampler.errors import InputError
from sampler.library import processors
from tablegen.config.config import Config
from tablegen.config.defaults import STABILITY_COUNT
from tablegen.config.pairs import MaterialPair
from tablegen.evidence.cases import Case
from tablegen.evidence.outcome import Outcome, outcome_of
from tablegen.progress import bar
from tablegen.simulation.batches import NotFiniteError
from tablegen.simulation.simulate import Simulation, make_condition, simulate_condition
from tablegen.tasks.side_by_side import side_by_side

#: Shorter calls [s] are timed twice, and the shorter time counts: other load would show in them.
_LONG = 0.01


@dataclass(frozen=True)
class Study:
    """Outcomes of all cases, in their order.

    Attributes
    ----------
    pair : str
    contact_resolution, tolerance : float
        The usual numerical parameters.
    seed, count : int
        Case number k has the seed (seed + k) mod 2**64 and ``count`` particles.
    outcomes : tuple of Outcome
    """

    pair: str
    contact_resolution: float
    tolerance: float
    seed: int
    count: int
    outcomes: tuple[Outcome, ...]

    @property
    def failed(self) -> tuple[Outcome, ...]:
        """Outcomes in which the model failed."""
        return tuple(outcome for outcome in self.outcomes if outcome.failures)

    @property
    def holds(self) -> bool:
        """Whether the model failed in no case."""
        return not self.failed

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers and names, for JSON; angles in degrees, speeds in m/s, cost in s."""
        return {
            "software_version": sampler.__version__,
            "pair": self.pair,
            "contact_resolution": self.contact_resolution,
            "tolerance": self.tolerance,
            "seed": self.seed,
            "count": self.count,
            "holds": self.holds,
            "cases": [outcome.to_dict() for outcome in self.outcomes],
        }


def _simulated(
    config: Config,
    case: Case,
    count: int,
    seed: int,
    *,
    contact: float = 1.0,
    flight: float = 1.0,
    audited: bool = False,
) -> Simulation | None:
    """Simulate a case with parameters ``contact`` and ``flight`` times the usual ones.

    None if a particle is still in contact at the alarm.
    """
    condition = make_condition(
        math.radians(case.alpha_deg),
        case.speed,
        (0.0, 0.0, case.spin),
        contact * config.model.contact_resolution,
        flight * config.model.tolerance,
    )
    population = case.population(config)
    try:
        return simulate_condition(
            config.pair, population, condition, count, seed=seed, threads=1, audited=audited
        )
    except NotFiniteError as error:
        return error.simulation  # which the outcome counts
    except RuntimeError:
        return None


def extrapolates(pair: MaterialPair, case: Case) -> bool:
    """Whether a case is outside the speeds in which the restitution law was measured.

    Both the impact speed V and the largest speed with which the spin brings a point to the wall,
    V (1 + |s|), must be inside.
    """
    speeds = (case.speed, case.speed * (1.0 + abs(case.spin)))
    return any(pair.extrapolation(speed) is not None for speed in speeds)


def run_case(config: Config, case: Case, count: int, seed: int) -> Outcome:
    """Simulate and check one case; it is not timed.

    Parameters
    ----------
    config : Config
        Its pair, truncation of prisms, and numerical parameters are used.
    case : Case
    count : int
        Number of particles, positive.
    seed : int
        0 to 2**64 - 1.

    Returns
    -------
    Outcome

    Raises
    ------
    InputError
        If the case cannot be simulated.
    """
    runs = (
        _simulated(config, case, count, seed, audited=True),
        _simulated(config, case, count, seed, contact=0.5),
        _simulated(config, case, count, seed, flight=0.5),
    )
    return outcome_of(case, seed, extrapolates(config.pair, case), count, runs)


def _elapsed(work: Callable[[], object]) -> float:
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def _call_overhead(config: Config) -> float:
    """Time of a call that simulates one sphere."""
    case = Case("sphere", (1.0, 1.0), 90.0, 200.0, 0.0)
    return min(_elapsed(lambda: _simulated(config, case, 1, 0)) for _ in range(50))


def _timed(config: Config, outcome: Outcome, overhead: float) -> Outcome:
    """Outcome with the cost of a rebound; nothing else of the study runs at that time."""
    if outcome.unfinished:
        return outcome

    def work() -> None:
        _simulated(config, outcome.case, outcome.particles, outcome.seed)

    elapsed = _elapsed(work)
    if elapsed < _LONG:
        elapsed = min(elapsed, _elapsed(work))
    return replace(outcome, cost=(elapsed - overhead) / outcome.particles)


def _random_order(count: int) -> Sequence[int]:
    """Random order of the cases, which mixes cheap and expensive ones for an even progress."""
    order: list[int] = np.random.default_rng(0).permutation(count).tolist()
    return order


def _check_numerics(config: Config) -> None:
    """Refuse a tolerance that cannot be halved."""
    if config.model.tolerance < 2e-14:
        raise InputError(
            f"model.tolerance: got {config.model.tolerance:g}, allowed in a stability study: "
            "2e-14 to 1e-4, because it is halved"
        )


def run_study(
    config: Config,
    cases: Sequence[Case],
    *,
    count: int = STABILITY_COUNT,
    seed: int = 1,
    threads: int | None = None,
    progress: bool = False,
) -> Study:
    """Simulate, check and time cases.

    Threads share the cases; their number changes nothing but the run time. The timing that
    follows uses one thread.

    Parameters
    ----------
    config : Config
    cases : sequence of Case
    count : int
        Particles a case, positive.
    seed : int
        0 to 2**64 - 1.
    threads : int, optional
        Default: one a processor.
    progress : bool
        Show progress bars on standard error.

    Returns
    -------
    Study

    Raises
    ------
    InputError
        If an argument is out of range or the tolerance cannot be halved.
    """
    _check_numerics(config)
    if not cases:
        raise InputError("cases: got none, allowed: at least one")
    order = _random_order(len(cases))

    def work(number: int) -> tuple[int, Outcome]:
        return number, run_case(config, cases[number], count, (seed + number) % 2**64)

    # the first call compiles, which is neither shown nor timed
    overhead = _call_overhead(config)
    done: dict[int, Outcome] = {}
    with bar(progress, "case", total=len(cases), desc="checking") as counted:
        for number, outcome in side_by_side(work, order, threads or processors()):
            done[number] = outcome
            counted.update()
    with bar(progress, "case", total=len(cases), desc="timing") as counted:
        for number in order:
            done[number] = _timed(config, done[number], overhead)
            counted.update()
    return Study(
        pair=config.pair_name,
        contact_resolution=config.model.contact_resolution,
        tolerance=config.model.tolerance,
        seed=seed,
        count=count,
        outcomes=tuple(done[number] for number in range(len(cases))),
    )
