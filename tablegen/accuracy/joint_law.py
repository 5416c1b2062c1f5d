"""Compare the law of condition, grain and outcome over the impacts that occur in chains.

A table may be right at every single condition and yet wrong where particles are, and no single
condition shows whether a particle keeps its grain. So particles are followed, each to one impact,
and its condition, grain and outcome are compared as one law.
"""

import math
from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from sampler.formats.channels import STATE
from sampler.table import Table
from tablegen.accuracy.decision import LOOKS, Targets, undecided_metrics
from tablegen.accuracy.noise_corrected import Estimate, Settings, auc_estimate, ks_estimate
from tablegen.config.config import Config
from tablegen.config.metric_table import JOINT_METRICS, METRICS
from tablegen.config.targets import JointTargets
from tablegen.model.float_array import FloatArray
from tablegen.simulation.direct import DirectModel
from tablegen.simulation.impact_chains import (
    Impacts,
    depart,
    effective_speed,
    energy_factor,
    occurring_impacts,
)

#: Impacts a side at first, factor at each further look, and limit: two million take two gigabytes.
SAMPLES = 400_000
_MORE = 3
_MOST_SAMPLES = 2_000_000

#: Particles followed to find the share that gives impacts within the table's range, and the least
#: such share: in a table of few angles hardly a chain has two impacts.
_PILOT = 2_000
_LEAST_SHARE = 0.02

#: First index of the particles whose outcomes are drawn; simulated ones have those below.
_DRAWN = 2**40

#: Function from impacts to the states (n, 6) after them.
Draw = Callable[[Impacts], FloatArray]


@dataclass(frozen=True)
class JointComparison:
    """Table against direct simulation over the impacts of chains."""

    #: KS of the outcomes over V_e and a/V_e, and AUC of a classifier that knows condition, grain
    #: and outcome.
    estimates: dict[str, Estimate]
    #: AUC of a classifier that does not know the grain.
    auc_without_grain: Estimate
    #: Impacts a side in the last look.
    states: int
    #: Quantiles of 1, 50 and 99 % of ``alpha_deg``, ``speed`` [m/s] and size of ``spin`` [V/a].
    quantiles: dict[str, list[float]]

    @property
    def place(self) -> str:
        """The condition in words."""
        return "the impacts of chains"

    def to_dict(self) -> dict[str, Any]:
        """Give every number but the estimates for JSON."""
        return {
            **{name: estimate.distance for name, estimate in self.estimates.items()},
            "auc_without_grain": self.auc_without_grain.value,
            "states": self.states,
            "quantiles": self.quantiles,
        }


class _Side(NamedTuple):
    """Impacts of one side, scaled by V_e."""

    impacts: Impacts
    #: Shapes (n, 5), (n, 3) and (n, 6).
    conditions: FloatArray
    grains: FloatArray
    outcomes: FloatArray

    def features(self, *, grain: bool) -> FloatArray:
        """Give the columns that a classifier sees."""
        grains = self.grains if grain else self.grains[:, :0]
        return np.hstack([self.conditions, grains, self.outcomes])


def _side(
    model: DirectModel,
    config: Config,
    seed: int,
    draw: Draw | None,
    threads: int | None,
    count: int,
) -> _Side:
    """Follow particles to their impacts and outcomes; those of a larger count begin the same."""
    index = np.arange(count, dtype=np.uint64)
    if draw is not None:
        index += np.uint64(_DRAWN)
    impacts = occurring_impacts(config, model, seed, index, threads)
    factor = energy_factor(impacts.spin)[:, None]
    conditions = [np.sqrt(impacts.alpha1), effective_speed(impacts), impacts.spin / factor]
    states = depart(model, impacts, seed, threads).states if draw is None else draw(impacts)
    return _Side(impacts, np.column_stack(conditions), impacts.grain, states / factor)


def _estimates(
    drawn: _Side, direct: _Side, settings: Settings, metrics: Collection[str]
) -> dict[str, Estimate]:
    """Estimate the distances of outcomes, and of everything known of the impacts."""
    found = {}
    if "ks" in metrics:
        found["ks"] = ks_estimate(drawn.outcomes, direct.outcomes)
    if "auc" in metrics:
        both = drawn.features(grain=True), direct.features(grain=True)
        found["auc"] = auc_estimate(*both, settings)
    return found


def drawn_from(table: Table, seed: int, threads: int | None = None, *, spin: bool = True) -> Draw:
    """Make the function that draws the outcomes of impacts from a table.

    Without ``spin`` the table does not receive the spin, and every impact is a first one.
    """

    def draw(impacts: Impacts) -> FloatArray:
        given: dict[str, Any] = {"spin": impacts.spin, "grain": impacts.grain} if spin else {}
        keys: dict[str, Any] = {"seed": seed, "index": impacts.index, "hit": impacts.hit}
        # chains reach spins beyond those of the law, and draws there are compared too
        drawn = table.sample(impacts.alpha1, impacts.speed, threads=threads, **keys, **given)
        return drawn[:, : len(STATE)]

    return draw


def compare_chains(
    draw: Draw,
    config: Config,
    *,
    seed: int,
    samples: int | None = None,
    targets: JointTargets | None = None,
    threads: int | None = None,
) -> JointComparison | None:
    """Compare a spin law with direct simulation over the impacts that occur in chains.

    Direct simulation makes the conditions of both sides, each with particles of its own, which keep
    their grains. ``draw`` gives the outcomes (n, 6) of one side; see `drawn_from`. ``samples`` is
    about the number of impacts a side at first. ``targets`` are the declared ones by default. The
    result is None if hardly a chain stays within the table's range up to its second impact.
    """
    share = share_inside(config, seed)
    if share < _LEAST_SHARE:
        return None
    allowed: Targets = targets or config.spin_targets.joint
    count, seed_of_metrics, model = samples or SAMPLES, seed % 2**32, DirectModel(config)
    sides = [partial(_side, model, config, seed, source, threads) for source in (draw, None)]
    drawn, direct = (side(math.ceil(count / share)) for side in sides)
    found = _first_look(drawn, direct, seed_of_metrics)
    trained = min(found.states, METRICS["auc"].trial_states or found.states) // 2
    again = Settings(seed_of_metrics, classified=None, trained=trained)
    for look in range(1, LOOKS):
        more = min(count * _MORE**look, max(count, _MOST_SAMPLES))
        unclear = undecided_metrics(found, allowed)
        if not unclear or more <= found.states:
            break
        drawn, direct = (side(math.ceil(more / share)) for side in sides)
        new = _estimates(drawn, direct, again, unclear)
        states = min(len(drawn.outcomes), len(direct.outcomes))
        found = replace(found, estimates=found.estimates | new, states=states)
    return found


def share_inside(config: Config, seed: int) -> float:
    """Estimate the share of particles that give an impact within the table's range."""
    pilot = np.arange(_PILOT, dtype=np.uint64)
    return len(occurring_impacts(config, DirectModel(config), seed, pilot).index) / _PILOT


def _first_look(drawn: _Side, direct: _Side, seed: int) -> JointComparison:
    """Compare two sides in every number."""
    settings, impacts = Settings(seed), direct.impacts
    without = drawn.features(grain=False), direct.features(grain=False)
    sizes = {
        "alpha_deg": np.degrees(impacts.alpha1),
        "speed": impacts.speed,
        "spin": np.linalg.norm(impacts.spin, axis=1),
    }
    return JointComparison(
        estimates=_estimates(drawn, direct, settings, JOINT_METRICS),
        auc_without_grain=auc_estimate(*without, settings),
        states=min(len(drawn.outcomes), len(direct.outcomes)),
        quantiles={n: np.quantile(x, (0.01, 0.5, 0.99)).tolist() for n, x in sizes.items()},
    )
