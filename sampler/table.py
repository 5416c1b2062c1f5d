"""A loaded table: checked input in, rebound states out."""

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sampler.arguments import (
    MAX_ROUGHNESS,
    Grain,
    Grains,
    Keys,
    Rebound,
    Rows,
    as_integer,
    as_output,
    as_reals_up_to,
    grains_of,
    rows_of_call,
    where_to_draw,
)
from sampler.drawing.batch import draw_batch
from sampler.drawing.frames import rebound_batch
from sampler.drawing.rough_batch import WITHOUT_SPIN, rough_rebound_batch
from sampler.drawing.spin_draw import spin_draw_batch
from sampler.drawing.spin_frames import spin_rebound_batch
from sampler.drawing.threads import merge, run_rows
from sampler.errors import InputError, TableError
from sampler.files import find_table
from sampler.formats.bounds import same
from sampler.formats.hdf5 import TableContents, read_table
from sampler.formats.image import kept_beside, table_arrays
from sampler.formats.packing_memory import repacked
from sampler.formats.spin_buffer import law_in
from sampler.inputs.counts import Counting, Counts
from sampler.inputs.table_facts import TableFacts
from sampler.law import LawAtConditions, Reduction, states_of_law
from sampler.messages import row_message
from sampler.population import with_population

if TYPE_CHECKING:
    from sampler.device.device_table import DeviceTable


class Table(LawAtConditions, TableFacts, Counting):
    """A rebound table in memory, from `load`.

    Draws are pure functions of the condition and of the keys, so one table
    serves any number of threads. A copy of it, in another process or not, has its arrays and its
    settings, and counts the draws outside anew.

    Parameters
    ----------
    contents : TableContents
    outside : {"clamp", "raise"}
        What to do with an angle or speed outside the table: use the nearest that it has, count it
        in `clamped` and warn of the first (`OutsideTableWarning`), or raise `InputError`.
    population : mapping, optional
        Other particles than those that the table was generated for; see `load`.

    Attributes
    ----------
    arrays : TableArrays
        For `sampler.draw` in the user's own compiled code.
    columns : tuple of str
        The variables in the columns of a state: u, v, w, omega_x, omega_y, omega_z, or those of
        them (and rotational_energy, collisions, work_normal, work_shear) that the table was made
        for.
    pair, config : str
        Name of the material pair; TOML text from which the table was generated.
    speed_independent : bool
        Whether rebounds do not depend on the speed; then no speed lies outside.
    outside, population
        As they were given.
    """

    def __init__(
        self,
        contents: TableContents,
        *,
        outside: Literal["clamp", "raise"] = "clamp",
        population: Mapping[str, Any] | None = None,
    ) -> None:
        if outside not in ("clamp", "raise"):
            raise InputError(f"outside: got {outside!r}, allowed: 'clamp', 'raise'")
        self.outside = outside
        self.arrays = with_population(table_arrays(contents), contents, population)
        self.population = population
        self.columns = contents.variables
        self.pair, self.config = contents.pair, contents.config
        self.speed_independent = contents.speed_independent
        self._small = kept_beside(contents)
        self._source: TableContents | Path = contents
        self._counts = Counts()

    def __getstate__(self) -> dict[str, Any]:
        return self.__dict__ | {"_counts": Counts()}

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
        if not same(Table(contents, population=self.population)._held(), self._held()):
            raise TableError(f"{self._source}: was changed, allowed: the table that was loaded")
        return contents

    def _held(self) -> tuple[Any, ...]:
        """All that was taken from the contents."""
        return self.arrays, self.pair, self.config, *self._small.values()

    @property
    def has_spin(self) -> bool:
        """Whether the table has the law of particles that arrive spinning."""
        return law_in(self.arrays).n_shapes > 0

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
            Angular velocity before the impact times a/V, in the frame of the wall: then the draw is
            from the spin law, which also knows the grain. Left out, from the law of particles that
            arrive without spin, of any grain: who follows particles gives zeros at their first hit.
        grain : "own", "fresh" or array, shape (..., 3)
            "own": with a spin, a particle has the same grain at every hit, drawn by (seed, index),
            as `grains` returns it. "fresh": another one at every hit, drawn by (seed, index, hit).
            An array: shape code, b/a and c/b of each. The last two without a spin: a spin of zeros.
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
        rows, grains = rows_of_call(self.arrays, given, "spin", spin, grain, keys)
        states = as_output(out, (*rows.shape, len(self.columns)))
        drawn, batch = states, draw_batch if grains is None else spin_draw_batch
        if out is not None:
            drawn = where_to_draw(states, rows, self.arrays, self.outside)
        self._draw(batch, rows, drawn.reshape(rows.n, len(self.columns)), threads, grains)
        if drawn is not states:
            states[...] = drawn
        return states

    def grains(self, seed: int, index: ArrayLike) -> NDArray[np.float64]:
        """Give the grains that particles keep.

        Parameters
        ----------
        seed, index
            As for `sample`.

        Returns
        -------
        float64 array, shape (..., 3)
            Shape code of `sampler.formats.shape_codes` (``FIRST_MESH`` + k: mesh number k of the
            table's population), b/a and c/b; those of `tablegen.DirectModel` for these keys.

        Raises
        ------
        InputError
            If the table has no spin law, or as `sample`.
        """
        return grains_of(self.arrays, seed, index)

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
            a smooth wall if left out. See `sampler.rough_rebound`, and `sampler.wall_tilt` for
            that of a measured profile.

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
        rows, grains = rows_of_call(self.arrays, arguments, "omega", omega, grain, keys)
        results = np.empty((rows.n, 6))
        smooth = rebound_batch if grains is None else spin_rebound_batch
        if roughness is None:
            self._draw(smooth, rows, results, threads, grains)
        else:
            self._draw(rough_rebound_batch, rows, results, threads, grains or WITHOUT_SPIN)
        parts = (results[:, :3], results[:, 3:])
        return Rebound(*(part.copy().reshape(*rows.shape, 3) for part in parts))

    def to_device(self, dtype: Literal["float64", "float32"] = "float64") -> "DeviceTable":
        """Copy the table to a GPU, for draws from and to arrays that live there.

        Needs CuPy (``pip install 'rebound-tables[cuda]'``) and a GPU. The device is the one that is
        current for CuPy.

        Parameters
        ----------
        dtype : {"float64", "float32"}
            Type of the numbers of all arrays that go in and come out. The arithmetic of a draw is
            the same; with float32 its result is rounded once, and takes half of the memory.

        Returns
        -------
        DeviceTable
            Its `sample` and `rebound` give the states of this table for equal keys.

        Raises
        ------
        InputError
            If CuPy or a GPU is missing; says what to install.
        """
        from sampler.device.device_table import DeviceTable
        from sampler.formats.image import binary_table

        return DeviceTable(
            binary_table(self.contents, self.arrays), self.arrays, self.columns, self.outside, dtype
        )

    def _of_law(
        self, alpha1: ArrayLike, speed: ArrayLike, spin: ArrayLike | None, reduce: Reduction
    ) -> NDArray[np.float64]:
        """Reduce the draws at each condition to some numbers."""
        given: dict[str, ArrayLike] = {"alpha1": alpha1, "speed": speed}
        rows, grains = rows_of_call(self.arrays, given, "spin", spin, "own", Keys(seed=0, index=0))
        drawn = np.empty((rows.n, len(self.columns)))
        batch = draw_batch if grains is None else spin_draw_batch
        self._draw(batch, rows, drawn, 1, grains, 4)  # one each, to check the conditions
        conditions = (tuple(rows.at(name, k) for name in rows.values) for k in range(rows.n))
        results = [reduce(states) for states in states_of_law(self.arrays, conditions)]
        return np.array(results).reshape(*rows.shape, *reduce(np.zeros((1, drawn.shape[1]))).shape)

    def _draw(
        self,
        batch: Callable[..., Any],
        rows: Rows,
        results: NDArray[Any],
        threads: int | None,
        grains: Grains | tuple[None, ...] | None = None,
        stacklevel: int = 3,
    ) -> None:
        """Write the results of all rows; refuse the first bad row, or count what is outside."""
        if threads is not None:
            threads = as_integer("threads", threads, 1, 4096, "an integer from 1 to 4096")
        arguments = (self.arrays, *rows.values.values(), *(grains or ()), *rows.keys, results)
        report = merge(run_rows(batch, arguments, rows.n, threads), self.outside == "raise")
        if report.bad_row >= 0:
            raise InputError(row_message(rows, report.bad_row, report.code))
        self._counts.add(self.arrays, rows, report, self.outside, stacklevel + 1)


def load(
    name_or_path: str | os.PathLike[str],
    outside: Literal["clamp", "raise"] = "clamp",
    population: Mapping[str, Any] | None = None,
) -> Table:
    """Load a table.

    Parameters
    ----------
    name_or_path : str or path-like
        Name of a table that comes with the package, or path of a .h5 file.
    outside : {"clamp", "raise"}
        What to do with an angle or speed outside the table; see `Table`.
    population : mapping, optional
        Other particles, within what was simulated; the table needs a spin law. ``shapes``: weights
        by name, only their ratios matter; ``meshes``: a list of weights, in the table's order;
        ``aspect``: the law of b/a and c/b, {"distribution": "truncated-normal", "mean": 0.8,
        "standard_deviation": 0.2, "range": [0.5, 1.0]} or {"distribution": "fixed", "values":
        [0.8, 0.7]}. What is left out is as in the table; shapes that are not named have no weight.
        Then all draws are from the spin law, those without a spin at spin zero.

    Returns
    -------
    Table

    Raises
    ------
    TableError
        If the file cannot be read as a table; says why.
    InputError
        If there is no table of that name, or it has no such population.
    """
    path = find_table(name_or_path)
    table = Table(read_table(path), outside=outside, population=population)
    table._source = path.resolve()  # its contents would take as much memory again
    return table
