"""Simulated moments of trial pairs: each made once, kept on disk, and their finite differences.

The random numbers are the same for all trials, so differences between trials are those of the
pairs. They are smooth but for particles that meet the wall often: a small change of a law decides
whether they hit once more. What that leaves in a difference quotient falls with the root of the
step and of the count, so steps are large; EXPERIMENTS.md has the measurement.
"""

import hashlib
from collections.abc import Callable
from dataclasses import fields

import numpy as np

from tablegen.checkpoints import CheckpointStore
from tablegen.measured.simulated_moments import SimulatedRows
from tablegen.measured.strata import CentralMoments, SimulatedMoments, Strata
from tablegen.measured.trial_pairs import TrialPairs
from tablegen.model.float_array import FloatArray

#: What turns simulated moments into some of their numbers, (m,), and chance errors, (m,).
Pick = Callable[[SimulatedMoments], tuple[FloatArray, FloatArray]]

#: Arrays of `CentralMoments` on disk.
_ARRAYS = tuple(field.name for field in fields(CentralMoments) if field.name != "count")


class Evaluations:
    """Simulations of trial pairs at the measured conditions.

    Parameters
    ----------
    trials : TrialPairs
    alpha_deg, speed : (n,) float64
        Conditions.
    seed : int
    threads : int, optional
        Default: one a processor. No result depends on it.
    store : CheckpointStore, optional
        Where finished simulations are kept.
    on_simulated : callable
        Is called with the number of particles of each evaluation that is new in this run.
    """

    def __init__(
        self,
        trials: TrialPairs,
        alpha_deg: FloatArray,
        speed: FloatArray,
        seed: int,
        threads: int | None = None,
        store: CheckpointStore | None = None,
        on_simulated: Callable[[int], None] = lambda count: None,
    ) -> None:
        self.trials = trials
        self.conditions = alpha_deg, speed
        self.seed = seed
        self.threads = threads
        self._store = store
        self._on_simulated = on_simulated
        self._known: dict[str, Strata] = {}
        rows = np.concatenate(self.conditions).astype("<f8").tobytes()
        self._prefix = f"{seed} {hashlib.sha256(rows).hexdigest()}"

    def with_seed(self, seed: int) -> "Evaluations":
        """Make evaluations of the same trials with other random numbers."""
        return Evaluations(
            self.trials, *self.conditions, seed, self.threads, self._store, self._on_simulated
        )

    def moments(self, x: FloatArray, count: int) -> SimulatedMoments:
        """Moments of the trial at coordinates x, with ``count`` particles of each shape."""
        return self.strata(x, count).mixed(self.trials.shares(x))

    def strata(self, x: FloatArray, count: int) -> Strata:
        """Moments of each shape; they do not depend on coordinates that decide shares alone."""
        decisive = x[~self.trials.of_shares]
        key = f"{self._prefix} {count} {decisive.astype('<f8').tobytes().hex()}"
        if key not in self._known:
            self._known[key] = self._made(key, x, count)
            self._on_simulated(count)
        return self._known[key]

    def _made(self, key: str, x: FloatArray, count: int) -> Strata:
        found = self._store.load(key) if self._store else None
        if found is not None:
            shares = np.array([part.share for part in self.trials.every_shape(x).strata()])
            kept = CentralMoments(count=count, **{name: found[name] for name in _ARRAYS})
            return Strata(self.conditions[0], shares, kept)
        made = self._rows(x).strata(count)
        if self._store:
            self._store.save(key, {name: getattr(made.moments, name) for name in _ARRAYS})
        return made

    def variables(self, x: FloatArray, count: int) -> list[list[FloatArray]]:
        """Variables (count, 5) of the rebounds of each shape at each condition."""
        return self._rows(x).variables(count)

    def _rows(self, x: FloatArray) -> SimulatedRows:
        """Measured conditions, with the pair and every shape of the trial at coordinates x."""
        return SimulatedRows(
            self.trials.pair(x),
            self.trials.every_shape(x),
            *self.conditions,
            seed=self.seed,
            numerics=self.trials.config.model,
            wall_tilt_deg=self.trials.wall_tilt_deg(x),
            threads=self.threads,
        )

    def slopes(self, x: FloatArray, count: int, pick: Pick, central: bool) -> FloatArray:
        """Difference quotients (m, p) of picked numbers by the coordinates.

        Parameters
        ----------
        x : (p,) float64
        count : int
        pick : callable
        central : bool
            From both sides, unless a bound is nearer than the step; otherwise from one.
        """
        trials = self.trials
        columns = []
        for k, step in enumerate(trials.step):
            up, down = x.copy(), x.copy()
            up[k] = min(x[k] + step, trials.high[k])
            room = x[k] - trials.low[k]
            if central or up[k] - x[k] < 0.5 * step:
                down[k] = x[k] - min(step, room)
            above, below = (pick(self.moments(y, count))[0] for y in (up, down))
            columns.append((above - below) / (up[k] - down[k]))
        return np.array(columns).T
