"""Trial pairs of a search: the pair at given coordinates, and its simulated moments.

All trials have the same random numbers, so differences between trials are those of the pairs. They
are smooth except for particles that meet the wall often: a small change of a law decides whether
such a particle hits once more. The error of a difference quotient from this falls with the root of
the step and of the count, so steps are large. EXPERIMENTS.md has the measurement.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import reduce

import numpy as np

from tablegen.checkpoints import CheckpointStore
from tablegen.config.config import Config
from tablegen.config.pairs import MaterialPair
from tablegen.config.population import Population
from tablegen.config.scenes import Tree, merged
from tablegen.measured.moments import CentralMoments, SimulatedMoments, Strata
from tablegen.measured.parameters import SHAPES, WALL_TILT, Parameter, Space
from tablegen.measured.simulated_rows import Scenario, SimulatedRows
from tablegen.model.float_array import FloatArray

#: Takes numbers (m,) and their chance errors (m,) out of simulated moments.
Pick = Callable[[SimulatedMoments], tuple[FloatArray, FloatArray]]


class TrialPairs:
    """Pairs that differ from a given one in the free parameters, at p coordinates.

    The roughness of the wall is the given one unless it is free.
    """

    def __init__(
        self, config: Config, parameters: Sequence[Parameter], wall_tilt_deg: float
    ) -> None:
        self.config = config
        self._parameters, self._tilt = tuple(parameters), wall_tilt_deg
        #: Names of the fitted numbers, and their coordinates.
        self.labels = tuple(label for p in parameters for label in p.labels)
        self.space = Space(*map(np.concatenate, zip(*(p.space for p in parameters), strict=True)))
        sizes = [len(p.labels) for p in parameters]
        self._ends = np.cumsum(sizes)[:-1]
        #: Whether a coordinate decides only the shares of the shapes, (p,).
        self.of_shares = np.repeat([p.name == SHAPES for p in parameters], sizes)
        self._pair = config.pair.model_dump(mode="json", by_alias=True, exclude_none=True)
        self._weights = config.population.shapes.model_dump(by_alias=True)

    def numbers(self, x: FloatArray) -> FloatArray:
        """Compute the fitted numbers (p,), not rounded, at coordinates (p,)."""
        parts = zip(self._parameters, np.split(x, self._ends), strict=True)
        return np.concatenate([p.scale.values(part) for p, part in parts])

    def slopes(self, x: FloatArray) -> FloatArray:
        """Differentiate the fitted numbers by the coordinates, (p, p)."""
        h = 1e-6 * self.space.step
        sides = [(self.numbers(x + d), self.numbers(x - d)) for d in np.diag(h)]
        return np.array([(up - down) / (2.0 * s) for (up, down), s in zip(sides, h, strict=True)]).T

    def changes(self, x: FloatArray) -> Tree:
        """Make the fields of the pair file that differ, and the roughness."""
        parts = zip(self._parameters, np.split(x, self._ends), strict=True)
        return reduce(merged, [p.changes(part) for p, part in parts], {})

    def pair(self, x: FloatArray) -> MaterialPair:
        """Make the laws of contact."""
        return MaterialPair.from_tree(merged({"pair": self._pair}, self.changes(x))["pair"])

    def population(self, x: FloatArray) -> Population:
        """Make the particles."""
        given = self.config.population
        changes = self.changes(x).get("population", {})
        new: Tree = {}
        if "shapes" in changes:
            new["shapes"] = type(given.shapes).from_tree({**self._weights, **changes["shapes"]})
        if "aspect" in changes and given.aspect is not None:
            aspect = given.aspect.model_dump(mode="json") | changes["aspect"]
            new["aspect"] = type(given.aspect).from_tree(aspect)
        if "truncation" in changes:
            new["truncation"] = changes["truncation"]
        return given.model_copy(update=new)

    def every_shape(self, x: FloatArray) -> Population:
        """Make the particles with all shapes whose share may differ from zero."""
        population = self.population(x)
        if not self.of_shares.any():
            return population
        free = {label.removeprefix(f"{SHAPES}.") for label in self.labels}
        present = {n: 1.0 for n, w in self._weights.items() if w > 0.0 or n in free}
        return population.model_copy(update={"shapes": type(population.shapes).from_tree(present)})

    def shares(self, x: FloatArray) -> FloatArray:
        """Compute the share of each stratum of `every_shape`."""
        share = {part.code: part.share for part in self.population(x).strata()}
        return np.array([share.get(part.code, 0.0) for part in self.every_shape(x).strata()])

    def wall_tilt_deg(self, x: FloatArray) -> float:
        """Give the roughness of the wall, degrees."""
        return float(self.changes(x).get(WALL_TILT, self._tilt))


@dataclass(frozen=True)
class Evaluations:
    """Simulations of trial pairs at given conditions: each is made once, and kept on disk."""

    trials: TrialPairs
    #: Conditions, (n,) float64.
    alpha_deg: FloatArray
    speed: FloatArray
    seed: int
    threads: int | None = None
    #: Keeps finished simulations.
    store: CheckpointStore | None = None
    #: Is called with the number of particles of each simulation that is not known yet.
    on_simulated: Callable[[int], object] = lambda count: None
    _known: dict[str, Strata] = field(default_factory=dict, init=False)

    def moments(self, x: FloatArray, count: int) -> SimulatedMoments:
        """Give the moments of a trial, with ``count`` particles of each shape."""
        return self.strata(x, count).mixed(self.trials.shares(x))

    def strata(self, x: FloatArray, count: int) -> Strata:
        """Give the moments of each shape, which do not depend on coordinates of shares."""
        decisive = x[~self.trials.of_shares]
        inputs = np.concatenate([self.alpha_deg, self.speed, decisive]).astype("<f8").tobytes()
        key = f"{self.seed} {count} {inputs.hex()}"
        if key not in self._known:
            self._known[key] = self._made(key, x, count)
            self.on_simulated(count)
        return self._known[key]

    def _made(self, key: str, x: FloatArray, count: int) -> Strata:
        """Simulate, or read the simulation of an interrupted run."""
        found = self.store.load(key) if self.store else None
        if found is not None:
            shares = np.array([part.share for part in self.trials.every_shape(x).strata()])
            return Strata(self.alpha_deg, shares, count, CentralMoments(**found))
        made = self.rows(x).strata(count)
        if self.store:
            self.store.save(key, made.moments._asdict())
        return made

    def rows(self, x: FloatArray) -> SimulatedRows:
        """Make the simulation of every shape of the trial at coordinates x."""
        trials = self.trials
        tilt = trials.wall_tilt_deg(x)
        scenario = Scenario(trials.pair(x), trials.every_shape(x), trials.config.model, tilt)
        return self.simulated(scenario, self.seed)

    def simulated(self, scenario: Scenario, seed: int) -> SimulatedRows:
        """Make a simulation at these conditions."""
        return SimulatedRows(scenario, self.alpha_deg, self.speed, seed=seed, threads=self.threads)

    def slopes(self, x: FloatArray, count: int, pick: Pick, central: bool) -> FloatArray:
        """Compute difference quotients (m, p) of picked numbers by the coordinates.

        Central ones take both sides, except next to a bound, and others take one side.
        """
        space, columns = self.trials.space, []
        for k, step in enumerate(space.step):
            up, down = x.copy(), x.copy()
            up[k] = min(x[k] + step, space.high[k])
            if central or up[k] - x[k] < 0.5 * step:
                down[k] = x[k] - min(step, x[k] - space.low[k])
            above, below = (pick(self.moments(y, count))[0] for y in (up, down))
            columns.append((above - below) / (up[k] - down[k]))
        return np.array(columns).T
