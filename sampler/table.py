"""A loaded table: checked input in, rebound states out."""

import os
import threading
import warnings
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sampler.compilation.processors import processors
from sampler.drawing.batch import draw_batch
from sampler.drawing.frames import rebound_batch
from sampler.drawing.kernel import OK
from sampler.drawing.roughness import MAX_ROUGHNESS, rough_rebound_batch
from sampler.errors import InputError, OutsideTableWarning
from sampler.files.locate import find_table
from sampler.formats.hdf5 import TableContents, read_table
from sampler.formats.packing import kept_beside, table_arrays
from sampler.formats.table_arrays import bytes_of
from sampler.inputs.coerce import (
    as_integer,
    as_keys,
    as_output,
    as_reals,
    as_seed,
    as_vectors,
    common_length,
)
from sampler.inputs.refusals import (
    draw_refusal,
    impact_condition,
    outside_refusal,
    outside_warning,
    rebound_refusal,
)

#: Draws below which a further thread costs more than it saves.
_DRAWS_PER_THREAD = 20_000


class _Report(NamedTuple):
    """What a batch kernel says of its slice; rows are -1 for none."""

    bad_row: int
    code: int
    clamped_row: int
    clamped: int


class Table:
    """A rebound table in memory.

    Make one with `load`. Draws are pure functions of the condition and of the keys, so one table
    serves any number of threads.

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
    components : tuple of str
        What the columns of a sample are: u, v, w, omega_x, omega_y, omega_z, or those of them (and
        rotational_energy, collisions) that the table was made for.
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
        self.components = contents.components
        self.pair, self.config = contents.pair, contents.config
        self.speed_independent = contents.speed_independent
        self._small = kept_beside(contents)
        self._source: TableContents | Path = contents
        self._clamped = 0
        self._lock = threading.Lock()

    def __repr__(self) -> str:
        alpha, speed = self.alpha_nodes_deg, self.speed_nodes
        return (
            f"<sampler.Table {self.pair}: {alpha[0]:g} to {alpha[-1]:g} deg x "
            f"{speed[0]:g} to {speed[-1]:g} m/s, {len(alpha)} x {len(speed)} nodes, "
            f"{self.arrays.n_components} mixture components>"
        )

    @property
    def contents(self) -> TableContents:
        """What the file holds; a table that was loaded reads its file again."""
        if isinstance(self._source, TableContents):
            return self._source
        return read_table(self._source)

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
        `components`; n = 0 if nothing was measured.
        """
        paths = (path for path in self._small if path.startswith("accuracy/"))
        return {path.removeprefix("accuracy/"): self._small[path].copy() for path in paths}

    @property
    def clamped(self) -> int:
        """How many draws so far lay outside the table and were moved to its edge."""
        return self._clamped

    def sample(
        self,
        alpha1: ArrayLike,
        speed: ArrayLike,
        *,
        seed: int,
        index: ArrayLike | None = None,
        hit: ArrayLike = 0,
        threads: int | None = None,
        out: NDArray[Any] | None = None,
    ) -> NDArray[Any]:
        """Draw rebound states.

        Parameters
        ----------
        alpha1 : float or array, shape (n,)
            Impact angle in rad from the wall, in (0, pi/2].
        speed : float or array, shape (n,)
            Impact speed V in m/s, > 0.
        seed : int
            Seed of the run, uint64.
        index : int or array of int, shape (n,), optional
            Identity of each particle, uint64; 0, 1, ..., n - 1 if left out.
        hit : int or array of int, shape (n,)
            How many walls each particle has met before, uint32.
        threads : int, optional
            Threads to use; by default as many as the number of draws is worth. The states do
            not depend on it.
        out : float64 or float32 array, shape (n, n_columns), optional
            Where to write the states.

        Returns
        -------
        float64 array, shape (n, n_columns), or `out`
            The table's `components`, u, v, w over V and omega_x, omega_y, omega_z times a/V unless
            it was made for fewer or others, in the wall frame: x along the tangential velocity
            before impact, y into the gas.

        Raises
        ------
        InputError
            If an input has a wrong type or shape, is not finite, or is outside of what is
            allowed (with ``outside="raise"`` also: outside the table). Names the first row.
        """
        rows = {"alpha1": as_reals("alpha1", alpha1), "speed": as_reals("speed", speed)}
        n, keys = _keys(rows, seed, index, hit)
        states = as_output(out, (n, len(self.components)))
        report = self._run(draw_batch, (*rows.values(), *keys, states), n, threads)
        if report.bad_row >= 0:
            raise InputError(draw_refusal(rows, report.bad_row, report.code))
        self._account(report, lambda k: {name: float(v[k % len(v)]) for name, v in rows.items()})
        return states

    def rebound(
        self,
        velocity: ArrayLike,
        normal: ArrayLike,
        half_size: ArrayLike,
        *,
        seed: int,
        index: ArrayLike | None = None,
        hit: ArrayLike = 0,
        wall_velocity: ArrayLike | None = None,
        roughness: ArrayLike | None = None,
        threads: int | None = None,
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Rebound particles from a wall, in the lab frame.

        Parameters
        ----------
        velocity : array, shape (3,) or (n, 3)
            Velocity before impact, m/s.
        normal : array, shape (3,) or (n, 3)
            Wall normal into the gas, of any length but zero.
        half_size : float or array, shape (n,)
            Largest half-size a of the particle, m.
        seed, index, hit, threads
            As for `sample`.
        wall_velocity : array, shape (3,) or (n, 3), optional
            Velocity of the wall at the point of contact, m/s; at rest if left out.
        roughness : float or array, shape (n,), optional
            Standard deviation of the random tilt of a rough wall's normal, rad, from 0 to 0.5;
            a smooth wall if left out. See `sampler.drawing.roughness`.

        Returns
        -------
        velocity, omega : float64 arrays, shape (n, 3)
            Velocity (m/s) and angular velocity (rad/s) after the rebound. At exactly normal
            impact the direction along the wall is uniform.

        Raises
        ------
        InputError
            As `sample`; also if a particle does not approach the wall or a normal is zero.
        """
        wall_velocity = np.zeros(3) if wall_velocity is None else wall_velocity
        rows = {
            "velocity": as_vectors("velocity", velocity),
            "normal": as_vectors("normal", normal),
            "half_size": as_reals("half_size", half_size),
            "wall_velocity": as_vectors("wall_velocity", wall_velocity),
        }
        batch: Callable[..., Any] = rebound_batch
        if roughness is not None:
            batch, rows["roughness"] = rough_rebound_batch, _roughness(roughness)
        n, keys = _keys(rows, seed, index, hit)
        results = np.empty((n, 6))
        report = self._run(batch, (*rows.values(), *keys, results), n, threads)
        if report.bad_row >= 0:
            raise InputError(rebound_refusal(rows, report.bad_row, report.code))
        self._account(report, lambda k: impact_condition(rows, k))
        return results[:, :3].copy(), results[:, 3:].copy()

    def _run(
        self, batch: Callable[..., Any], arguments: tuple[Any, ...], n: int, threads: int | None
    ) -> _Report:
        """Run a batch kernel over slices of the rows, and merge what the slices report."""
        if threads is None:
            worth = n // _DRAWS_PER_THREAD
            workers = min(processors(), worth) if worth > 1 else 1
        else:
            workers = as_integer("threads", threads, 1, 4096, "an integer from 1 to 4096")
        if workers == 1:
            return self._merge([_Report(*batch(self.arrays, *arguments, 0, n))])
        bounds = [n * k // workers for k in range(workers + 1)]
        with ThreadPoolExecutor(workers) as pool:
            slices = [
                pool.submit(batch, self.arrays, *arguments, start, stop)
                for start, stop in pairwise(bounds)
            ]
        return self._merge([_Report(*part.result()) for part in slices])

    def _merge(self, parts: list[_Report]) -> _Report:
        """First error and first clamped row of slices in order; an error hides what follows."""
        clamped_row = next((part.clamped_row for part in parts if part.clamped_row >= 0), -1)
        bad = next((part for part in parts if part.bad_row >= 0), None)
        if bad is not None and not (self.outside == "raise" and 0 <= clamped_row < bad.bad_row):
            return bad
        return _Report(-1, OK, clamped_row, sum(part.clamped for part in parts))

    def _account(self, report: _Report, condition: Callable[[int], dict[str, float]]) -> None:
        """Count clamped draws and warn of a table's first, or refuse the first of them."""
        if report.clamped == 0:
            return
        row = report.clamped_row
        if self.outside == "raise":
            raise InputError(outside_refusal(self.arrays, condition(row), row))
        with self._lock:
            first, self._clamped = self._clamped == 0, self._clamped + report.clamped
        if first:
            told = outside_warning(self.arrays, condition(row), row, report.clamped)
            warnings.warn(told, OutsideTableWarning, stacklevel=3)  # the line that drew


def _roughness(values: ArrayLike) -> NDArray[np.float64]:
    """Roughness of walls, within what is allowed."""
    rows = as_reals("roughness", values)
    refused = ~((rows >= 0.0) & (rows <= MAX_ROUGHNESS))
    if refused.any():
        k = int(refused.argmax())
        raise InputError(
            f"roughness: got {rows[k]:.9g} at index {k}, allowed: 0 to {MAX_ROUGHNESS:g} rad"
        )
    return rows


def _keys(
    rows: dict[str, NDArray[Any]], seed: int, index: ArrayLike | None, hit: ArrayLike
) -> tuple[int, tuple[np.uint64, NDArray[np.uint64], NDArray[np.uint32]]]:
    """Return the number of rows and the keys of their random numbers: seed, index and hit."""
    hits = as_keys("hit", hit, 32)
    if index is None:
        n = common_length(**rows, hit=hits)
        return n, (as_seed(seed), np.arange(n, dtype=np.uint64), hits)
    indices = as_keys("index", index, 64)
    return common_length(**rows, hit=hits, index=indices), (as_seed(seed), indices, hits)


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
    if outside not in ("clamp", "raise"):
        raise InputError(f"outside: got {outside!r}, allowed: 'clamp', 'raise'")
    path = find_table(name_or_path)
    table = Table(read_table(path), outside=outside)
    table._source = path.resolve()  # its contents would take as much memory again
    return table
