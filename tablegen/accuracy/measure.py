"""Measure the accuracy of a table against direct simulation with new particles."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from sampler.formats.channels import STATE
from sampler.formats.layout import ACCURACY
from sampler.library import processors
from sampler.table import Table
from tablegen.accuracy.comparison import Comparison, compare
from tablegen.accuracy.conditions import Place
from tablegen.accuracy.decision import LOOKS, Judged, Targets, Verdict, judge, undecided_metrics
from tablegen.accuracy.joint_law import JointComparison, compare_chains, drawn_from
from tablegen.accuracy.later_hits import LaterHit, later_hits
from tablegen.accuracy.noise_corrected import Estimate, Settings, estimated
from tablegen.accuracy.scene_variables import simulated_variables
from tablegen.config.config import Config
from tablegen.config.metric_table import JOINT, LATER, METRICS
from tablegen.config.targets import SpinTargets
from tablegen.model.float_array import FloatArray
from tablegen.progress import bar, thread_pool
from tablegen.simulation.simulate import simulate

#: Least number of states a side, and this over the square of the declared Kolmogorov-Smirnov
#: distance where that is more: the noise is then a third of the declared distance.
_LEAST_SAMPLES = 100_000
_SAMPLES = 40.0

#: Factor on the number of states at each further look, up to the limit: four million take a
#: gigabyte and half a minute.
_MORE = 3
_MOST_SAMPLES = 4_000_000

#: First stream of measurements; nodes use those below.
FIRST_STREAM = 2**31

#: First number of conditions of particles with their own grain; other conditions have those below,
#: and nodes those from 2**30 on.
FIRST_OWN = 2**29

_Piece = TypeVar("_Piece")
_Result = TypeVar("_Result")


def in_threads(
    work: Callable[[_Piece], _Result], pieces: Iterable[_Piece], tick: Callable[[int], Any]
) -> list[_Result]:
    """Work on pieces on all processors, one thread each; results are in the order of the pieces.

    ``tick`` is called with 1 for each finished piece. Numerical libraries keep to one thread,
    because more would change the last bit of sums.
    """
    found = []
    with threadpool_limits(limits=1), thread_pool(processors()) as pool:
        for result in pool.map(work, pieces):
            found.append(result)
            tick(1)
    return found


def sample_size(targets: Targets) -> int:
    """Compute the states a side that tell a declared accuracy from noise.

    Two samples of n differ by sqrt(log(12 / q) / n) in the worst of six variables with probability
    q; at q = 1e-3 that is half of the declared distance. Memory limits the number: distances below
    0.0032 may stay undecided.
    """
    return min(max(_LEAST_SAMPLES, int(_SAMPLES / targets.ks**2)), _MOST_SAMPLES)


@dataclass(frozen=True)
class ComparedCondition:
    """Condition at which a table is compared with direct simulation."""

    table: Table
    config: Config
    place: Place
    seed: int
    #: Separates conditions that share a seed: stream of the simulation and hit of the draws.
    number: int

    def states(self, count: int) -> tuple[FloatArray, FloatArray]:
        """Draw and simulate states; a larger count begins with the same states."""
        alpha1, speed, index = np.radians(self.place.alpha_deg), self.place.speed, np.arange(count)
        shared: dict[str, Any] = {"seed": self.seed, "threads": 1}
        stream = FIRST_STREAM + self.number
        direct = simulate(self.config, alpha1, speed, count, stream=stream, **shared)
        if self.place.own:
            shared["spin"] = np.zeros(3)
        drawn = self.table.sample(alpha1, speed, hit=self.number, index=index, **shared)
        return drawn, simulated_variables(direct, self.table.columns)

    def compared(self, samples: int, targets: Targets) -> Comparison:
        """Compare, with more states until everything is decided or there are too many.

        At further looks the classifier learns from as many states as before, and is tested with
        more.
        """
        seed, (alpha_deg, speed, own) = self.seed % 2**32, self.place
        both = self.states(samples)
        found = compare(*both, alpha_deg, speed, seed, self.table.columns, own)
        trained = min(samples, METRICS["auc"].trial_states or samples) // 2
        again = Settings(seed, classified=None, trained=trained)
        for look in range(1, LOOKS):
            count = min(samples * _MORE**look, max(samples, _MOST_SAMPLES))
            unclear = undecided_metrics(found, targets)
            if not unclear or count <= found.states:
                break
            new = estimated(*self.states(count), again, unclear)
            found = replace(found, estimates=found.estimates | new, states=count)
        return found


def measure(
    table: Table,
    config: Config,
    places: Sequence[Place],
    *,
    seed: int,
    samples: int | None = None,
    targets: Targets | None = None,
    progress: bool = False,
) -> list[Comparison]:
    """Compare a table with direct simulation at conditions of one law.

    There are ``samples`` states a side, by default as many as the accuracy needs. Undecided
    distances are measured again with three times, then nine times as many. ``targets`` is the
    accuracy asked for, by default the declared one. ``progress`` shows a bar on standard error.
    """
    allowed = targets or config.accuracy
    own = any(place.own for place in places)
    first, words = (FIRST_OWN, "own grain") if own else (0, "validating")
    work = [ComparedCondition(table, config, c, seed, first + k) for k, c in enumerate(places)]
    count = samples or sample_size(allowed)
    with bar(progress, "condition", total=len(work), desc=words) as counted:
        return in_threads(lambda place: place.compared(count, allowed), work, counted.update)


@dataclass(frozen=True)
class LawAccuracy:
    """Everything measured of one law of a table: the first-impact law or the spin law."""

    #: At conditions between nodes; those of a spin law are without spin.
    comparisons: list[Comparison]
    #: At the nodes that looked worst; none for a spin law.
    nodes: tuple[Comparison, ...] = ()
    #: Over the impacts of chains; None for the first-impact law, or if not measured.
    joint: JointComparison | None = None
    #: In cells of conditions, and after the hits of chains; none for the first-impact law.
    cells: tuple[LaterHit, ...] = ()
    hits: tuple[LaterHit, ...] = ()
    #: "spin " for the spin law: beginning of the lines of a verdict.
    prefix: str = ""

    @property
    def measured(self) -> list[Comparison]:
        """All comparisons at single conditions, those at nodes last."""
        return [*self.comparisons, *self.nodes]

    @property
    def count(self) -> int:
        """Number of comparisons."""
        joint = self.joint is not None
        return len(self.measured) + joint + len(self.cells) + len(self.hits)

    def estimates(self) -> dict[str, list[Estimate]]:
        """Give all estimates of each limit; limits over chains are named ``joint_``."""
        found: dict[str, list[Estimate]] = {}
        for comparison in self.measured:
            for name, estimate in comparison.estimates.items():
                found.setdefault(name, []).append(estimate)
        for later in (*self.cells, *self.hits):
            for name, estimate in later.estimates.items():
                found.setdefault(name, []).append(estimate)
        joint = self.joint.estimates if self.joint else {}
        return found | {f"{JOINT}{name}": [estimate] for name, estimate in joint.items()}

    def judged(self, targets: Any, together: int) -> Verdict:
        """Hold everything against an accuracy; see `tablegen.accuracy.decision.judge`."""
        verdict = judge(self.measured, targets, together, self.prefix)
        for later in (self.cells, self.hits):
            verdict += judge(later, targets, together, self.prefix)
        if self.joint is None:
            return verdict
        joint: list[Judged] = [self.joint]
        return verdict + judge(joint, targets.joint, together, f"{self.prefix}{JOINT}")


def measure_spin(
    table: Table,
    config: Config,
    places: Sequence[Place],
    *,
    seed: int,
    samples: int | None = None,
    targets: SpinTargets | None = None,
    progress: bool = False,
) -> LawAccuracy:
    """Compare a spin law with direct simulation that keeps the orientation of a grain.

    Without spin at some conditions, over the impacts of chains, in cells of conditions and at every
    hit of chains (`tablegen.accuracy.later_hits`); a table that leaves some of the six variables of
    a state out, without spin alone. Arguments are those of `measure`.
    """
    targets = targets or config.spin_targets
    how: dict[str, Any] = {"seed": seed, "samples": samples}
    found = measure(table, config, places, targets=targets, progress=progress, **how)
    if not set(STATE) <= set(table.columns):  # a chain goes on from all six
        return LawAccuracy(found, prefix="spin ")
    with threadpool_limits(limits=1), bar(progress, total=1, desc="impacts of chains") as counted:
        over = compare_chains(drawn_from(table, seed), config, targets=targets.joint, **how)
        counted.update()
    if over is None:
        return LawAccuracy(found, prefix="spin ")
    work = later_hits(drawn_from(table, seed, threads=1), config, seed, samples)
    with bar(progress, "comparison", total=len(work), desc="later hits") as counted:
        parts = in_threads(lambda compared: compared(), work, counted.update)
    whole = tuple(later for part in parts for later in part)
    cells = tuple(later for later in whole if "cell_ks" in later.estimates)
    hits = whole[len(cells) :]  # the cells come first
    return LawAccuracy(found, joint=over, cells=cells, hits=hits, prefix="spin ")


def spin_accuracy_datasets(measured: LawAccuracy | None) -> dict[str, NDArray[np.float64]]:
    """Make the datasets of the group ``spin_accuracy``; empty ones if nothing was measured."""
    comparisons = measured.comparisons if measured else []
    joint = measured.joint if measured else None
    columns: dict[str, list[Any]] = {
        "alpha_deg": [c.alpha_deg for c in comparisons],
        "speed": [c.speed for c in comparisons],
        "spin": [(0.0, 0.0, 0.0)] * len(comparisons),
        **{name: [c.distances()[name] for c in comparisons] for name in METRICS},
        "joint_ks": [joint.estimates["ks"].by_variable] if joint else [],
        "joint_auc": [joint.estimates["auc"].value] if joint else [],
    }
    for limit in LATER:
        part = () if measured is None else (*measured.cells, *measured.hits)
        columns[limit] = [x.estimates[limit].value for x in part if limit in x.estimates]
    variables = comparisons[0].variables if comparisons else STATE
    wide = {"spin": 3, "ks": len(variables), "joint_ks": len(STATE)}
    found = {name: np.array(values, dtype=np.float64) for name, values in columns.items()}
    return {
        f"{ACCURACY}{name}": values.reshape(-1, wide[name]) if name in wide else values
        for name, values in found.items()
    }
