"""Moments and quantiles of the law of a table at a condition, from draws."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sampler import library
from sampler.arguments import Call, Grain, Keys, as_reals_up_to, common_shape, present
from sampler.errors import refuse
from sampler.library import OpenTable, Report, Rows

#: Draws at a condition, and a seed that is kept for them: a user's draws shall not repeat them.
DRAWS = 2**18
SEED = 0xB5297A4D3F84D5B5

#: From the states of many draws at one condition to some numbers.
Reduction = Callable[[NDArray[np.float64]], Any]


class LawAtConditions:
    """The methods of `sampler.Table` that give moments and quantiles of its law."""

    columns: tuple[str, ...]
    _table: OpenTable
    _call: Callable[[dict[str, Any], Grain, Keys], Call]
    _refuse: Callable[[Call, Report], None]
    _count: Callable[[Call, Report, int], None]

    def mean(
        self, alpha1: ArrayLike, speed: ArrayLike, spin: ArrayLike | None = None
    ) -> NDArray[np.float64]:
        """Return the mean of each variable of the law at a condition.

        Like `std` and `quantile` it is that of 2**18 draws with keys that are always the same:
        a pure function of the condition, whose error varies slowly along angle and speed; its
        standard error is 0.002 standard deviations of the variable. A condition takes some 15 ms.

        Parameters
        ----------
        alpha1 : float or array
            Impact angle in rad from the wall, in (0, pi/2].
        speed : float or array
            Impact speed V in m/s, > 0.
        spin : array, shape (..., 3), optional
            As for `sample`: of the law over all grains of the population, and over the inertias
            about the spin that rebounds leave. All broadcast.

        Returns
        -------
        float64 array, shape (..., n_columns)
            In the order of `columns`, in the units of `sample`. Errors are those of `sample`; a
            condition outside the table counts as one draw there.
        """
        return self._of_law(alpha1, speed, spin, lambda states: states.mean(axis=0))

    def std(
        self, alpha1: ArrayLike, speed: ArrayLike, spin: ArrayLike | None = None
    ) -> NDArray[np.float64]:
        """Return the standard deviation of each variable of the law at a condition; see `mean`."""
        return self._of_law(alpha1, speed, spin, lambda states: states.std(axis=0))

    def quantile(
        self,
        p: ArrayLike,
        variable: str,
        alpha1: ArrayLike,
        speed: ArrayLike,
        spin: ArrayLike | None = None,
    ) -> NDArray[np.float64]:
        """Return quantiles of one variable of the law at a condition.

        Parameters
        ----------
        p : float or array
            Probabilities, from 0 to 1.
        variable : str
            One of `columns`.
        alpha1, speed, spin
            As for `mean`; they broadcast with each other and with `p`.

        Returns
        -------
        float64 array, shape of all broadcast
            The value that the variable stays below with probability p. The probability of the
            returned value has a standard error of sqrt(p (1 - p) / 2**18), at most 0.001.
        """
        if variable not in self.columns:
            refuse("variable", repr(variable), f"one of {', '.join(self.columns)}")
        column = self.columns.index(variable)
        probability = as_reals_up_to("p", p, 1.0)
        spins = np.asarray(0.0 if spin is None else spin)
        shapes = {"p": probability.shape, "alpha1": np.shape(alpha1), "speed": np.shape(speed)}
        shape = common_shape(shapes | {"spin": spins.shape[:-1]})
        probabilities = np.unique(probability)
        values = self._of_law(
            alpha1, speed, spin, lambda states: np.quantile(states[:, column], probabilities)
        )
        # of all probabilities at each condition, those that belong to it
        which = np.broadcast_to(np.searchsorted(probabilities, probability), shape)
        values = np.broadcast_to(values, (*shape, probabilities.size))
        return np.take_along_axis(values, which[..., None], axis=-1)[..., 0]

    def _of_law(
        self, alpha1: ArrayLike, speed: ArrayLike, spin: ArrayLike | None, reduce: Reduction
    ) -> NDArray[np.float64]:
        """Reduce the draws at each condition to some numbers."""
        given = {"alpha1": alpha1, "speed": speed} | present(spin=spin)
        call = self._call(given, "own", Keys(rng=np.random.default_rng(0)))
        codes = library.sample(self._table, call.rows, None, 1)
        self._refuse(call, codes)
        self._count(call, codes, 4)
        states = np.empty((DRAWS, len(self.columns)))
        results = []
        for k in range(call.rows.n):
            names = (name for name in ("alpha1", "speed", "spin") if name in call.rows.arrays)
            condition: dict[str, NDArray[Any]] = {name: call.at(name, k)[None] for name in names}
            condition["index"] = np.arange(DRAWS, dtype=np.uint64)
            condition["hit"] = np.zeros(1, np.uint32)
            library.sample(self._table, Rows(DRAWS, SEED, condition, False), states, None)
            results.append(reduce(states))
        tail = reduce(np.zeros((1, len(self.columns)))).shape
        return np.array(results).reshape(*call.shape, *tail)
