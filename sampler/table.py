"""A loaded table: checked input in, rebound states out."""

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sampler import library
from sampler.arguments import (
    MAX_ROUGHNESS,
    Call,
    Grain,
    Keys,
    Rebound,
    as_isotropic,
    as_output,
    as_positive,
    as_reals_up_to,
    as_threads,
    broadcast,
    check_grain_word,
)
from sampler.errors import InputError, TableError, refuse
from sampler.files import find_table
from sampler.formats.binary_layout import SPHERES
from sampler.formats.bounds import ROUNDING
from sampler.formats.hdf5 import TableContents, read_table
from sampler.formats.image import header_of, table_image
from sampler.law import LawAtConditions
from sampler.library import OpenTable
from sampler.messages import Counting, Counts, speed_limits

if TYPE_CHECKING:
    from sampler.device.device_table import DeviceTable

#: Number of states that are copied sooner than their conditions are looked at.
_SOONER_COPIED = 10_000


class Table(LawAtConditions, Counting):
    """A rebound table in memory, from `load`.

    Draws are pure functions of the condition and of the keys, so one table
    serves any number of threads. A copy of it, in another process or not, has its data and its
    settings, and counts the draws outside anew.

    Parameters
    ----------
    contents : TableContents
    outside : {"clamp", "raise"}
        What to do with an angle or speed outside the table: use the nearest that it has, count it
        in `clamped` and warn of the first (`OutsideTableWarning`), or raise `InputError`. A spin
        beyond what the table covers is drawn with as it is; all else is the same.

    Attributes
    ----------
    handle : int
        Address of the opened table, for `sampler.draw` and `sampler.rebound` in compiled code;
        valid as long as the table lives.
    columns : tuple of str
        The variables in the columns of a state: u, v, w, omega_x, omega_y, omega_z, or those of
        them (and rotational_energy, collisions, work_normal, work_shear) that the table was made
        for.
    pair, config : str
        Name of the material pair; TOML text from which the table was generated.
    has_spin : bool
        Whether the table has the law of particles that arrive spinning.
    speed_independent : bool
        Whether rebounds do not depend on the speed; then no speed lies outside.
    outside
        As it was given.
    """

    def __init__(
        self,
        contents: TableContents,
        *,
        outside: Literal["clamp", "raise"] = "clamp",
    ) -> None:
        if outside not in ("clamp", "raise"):
            refuse("outside", repr(outside), "'clamp', 'raise'")
        self.outside = outside
        self._table = OpenTable(table_image(contents))
        self.columns = contents.variables
        self.pair, self.config = contents.pair, contents.config
        self.speed_independent = contents.speed_independent
        self.has_spin = contents.has_spin
        self._small = _kept_beside(contents)
        self._source: TableContents | Path = contents
        self._counts = Counts()

    def __getstate__(self) -> dict[str, Any]:
        return self.__dict__ | {"_counts": Counts()}

    def __repr__(self) -> str:
        if self._header["flags"] & SPHERES:
            return f"<sampler.Table {self.pair}: spheres>"
        alpha, speed = self.alpha_nodes_deg, self.speed_nodes
        return (
            f"<sampler.Table {self.pair}: {alpha[0]:g} to {alpha[-1]:g} deg x "
            f"{speed[0]:g} to {speed[-1]:g} m/s, {len(alpha)} x {len(speed)} nodes, "
            f"{self._header['n_components']} mixture components>"
        )

    @property
    def handle(self) -> int:
        """Address of the opened table."""
        return self._table.handle

    @property
    def _header(self) -> Any:
        return header_of(self._table.image)

    @property
    def contents(self) -> TableContents:
        """Contents of the file; a table that was loaded reads its file again.

        Raises `TableError` if that is no longer the table that was loaded.
        """
        if isinstance(self._source, TableContents):
            return self._source
        contents = read_table(self._source)
        digest = np.frombuffer(bytes.fromhex(contents.content_sha256), np.uint8)
        if not np.array_equal(digest, self._header["content_sha256"]):
            raise TableError(f"{self._source}: was changed, allowed: the table that was loaded")
        return contents

    @property
    def alpha_nodes_deg(self) -> NDArray[np.float64]:
        """Impact angles of the nodes, degrees; of spheres, the ends of the pair's domain."""
        return self._small["axes/alpha_deg"].copy()

    @property
    def speed_nodes(self) -> NDArray[np.float64]:
        """Impact speeds of the nodes, m/s; of spheres, the ends of the pair's domain."""
        return self._small["axes/speed"].copy()

    @property
    def nbytes(self) -> int:
        """Memory that the table takes."""
        return int(self._table.image.nbytes)

    @property
    def alpha_range(self) -> tuple[float, float]:
        """Smallest and largest impact angle, rad."""
        return float(self._header["alpha_first"]), float(self._header["alpha_last"])

    @property
    def speed_range(self) -> tuple[float, float]:
        """Smallest and largest impact speed of the nodes, m/s."""
        return float(self._header["speed_first"]), float(self._header["speed_last"])

    @property
    def accuracy(self) -> dict[str, NDArray[np.float64]]:
        """Accuracy measured against direct simulation, at conditions that are no nodes.

        Keys: ``alpha_deg``, ``speed``, ``ks`` (n, n_columns), ``sliced_wasserstein``,
        ``correlation_error``, ``auc``, all (n,) but ks, which has a column for each of
        `columns`; n = 0 if nothing was measured.
        """
        paths = (path for path in self._small if path.startswith("accuracy/"))
        return {path.removeprefix("accuracy/"): self._small[path].copy() for path in paths}

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
            from the spin law, which also knows the grain. Left out, from the law of first impacts,
            of any grain: who follows particles gives zeros at their first hit.
        grain : "own", "fresh" or array, shape (..., 3)
            "own": with a spin, a particle has the same grain at every hit, drawn by (seed, index),
            as `grains` returns it. "fresh": another one at every hit, drawn by (seed, index, hit).
            An array: shape code, b/a and c/b of each, which do not spin if no spin is given.
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
        given: dict[str, ArrayLike] = {"alpha1": alpha1, "speed": speed}
        call = self._call(given, "spin", spin, grain, Keys(seed, index, hit, rng, size))
        states = as_output(out, (*call.shape, len(self.columns)))
        drawn = (
            states if out is None or self._writes_safely(call, states) else np.empty_like(states)
        )
        flat = drawn.reshape(call.rows.n, len(self.columns))
        report = library.sample(self._table, call.rows, flat, as_threads(threads))
        self._finish(self._header, call, report, 3)
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
        isotropic: bool = False,
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
            Angular velocity before the impact, rad/s, lab frame. Left out: not spinning, the same
            as zeros.
        grain : "own", "fresh" or array, shape (..., 3)
            As for `sample`. "fresh" without `omega`, as any table without a spin law: the law of
            first impacts.
        seed, index, hit, rng, size, threads
            As for `sample`.
        wall_velocity : array, shape (..., 3), optional
            Velocity of the wall at the point of contact, m/s; at rest if left out.
        roughness : float or array, shape (...), optional
            Standard deviation of the random tilt of a rough wall's normal, rad, from 0 to 0.5;
            a smooth wall if left out. `sampler.wall_tilt` gives that of a measured profile.
        isotropic : bool
            Whether it is tilted across the plane of incidence as well, as much, and not only in it.

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
        given: dict[str, ArrayLike] = {
            "velocity": velocity,
            "normal": normal,
            "half_size": half_size,
        }
        if wall_velocity is not None:
            given["wall_velocity"] = wall_velocity
        isotropic = as_isotropic(isotropic, roughness)
        if roughness is not None:
            given["roughness"] = as_reals_up_to("roughness", roughness, MAX_ROUGHNESS, " rad")
        call = self._call(given, "omega", omega, grain, Keys(seed, index, hit, rng, size))
        after = Rebound(np.empty((*call.shape, 3)), np.empty((*call.shape, 3)))
        velocity, spin = (array.reshape(call.rows.n, 3) for array in after)
        count = as_threads(threads)
        report = library.rebound(self._table, call.rows, velocity, spin, count, isotropic)
        self._finish(self._header, call, report, 3)
        return after

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
        if not self.has_spin:
            raise InputError("grains: asked for, allowed: of a table with a spin law")
        shape, rows = broadcast({}, Keys(seed, index))
        found = library.grains(self._table, rows.seed, rows.arrays["index"], rows.n)
        return found.reshape(*shape, 3)

    def mean_half_size(self, diameter: ArrayLike) -> NDArray[np.float64]:
        """Compute the mean of `sampler.half_size` over the population, m, from diameters, m.

        Raises `InputError` if the table has no spin law, or meshes, whose volume it does not hold.
        """
        mean = library.library().rbt_mean_half_size(self.handle, 1.0)
        if mean == 0.0:
            raise InputError("mean_half_size: asked for, allowed: of a spin law without meshes")
        return mean * as_positive("diameter", diameter)

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

        return DeviceTable(self, self._table.image, dtype)

    def check_spin(self, name: str, spin: Any, grain: Grain) -> None:
        """Refuse a spin or a grain that the table has no law for.

        Parameters
        ----------
        name : str
            Of the spin, for the message: "spin" or "omega".
        spin, grain
            As for `sample`.

        Raises
        ------
        InputError
            If the table has no spin law for it, or the grain is an unknown word.
        """
        check_grain_word(grain)
        given = spin is not None or not isinstance(grain, str)
        if given and not self.has_spin:
            asked = "grain" if spin is None else name
            refuse(asked, "one", "none, for the table has no spin law")

    def _call(
        self,
        given: dict[str, ArrayLike],
        name: str,
        spin: ArrayLike | None,
        grain: Grain,
        keys: Keys,
    ) -> Call:
        """Make rows of the arguments of a call, with the spin and the grain where they count."""
        self.check_spin(name, spin, grain)
        if spin is not None:
            given = given | {name: spin}
        if isinstance(grain, str):
            return broadcast(given, keys, fresh=grain == "fresh")
        call = broadcast(given | {"grain": grain}, keys)
        self._check_grains(call)
        return call

    def _check_grains(self, call: Call) -> None:
        """Refuse the first given grain that the spin law was not made for."""
        codes, ranges = self._small["spin/shape_codes"], self._small["spin/ratio_range"]
        given = call.rows.arrays["grain"]
        low, high = ranges[:, :, 0], ranges[:, :, 1]
        inside = ((given[:, None, 1:] >= low) & (given[:, None, 1:] <= high)).all(axis=2)
        refused = ~((given[:, :1] == codes) & inside).any(axis=1)
        if refused.any():
            row = int(refused.argmax())
            got = ", ".join(f"{x:.9g}" for x in given[row])
            shapes = ", ".join(str(code) for code in codes)
            allowed = f"a shape code of the table ({shapes}), and b/a and c/b that were simulated"
            refuse("grain", f"{got} at {call.place(row)}", allowed)

    def _writes_safely(self, call: Call, states: NDArray[Any]) -> bool:
        """Tell whether draws may go straight to the user's array.

        A batch writes row by row until it meets one that it refuses, so it must refuse none, and
        overwrite nothing that it has yet to read.
        """
        arrays = call.rows.arrays
        # a draw with a spin can be refused for more reasons than are looked at here
        spins = "spin" in arrays or "grain" in arrays
        if states.size <= _SOONER_COPIED or spins:
            return False
        if any(np.may_share_memory(states, values) for values in arrays.values()):
            return False
        if self.outside == "raise":
            angles, speeds = self.alpha_range, speed_limits(self._header)
        else:  # the smallest and the largest number that a draw takes
            angles = (np.nextafter(0.0, 1.0), 0.5 * np.pi + ROUNDING)
            speeds = (np.nextafter(0.0, 1.0), np.finfo(np.float64).max)
        return all(
            bool(arrays[name].min() >= low and arrays[name].max() <= high)
            for name, (low, high) in (("alpha1", angles), ("speed", speeds))
        )


def _kept_beside(contents: TableContents) -> dict[str, NDArray[Any]]:
    """Pick the datasets that a loaded table keeps: axes, measured accuracy, simulated grains."""
    kept = ("axes/", "accuracy/", "spin_accuracy/", "spin/shape_codes", "spin/ratio_range")
    return {path: contents[path] for path in contents.datasets if path.startswith(kept)}


def load(
    name_or_path: str | os.PathLike[str],
    outside: Literal["clamp", "raise"] = "clamp",
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
