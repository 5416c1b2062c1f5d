"""A loaded table: checked input in, rebound states out."""

import os
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sampler.drawing.batch import draw_batch
from sampler.drawing.frames import rebound_batch
from sampler.drawing.law import states_of_law
from sampler.drawing.roughness import MAX_ROUGHNESS, rough_rebound_batch
from sampler.drawing.spin_draw import spin_draw_batch
from sampler.drawing.spin_frames import spin_rebound_batch
from sampler.drawing.threads import Counter, merge, run_rows
from sampler.errors import InputError, OutsideTableWarning, TableError
from sampler.files.locate import find_table
from sampler.formats.hdf5 import TableContents, read_table
from sampler.formats.packing import kept_beside, table_arrays
from sampler.formats.packing_memory import repacked
from sampler.formats.table_arrays import bytes_of, same
from sampler.inputs.grains import Grain, check_grains, rows_with_grains
from sampler.inputs.messages import outside_message, outside_warning, row_message
from sampler.inputs.output import Rebound, as_output, where_to_draw
from sampler.inputs.rows import (
    Keys,
    Rows,
    as_integer,
    as_reals_up_to,
    broadcast,
    common_shape,
)


class Table:
    """A rebound table in memory.

    Make one with `load`. Draws are pure functions of the condition and of the keys, so one table
    serves any number of threads. A copy of it, in another process or not, has its arrays and its
    settings, and counts the draws outside anew.

    Parameters
    ----------
    contents : TableContents
    outside : {"clamp", "raise"}
        What to do with an angle or speed outside the table: use the nearest that it has, count it
        in `clamped` and warn of the first (`OutsideTableWarning`), or raise `InputError`.

    Attributes
    ----------
    arrays : TableArrays
        For `sampler.draw` in the user's own compiled code.
    columns : tuple of str
        The variables in the columns of a state: u, v, w, omega_x, omega_y, omega_z, or those of
        them (and rotational_energy, collisions) that the table was made for.
    pair, config : str
        Name of the material pair; TOML text from which the table was generated.
    speed_independent : bool
        Whether rebounds do not depend on the speed; then no speed lies outside.
    outside : str
    """

    def __init__(
        self, contents: TableContents, *, outside: Literal["clamp", "raise"] = "clamp"
    ) -> None:
        if outside not in ("clamp", "raise"):
            raise InputError(f"outside: got {outside!r}, allowed: 'clamp', 'raise'")
        self.outside = outside
        self.arrays = table_arrays(contents)
        self.columns = contents.variables
        self.pair, self.config = contents.pair, contents.config
        self.speed_independent = contents.speed_independent
        self._small = kept_beside(contents)
        self._source: TableContents | Path = contents
        self._clamped, self._extrapolated = Counter(), Counter()

    def __getstate__(self) -> dict[str, Any]:
        return self.__dict__ | {"_clamped": Counter(), "_extrapolated": Counter()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self.arrays = repacked(self.arrays)

    def __repr__(self) -> str:
        alpha, speed = self.alpha_nodes_deg, self.speed_nodes
        return (
            f"<sampler.Table {self.pair}: {alpha[0]:g} to {alpha[-1]:g} deg x "
            f"{speed[0]:g} to {speed[-1]:g} m/s, {len(alpha)} x {len(speed)} nodes, "
            f"{self.arrays.n_components} mixture components>"
        )

    @property
    def contents(self) -> TableContents:
        """What the file holds; a table that was loaded reads its file again.

        Raises `TableError` if that is no longer the table that was loaded.
        """
        if isinstance(self._source, TableContents):
            return self._source
        contents = read_table(self._source)
        if not same(Table(contents)._held(), self._held()):
            raise TableError(f"{self._source}: was changed, allowed: the table that was loaded")
        return contents

    def _held(self) -> tuple[Any, ...]:
        """All that was taken from the contents."""
        return self.arrays, self.pair, self.config, *self._small.values()

    @property
    def alpha_nodes_deg(self) -> NDArray[np.float64]:
        """Impact angles of the nodes, degrees."""
        return self._small["axes/alpha_deg"].copy()

    @property
    def speed_nodes(self) -> NDArray[np.float64]:
        """Impact speeds of the nodes, m/s."""
        return self._small["axes/speed"].copy()

    @property
    def nbytes(self) -> int:
        """Memory that the table takes."""
        return bytes_of((self.arrays, *self._small.values()))

    @property
    def alpha_range(self) -> tuple[float, float]:
        """Smallest and largest impact angle, rad."""
        return self.arrays.alpha.first, self.arrays.alpha.last

    @property
    def speed_range(self) -> tuple[float, float]:
        """Smallest and largest impact speed of the nodes, m/s."""
        return self.arrays.speed.first, self.arrays.speed.last

    @property
    def accuracy(self) -> dict[str, NDArray[np.float64]]:
        """What was measured against direct simulation, at conditions that are no nodes.

        Keys: ``alpha_deg``, ``speed``, ``ks`` (n, n_columns), ``sliced_wasserstein``,
        ``correlation_error``, ``auc``, all (n,) but ks, which has a column for each of
        `columns`; n = 0 if nothing was measured.
        """
        paths = (path for path in self._small if path.startswith("accuracy/"))
        return {path.removeprefix("accuracy/"): self._small[path].copy() for path in paths}

    @property
    def clamped(self) -> int:
        """How many draws so far lay outside the table and were moved to its edge."""
        return self._clamped.value

    @property
    def extrapolated(self) -> int:
        """How many draws so far had a speed at which the pair's laws are an extrapolation."""
        return self._extrapolated.value

    @property
    def has_spin(self) -> bool:
        """Whether the table has the law of particles that arrive spinning."""
        return self.arrays.spin.n_shapes > 0

    def sample(
        self,
        alpha1: ArrayLike,
        speed: ArrayLike,
        *,
        spin: ArrayLike | None = None,
        grain: Grain = "own",
        seed: int | None = None,
        index: ArrayLike | None = None,
        hit: ArrayLike | None = None,
        rng: np.random.Generator | None = None,
        size: int | tuple[int, ...] | None = None,
        threads: int | None = None,
        out: NDArray[Any] | None = None,
    ) -> NDArray[Any]:
        """Draw rebound states.

        Keys, ``seed``, ``index`` and ``hit``, give equal states in any call. A generator, ``rng``,
        gives others in each: a call takes one 64-bit number from it.

        Parameters
        ----------
        alpha1 : float or array
            Impact angle in rad from the wall, in (0, pi/2].
        speed : float or array
            Impact speed V in m/s, > 0. All arrays broadcast, as in numpy.
        spin : array, shape (..., 3), optional
            Angular velocity before the impact times a/V, in the frame of the wall. Left out, the
            particle has not spun, and no grain of its own is asked for.
        grain : "own", "fresh" or array, shape (..., 3)
            With a spin. "own": a particle has the same grain at every hit, drawn by (seed, index);
            "fresh": another one at every hit, drawn by (seed, index, hit). An array: shape code,
            b/a and c/b of each particle.
        seed : int
            Seed of the run, uint64.
        index : int or array of int
            Identity of each particle, uint64.
        hit : int or array of int, optional
            How many walls each particle has met before, uint32; 0, the first, if left out.
        rng : numpy.random.Generator
            In place of the keys. Its number becomes the seed, rows are counted by index, hit is 0.
        size : int or tuple of int, optional
            With ``rng``: shape of the result without its last axis; that of the arrays if left out.
        threads : int, optional
            Threads to use; by default as many as the number of draws is worth. The states do
            not depend on it.
        out : float64 or float32 array, shape (..., n_columns), optional
            Where to write the states; left as it was if an input is refused.

        Returns
        -------
        float64 array, shape (..., n_columns), or `out`
            The table's `columns`: u, v, w over V and omega_x, omega_y, omega_z times a/V unless
            it was made for fewer or others, in the wall frame: x along the tangential velocity
            before impact, y into the gas. Numbers in give one state, shape (n_columns,).

        Raises
        ------
        InputError
            If an input has a wrong type or shape, is not finite or not allowed (with
            ``outside="raise"`` also: outside the table). Names the first row.
        """
        keys = Keys(seed, index, hit, rng, size)
        given: dict[str, ArrayLike] = {"alpha1": alpha1, "speed": speed}
        rows, batch, extra = self._rows(given, "spin", spin, grain, keys)
        states = as_output(out, (*rows.shape, len(self.columns)))
        # a draw with a spin can be refused for more reasons than are looked at before
        drawn = states
        if out is not None:
            plain = spin is None
            drawn = (
                where_to_draw(states, rows, self.arrays, self.outside)
                if plain
                else np.empty_like(states)
            )
        results = drawn.reshape(rows.n, len(self.columns))
        self._draw(batch or draw_batch, rows, results, threads, extra=extra)
        if drawn is not states:
            states[...] = drawn
        return states

    def rebound(
        self,
        velocity: ArrayLike,
        normal: ArrayLike,
        half_size: ArrayLike,
        *,
        omega: ArrayLike | None = None,
        grain: Grain = "own",
        seed: int | None = None,
        index: ArrayLike | None = None,
        hit: ArrayLike | None = None,
        rng: np.random.Generator | None = None,
        size: int | tuple[int, ...] | None = None,
        wall_velocity: ArrayLike | None = None,
        roughness: ArrayLike | None = None,
        threads: int | None = None,
    ) -> Rebound:
        """Rebound particles from a wall, in the lab frame.

        Parameters
        ----------
        velocity : array, shape (..., 3)
            Velocity before impact, m/s.
        normal : array, shape (..., 3)
            Wall normal into the gas, of any length but zero.
        half_size : float or array, shape (...)
            Largest half-size a of the particle, m.
        omega : array, shape (..., 3), optional
            Angular velocity before the impact, rad/s, lab frame; as `spin` of `sample`.
        grain, seed, index, hit, rng, size, threads
            As for `sample`.
        wall_velocity : array, shape (..., 3), optional
            Velocity of the wall at the point of contact, m/s; at rest if left out.
        roughness : float or array, shape (...), optional
            Standard deviation of the random tilt of a rough wall's normal, rad, from 0 to 0.5;
            a smooth wall if left out. See `sampler.rough_rebound`.

        Returns
        -------
        Rebound
            ``velocity, omega``, both of shape (..., 3). At exactly normal impact the direction
            along the wall is uniform.

        Raises
        ------
        InputError
            As `sample`; also if a particle does not approach the wall or a normal is zero.
        """
        arguments: dict[str, ArrayLike] = {
            "velocity": velocity,
            "normal": normal,
            "half_size": half_size,
            "wall_velocity": np.zeros(3) if wall_velocity is None else wall_velocity,
        }
        if roughness is not None:
            arguments["roughness"] = as_reals_up_to("roughness", roughness, MAX_ROUGHNESS, " rad")
        keys = Keys(seed, index, hit, rng, size)
        rows, batch, extra = self._rows(arguments, "omega", omega, grain, keys)
        plain = rebound_batch if roughness is None else rough_rebound_batch
        results = np.empty((rows.n, 6))
        self._draw(batch or plain, rows, results, threads, extra=extra)
        parts = (results[:, :3], results[:, 3:])
        return Rebound(*(part.copy().reshape(*rows.shape, 3) for part in parts))

    def mean(self, alpha1: ArrayLike, speed: ArrayLike) -> NDArray[np.float64]:
        """Return the mean of each variable of the law at a condition.

        Like `std` and `quantile` it is that of 2**18 draws with keys that are always the same:
        a pure function of the condition, whose error varies slowly along angle and speed; its
        standard error is 0.002 standard deviations of the variable. A condition takes some 15 ms.

        Parameters
        ----------
        alpha1 : float or array
            Impact angle in rad from the wall, in (0, pi/2].
        speed : float or array
            Impact speed V in m/s, > 0. Both broadcast.

        Returns
        -------
        float64 array, shape (..., n_columns)
            In the order of `columns`, in the units of `sample`. Errors are those of `sample`; a
            condition outside the table counts as one draw there.
        """
        return self._of_law(alpha1, speed, lambda states: states.mean(axis=0))

    def std(self, alpha1: ArrayLike, speed: ArrayLike) -> NDArray[np.float64]:
        """Return the standard deviation of each variable of the law at a condition; see `mean`."""
        return self._of_law(alpha1, speed, lambda states: states.std(axis=0))

    def quantile(
        self, p: ArrayLike, variable: str, alpha1: ArrayLike, speed: ArrayLike
    ) -> NDArray[np.float64]:
        """Return quantiles of one variable of the law at a condition.

        Parameters
        ----------
        p : float or array
            Probabilities, from 0 to 1.
        variable : str
            One of `columns`.
        alpha1, speed : float or array
            As for `mean`; they broadcast with each other and with `p`.

        Returns
        -------
        float64 array, shape of all three broadcast
            What the variable stays below with probability p. The probability to stay below what is
            returned has a standard error of sqrt(p (1 - p) / 2**18), at most 0.001; see `mean`.
        """
        if variable not in self.columns:
            raise InputError(
                f"variable: got {variable!r}, allowed: one of {', '.join(self.columns)}"
            )
        column = self.columns.index(variable)
        probability = as_reals_up_to("p", p, 1.0)
        given = {"p": probability, "alpha1": np.asarray(alpha1), "speed": np.asarray(speed)}
        shape = common_shape({name: values.shape for name, values in given.items()})
        probabilities = np.unique(probability)
        found = self._of_law(
            alpha1, speed, lambda states: np.quantile(states[:, column], probabilities)
        )
        # of all probabilities at each condition, those that belong to it
        which = np.broadcast_to(np.searchsorted(probabilities, probability), shape)
        found = np.broadcast_to(found, (*shape, probabilities.size))
        return np.take_along_axis(found, which[..., None], axis=-1)[..., 0]

    def _of_law(
        self,
        alpha1: ArrayLike,
        speed: ArrayLike,
        reduce: Callable[[NDArray[np.float64]], NDArray[np.float64]],
    ) -> NDArray[np.float64]:
        """Reduce the draws at each condition to some numbers."""
        rows = broadcast({"alpha1": alpha1, "speed": speed}, Keys(seed=0, index=0))
        drawn = np.empty((rows.n, len(self.columns)))
        self._draw(draw_batch, rows, drawn, 1, stacklevel=4)  # one each, to check the conditions
        conditions = ((rows.at("alpha1", k), rows.at("speed", k)) for k in range(rows.n))
        results = [reduce(states) for states in states_of_law(self.arrays, conditions)]
        return np.array(results).reshape(*rows.shape, *reduce(np.zeros((1, drawn.shape[1]))).shape)

    def _rows(
        self,
        arguments: dict[str, ArrayLike],
        name: str,
        spin: ArrayLike | None,
        grain: Grain,
        keys: Keys,
    ) -> tuple[Rows, Callable[..., Any] | None, tuple[Any, ...]]:
        """Rows of a call; with a spin also the kernel that draws, and what it takes of grains."""
        if spin is None:
            return broadcast(arguments, keys), None, ()
        if not self.has_spin:
            raise InputError(
                f"{name}: got a spin, allowed: none, this table was made without a spin law"
            )
        rows, grains = rows_with_grains(arguments | {name: spin}, grain, keys)
        if len(grains.given):
            check_grains(self.arrays, rows, grains.given)
        batch = spin_rebound_batch if "velocity" in arguments else spin_draw_batch
        return rows, batch, tuple(grains)

    def _draw(
        self,
        batch: Callable[..., Any],
        rows: Rows,
        results: NDArray[Any],
        threads: int | None,
        stacklevel: int = 3,
        extra: tuple[Any, ...] = (),
    ) -> None:
        """Write the results of all rows; refuse the first bad row, or count what is outside."""
        if threads is not None:
            threads = as_integer("threads", threads, 1, 4096, "an integer from 1 to 4096")
        arguments = (self.arrays, *rows.values.values(), *extra, *rows.keys, results)
        report = merge(run_rows(batch, arguments, rows.n, threads), self.outside == "raise")
        if report.bad_row >= 0:
            raise InputError(row_message(rows, report.bad_row, report.code))
        self._extrapolated.add(report.extrapolated)
        if report.clamped == 0:
            return
        row = report.clamped_row
        if self.outside == "raise":
            raise InputError(outside_message(self.arrays, rows, row))
        if self._clamped.add(report.clamped):
            told = outside_warning(self.arrays, rows, row, report.clamped)
            warnings.warn(told, OutsideTableWarning, stacklevel=stacklevel)  # the line that drew


def load(
    name_or_path: str | os.PathLike[str], outside: Literal["clamp", "raise"] = "clamp"
) -> Table:
    """Load a table.

    Parameters
    ----------
    name_or_path : str or path-like
        Name of a table that comes with the package, or path of a .h5 file.
    outside : {"clamp", "raise"}
        What to do with an angle or speed outside the table; see `Table`.

    Returns
    -------
    Table

    Raises
    ------
    TableError
        If the file cannot be read as a table; says why.
    InputError
        If there is no table of that name.
    """
    path = find_table(name_or_path)
    table = Table(read_table(path), outside=outside)
    table._source = path.resolve()  # its contents would take as much memory again
    return table
