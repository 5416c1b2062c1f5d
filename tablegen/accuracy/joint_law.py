"""The law of condition and outcome, over the impacts that occur in chains: table against direct.

A table may be right at every condition that one looks at and yet wrong where particles are; and no
single condition shows whether a particle keeps its grain. So many particles are followed, each to
one impact, and its condition, its grain and its outcome are compared as one law.
"""

import math
from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from sampler.table import Table
from tablegen.accuracy.decision import LOOKS, Targets, undecided_metrics
from tablegen.accuracy.noise_corrected import Estimate, Settings, auc_estimate, ks_estimate
from tablegen.config.config import Config
from tablegen.config.metric_table import METRICS
from tablegen.config.targets import JointTargets
from tablegen.model.float_array import FloatArray
from tablegen.simulation.direct import DirectModel
from tablegen.simulation.impact_chains import (
    Impacts,
    effective_speed,
    energy_factor,
    occurring_impacts,
    simulated,
)

#: Impacts a side at first, and each further look at an undecided comparison has so many times as
#: many, up to the limit: two million take two gigabytes.
SAMPLES = 400_000
_MORE = 3
_MOST_SAMPLES = 2_000_000

#: Particles from which the share is taken that gives impacts within the table's range, and the
#: least share: of a table of few angles hardly a chain has two impacts there.
_PILOT = 2_000
_LEAST_SHARE = 0.02

#: States (n, 6) after impacts.
Draw = Callable[[Impacts], FloatArray]

#: Keys of the particles whose outcomes are drawn begin here; those of the others are below.
_DRAWN = 2**40


@dataclass(frozen=True)
class JointComparison:
    """A table against direct simulation over the impacts of chains."""

    #: KS of the outcomes over V_e and a/V_e, and the AUC of a classifier that is told condition,
    #: grain and outcome.
    estimates: dict[str, Estimate]
    #: AUC of one that is not told the grain.
    auc_without_grain: Estimate
    #: Impacts a side of the distances that needed most.
    states: int
    #: Quantiles of 1, 50 and 99 % of angle [degrees], speed [m/s] and size of the spin [V/a].
    alpha_deg: tuple[float, ...]
    speed: tuple[float, ...]
    spin: tuple[float, ...]

    @property
    def place(self) -> str:
        """Where, in words."""
        return "the impacts of chains"

    def to_dict(self) -> dict[str, Any]:
        """Write everything as JSON-ready numbers, tuples as lists."""
        return {
            "ks": list(self.estimates["ks"].by_variable),
            "auc": self.estimates["auc"].value,
            "auc_without_grain": self.auc_without_grain.value,
            "estimates": {name: e.to_dict() for name, e in self.estimates.items()},
            "states": self.states,
            "quantiles": {
                "alpha_deg": list(self.alpha_deg),
                "speed": list(self.speed),
                "spin": list(self.spin),
            },
        }


class _Side:
    """Conditions, grains and outcomes of one side; further ones do not change the first."""

    def __init__(
        self, config: Config, seed: int, share: float, draw: Draw | None, threads: int | None
    ) -> None:
        self.config, self.seed, self.draw, self.threads = config, seed, draw, threads
        self.model, self.share = DirectModel(config), share
        self.impacts: Impacts
        #: Shapes (n, 5), (n, 3) and (n, 6).
        self.conditions: FloatArray
        self.grains: FloatArray
        self.outcomes: FloatArray

    def reach(self, count: int) -> None:
        """Follow particles to about so many impacts."""
        index = np.arange(math.ceil(count / self.share), dtype=np.uint64)
        if self.draw is not None:
            index += np.uint64(_DRAWN)
        chains = occurring_impacts(self.config, self.model, self.seed, index, self.threads)
        factor = energy_factor(chains.spin)[:, None]
        self.impacts = chains
        self.conditions = np.column_stack(
            [np.sqrt(chains.alpha1), effective_speed(chains), chains.spin / factor]
        )
        self.grains = self.model.grains(self.seed, chains.index)
        self.outcomes = self._states() / factor

    def told(self, grain: bool) -> FloatArray:
        """All that a classifier is told of each impact."""
        grains = self.grains if grain else self.grains[:, :0]
        return np.hstack([self.conditions, grains, self.outcomes])

    def _states(self) -> FloatArray:
        """States after the impacts, over V."""
        chains = self.impacts
        if self.draw is None:
            return simulated(self.model, chains, self.seed, self.threads)
        return self.draw(chains)


def _estimates(
    drawn: _Side, direct: _Side, settings: Settings, metrics: Collection[str]
) -> dict[str, Estimate]:
    """Distances of outcomes, and of all that is known of the impacts."""
    found = {}
    if "ks" in metrics:
        found["ks"] = ks_estimate(drawn.outcomes, direct.outcomes)
    if "auc" in metrics:
        found["auc"] = auc_estimate(drawn.told(grain=True), direct.told(grain=True), settings)
    return found


def drawn_from(table: Table, seed: int, threads: int | None = None, *, spin: bool = True) -> Draw:
    """Give the function that draws the outcomes of impacts from a table.

    Parameters
    ----------
    table : Table
    seed : int
    threads : int, optional
    spin : bool
        Whether the table is told the spin; else every impact is a first one to it.
    """

    def draw(impacts: Impacts) -> FloatArray:
        given: dict[str, Any] = {"spin": impacts.spin} if spin else {}
        keys: dict[str, Any] = {"seed": seed, "index": impacts.index, "hit": impacts.hit}
        return table.sample(impacts.alpha1, impacts.speed, threads=threads, **keys, **given)

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

    Both sides have conditions that direct simulation made, each of particles of its own; the
    outcomes of one side are drawn. A particle keeps its grain on both.

    Parameters
    ----------
    draw : callable
        From impacts to states (n, 6); see `drawn_from`.
    config : Config
        What the law claims to represent.
    seed : int
    samples : int, optional
        Impacts a side at first, about; where these do not decide, up to nine times as many are
        taken.
    targets : JointTargets, optional
        Accuracy that is asked for; the declared one by default.
    threads : int, optional

    Returns
    -------
    JointComparison or None
        None if hardly a chain stays within the table's range up to its second impact.
    """
    share = share_inside(config, seed)
    if share < _LEAST_SHARE:
        return None
    allowed: Targets = targets or config.spin_targets.joint
    count, seed_of_metrics = samples or SAMPLES, seed % 2**32
    drawn, direct = (_Side(config, seed, share, side, threads) for side in (draw, None))
    found = _first_look(drawn, direct, count, Settings(seed_of_metrics))
    trained = min(found.states, METRICS["auc"].trial_states or found.states) // 2
    again = Settings(seed_of_metrics, classified=None, trained=trained)
    for look in range(1, LOOKS):
        more = min(count * _MORE**look, max(count, _MOST_SAMPLES))
        unclear = undecided_metrics(found, allowed)
        if not unclear or more <= found.states:
            break
        for side in (drawn, direct):
            side.reach(more)
        new = _estimates(drawn, direct, again, unclear)
        states = min(len(drawn.outcomes), len(direct.outcomes))
        found = replace(found, estimates=found.estimates | new, states=states)
    return found


def share_inside(config: Config, seed: int) -> float:
    """Share of particles that give an impact within the table's range."""
    pilot = np.arange(_PILOT, dtype=np.uint64)
    return len(occurring_impacts(config, DirectModel(config), seed, pilot).index) / _PILOT


def _first_look(drawn: _Side, direct: _Side, count: int, settings: Settings) -> JointComparison:
    """Compare so many impacts, in every number."""
    for side in (drawn, direct):
        side.reach(count)
    without = drawn.told(grain=False), direct.told(grain=False)
    impacts = direct.impacts

    def quantiles(values: FloatArray) -> tuple[float, ...]:
        return tuple(np.quantile(values, (0.01, 0.5, 0.99)).tolist())

    return JointComparison(
        estimates=_estimates(drawn, direct, settings, ("ks", "auc")),
        auc_without_grain=auc_estimate(without[0], without[1], settings),
        states=min(len(drawn.outcomes), len(direct.outcomes)),
        alpha_deg=quantiles(np.degrees(impacts.alpha1)),
        speed=quantiles(impacts.speed),
        spin=quantiles(np.linalg.norm(impacts.spin, axis=1)),
    )
