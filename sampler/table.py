"""A loaded table: checked input in, rebound states out."""

import copy
import os
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sampler import errors, library
from sampler.arguments import (
    Call,
    Grain,
    Keys,
    Rebound,
    as_isotropic,
    as_positive,
    as_reals_up_to,
    as_rows_of,
    as_threads,
    broadcast,
    check_grain_word,
    check_written,
    common_shape,
    present,
)
from sampler.covered import make_covered
from sampler.errors import InputError
from sampler.files import find_table
from sampler.formats.hdf5 import TableContents, read_table
from sampler.formats.image import table_image
from sampler.law import Reduction, reduced_draws
from sampler.library import OpenTable, Report
from sampler.row_codes import RowCodes

if TYPE_CHECKING:
    from sampler.device.device_table import DeviceTable


class Table:
    """A rebound table in memory, from `load`.

    Draws are pure functions of the condition and of the keys, so one table
    serves any number of threads. A copy of it, in another process or not, has its data and its
    settings, and counts the draws outside anew.

    Parameters
    ----------
    contents : TableContents
    outside : {"clamp", "raise"}
        What to do with an angle, speed or spin outside the table, or an inertia about the spin that
        the grain cannot have: draw the nearest that it has,
        count it in `counts` and warn of the first of each kind (`OutsideTableWarning`), or raise
        `InputError`.

    Attributes
    ----------
    handle : int
        Address of the opened table, for `sampler.numba`; valid as long as the table lives.
    columns : tuple of str
        The variables in the columns of a state: u, v, w, omega_x, omega_y, omega_z, or those of
        them (and rotational_energy, collisions, work_normal, work_shear) that the table was made
        for.
    pair, config, content_sha256 : str
        Name of the material pair; TOML text from which the table was generated; checksum of the
        contents of its file, hexadecimal.
    has_spin : bool
        Whether the table has the law of particles that arrive spinning.
    covered : Covered
        Angles, speeds and spins that lie inside; ``str(table.covered)`` says it. The law of first
        impacts and that of particles that spin may have different angles.
    counts : dict of int
        Numbers of draws so far: those with an ``angle``, ``speed`` or ``spin`` outside, and those
        at speeds at which the pair was not measured, ``extrapolated``.
    speed_independent : bool
        Whether rebounds do not depend on the speed; then no speed lies outside.
    alpha_nodes_deg, speed_nodes : float64 array
        Impact angles, degrees, and speeds, m/s, of the nodes; of spheres, the ends of the pair's
        domain.
    accuracy : dict of arrays
        Accuracy measured against direct simulation, at conditions that are no nodes. Keys:
        ``alpha_deg``, ``speed``, ``ks`` (n, n_columns), ``sliced_wasserstein``,
        ``correlation_error``, ``auc``, all (n,) but ks, which has a column for each of
        `columns`; n = 0 if nothing was measured.
    outside
        As it was given.
    """

    def __init__(
        self,
        contents: TableContents,
        *,
        outside: Literal["clamp", "raise"] = "clamp",
    ) -> None:
        if not isinstance(outside, str) or outside not in ("clamp", "raise"):
            raise InputError("outside", repr(outside), "'clamp', 'raise'")
        self._table = OpenTable(table_image(contents))
        self.columns = contents.variables
        self.pair, self.config = contents.pair, contents.config
        self.content_sha256 = contents.content_sha256
        self.speed_independent = contents.speed_independent
        self.has_spin = contents.has_spin
        self.alpha_nodes_deg, self.speed_nodes = contents["axes/alpha_deg"], contents["axes/speed"]
        self.accuracy = {
            path.removeprefix("accuracy/"): values
            for path, values in contents.datasets.items()
            if path.startswith("accuracy/")
        }
        low, high = contents.datasets.get("spin/alpha_range_deg", (0.0, 0.0))
        others = (float(low), float(high)) if high > 0.0 else None
        self.covered = make_covered(self._table.covered(), self.has_spin, others)
        self._codes = RowCodes(self.pair, self.covered, outside)

    def __getstate__(self) -> dict[str, Any]:
        return self.__dict__ | {"_codes": copy.copy(self._codes)}

    def __repr__(self) -> str:
        return f"<sampler.Table {self.pair}: {self.covered}>"

    @property
    def handle(self) -> int:
        """Address of the opened table."""
        return self._table.handle

    @property
    def outside(self) -> Literal["clamp", "raise"]:
        """What is done with draws outside the table."""
        return self._codes.outside

    @property
    def counts(self) -> dict[str, int]:
        """Numbers of draws so far: angle, speed or spin outside the table, extrapolated."""
        return dict(self._codes.counts)

    @property
    def nbytes(self) -> int:
        """Memory that the table takes."""
        return int(self._table.image.nbytes)

    @property
    def alpha_range(self) -> tuple[float, float]:
        """Smallest and largest impact angle, rad."""
        first, last = np.deg2rad(self.alpha_nodes_deg[[0, -1]])
        return float(first), float(last)

    @property
    def speed_range(self) -> tuple[float, float]:
        """Smallest and largest impact speed of the nodes, m/s."""
        return float(self.speed_nodes[0]), float(self.speed_nodes[-1])

    def sample(
        self,
        alpha1: ArrayLike,
        speed: ArrayLike,
        *,
        spin: ArrayLike | None = None,
        inertia: ArrayLike | None = None,
        grain: Grain = "own",
        seed: int | None = None,
        index: ArrayLike | None = None,
        hit: ArrayLike | None = None,
        rng: "np.random.Generator | None" = None,
        size: int | tuple[int, ...] | None = None,
        threads: int | None = None,
        out: NDArray[Any] | None = None,
        inertia_after: NDArray[np.float64] | None = None,
    ) -> NDArray[Any]:
        """Draw rebound states.

        Keys, ``seed``, ``index`` and ``hit``, give equal states in any call. A generator, ``rng``,
        gives others in each: a call takes one 64-bit number from it.

        Parameters
        ----------
        alpha1 : float or array
            Impact angle in rad from the wall, in (0, pi/2].
        speed : float or array
            Impact speed V in m/s, > 0. All arrays broadcast, as in numpy; those of several rows
            have the same number of dimensions.
        spin : array, shape (..., 3), optional
            Mean angular velocity before the impact times a/V, in the frame of the wall: then the
            draw is from the spin law, which also knows the grain. Left out, from the law of first
            impacts, of any grain: who follows particles gives zeros at their first hit.
        inertia : float or array, optional
            Inertia about the spin, over m a^2; the energy of rotation is that times ``|spin|^2``,
            in m V^2 / 2. Left out, or 0: not known, and drawn by the keys from those that rebounds
            leave. Without a spin it does not matter.
        grain : "own", "fresh" or array, shape (..., 3)
            "own": with a spin, a particle has the same grain at every hit, drawn by (seed, index),
            as `grains` returns it. "fresh": another one at every hit, drawn by (seed, index, hit).
            An array: shape code, b/a and c/b of each, which do not spin if no spin is given.
        seed : int
            Seed of the run, uint64.
        index : int or array of int
            Identity of each particle, uint64.
        hit : int or array of int, optional
            How many walls each particle has met before, uint32. Needed with a spin; else 0, the
            first, if left out.
        rng : numpy.random.Generator
            In place of the keys. Its number becomes the seed, rows are counted by index, hit is 0.
        size : int or tuple of int, optional
            With ``rng``: shape of the result without its last axis; that of the arrays if left out.
        threads : int, optional
            Threads to use, which change no state; by default as many as are worth their cost.
        out : float64 or float32 array, shape (..., n_columns), optional
            Where to write the states; left as it was if an input is refused.
        inertia_after : float64 array, shape (...), optional
            Where to write the inertias about the spin after the rebound; 0 by the law of first
            impacts.

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
        given = {"alpha1": alpha1, "speed": speed} | present(spin=spin, inertia=inertia)
        call = self._call(given, grain, Keys(seed, index, hit, rng, size))
        check_written("out", out, (*call.shape, len(self.columns)), np.float64, np.float32)
        check_written("inertia_after", inertia_after, call.shape, np.float64)
        count, report = as_threads(threads), None
        after = None if inertia_after is None else np.empty(call.rows.n)
        if (
            out is not None
            and spin is None  # else looking twice costs more than a copy
            and out.dtype == np.float64
            and out.flags.c_contiguous
            and not any(np.may_share_memory(out, values) for values in call.rows.arrays.values())
        ):
            states, report = out, library.sample(self._table, call.rows, None, count)
            self._codes.refuse(call, report)  # before anything is written
        else:
            states = np.empty((*call.shape, len(self.columns)))
        rows = states.reshape(call.rows.n, len(self.columns))
        report = library.sample(self._table, call.rows, rows, count, report, after)
        self._codes.refuse(call, report)
        if out is not None and out is not states:
            out[...] = states
        if inertia_after is not None and after is not None:
            inertia_after[...] = after.reshape(call.shape)
        self._codes.count(call, report, 3)
        return states if out is None else out

    def rebound(
        self,
        velocity: ArrayLike,
        normal: ArrayLike,
        half_size: ArrayLike,
        *,
        omega: ArrayLike | None = None,
        inertia: ArrayLike | None = None,
        grain: Grain = "own",
        seed: int | None = None,
        index: ArrayLike | None = None,
        hit: ArrayLike | None = None,
        rng: "np.random.Generator | None" = None,
        size: int | tuple[int, ...] | None = None,
        wall_velocity: ArrayLike | None = None,
        roughness: ArrayLike | None = None,
        isotropic: bool = False,
        threads: int | None = None,
        works: NDArray[np.float64] | None = None,
        codes: NDArray[np.intc] | None = None,
    ) -> Rebound:
        """Rebound particles from a wall, in the lab frame.

        Parameters
        ----------
        velocity : array, shape (..., 3)
            Velocity before impact, m/s.
        normal : array, shape (..., 3)
            Wall normal into the gas, of any length but zero.
        half_size : float or array, shape (...)
            Largest half-size a of the particle, 1e-9 to 100 m.
        omega : array, shape (..., 3), optional
            Mean angular velocity before the impact, rad/s, lab frame, as a rebound gives it. Left
            out: not spinning, the same as zeros.
        inertia : float or array, shape (...), optional
            Inertia about it, as a rebound gives it; left out, or 0, as for `sample`.
        grain : "own", "fresh" or array, shape (..., 3)
            As for `sample`. "fresh" without `omega`, from a smooth wall, is the law of first
            impacts, the only one of a table without a spin law, which needs it.
        seed, index, hit, rng, size, threads
            As for `sample`.
        wall_velocity : array, shape (..., 3), optional
            Velocity of the wall at the point of contact, m/s; at rest if left out.
        roughness : float or array, shape (...), optional
            Standard deviation of the random tilt of a rough wall's normal, rad, from 0 to 0.5;
            a smooth wall if left out. `sampler.wall_tilt` gives that of a measured profile.
        isotropic : bool
            Whether it is tilted across the plane of incidence as well, as much, and not only in it.
        works : float64 array, shape (..., 2), written, optional
            Energies that impulses along the normal and along the wall take, J for each kg of the
            particle, of all its bounces; of a table with ``work_normal`` and ``work_shear``.
        codes : int32 array, shape (...), written, optional
            Code of each row, of `sampler.errors`: 0, a sum of flags, or negative. Then no row is
            refused: one that cannot be drawn has NaN in place of its rebound, or where it does not
            approach the wall (`NOT_APPROACHING`) what it came with, and NaN works.

        Returns
        -------
        Rebound
            ``velocity, omega``, both of shape (..., 3), and ``inertia`` (...). At exactly normal
            impact the direction along the wall is uniform.

        Raises
        ------
        InputError
            As `sample`; also if a particle does not approach the wall or a normal is zero.
        """
        isotropic = as_isotropic(isotropic, roughness)
        given = {"velocity": velocity, "normal": normal, "half_size": half_size}
        given |= present(omega=omega, inertia=inertia)
        given |= present(wall_velocity=wall_velocity, roughness=roughness)
        call = self._call(given, grain, Keys(seed, index, hit, rng, size))
        check_written("works", works, (*call.shape, 2), np.float64)
        check_written("codes", codes, call.shape, np.intc)
        if works is not None and not {"work_normal", "work_shear"} <= {*self.columns}:
            raise InputError("works", problem=f"the table {self.pair} has no works")
        n, tails = call.rows.n, {"velocity": (3,), "omega": (3,), "inertia": ()}
        results = {name: np.empty((n, *tail)) for name, tail in tails.items()}
        if works is not None:
            results["works"] = np.empty((n, 2))
        count = as_threads(threads)
        report = library.rebound(self._table, call.rows, results, count, isotropic)
        if codes is None:
            self._codes.refuse(call, report)
        else:
            codes[...] = errors.OK if report.codes is None else report.codes.reshape(call.shape)
            refused = self._codes.refused_rows(report)
            if refused is not None and report.codes is not None:
                undrawn = refused & (report.codes != errors.NOT_APPROACHING)
                for values in results.values():
                    values[undrawn] = np.nan
                # what is not drawn is not counted
                report = Report.from_codes(np.where(refused, errors.OK, report.codes))
        if works is not None:
            works[...] = results["works"].reshape(works.shape)
        self._codes.count(call, report, 3)
        shaped = {name: results[name].reshape((*call.shape, *tail)) for name, tail in tails.items()}
        return Rebound(**shaped)

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
        return self._reduced(alpha1, speed, spin, lambda states: states.mean(axis=0))

    def std(
        self, alpha1: ArrayLike, speed: ArrayLike, spin: ArrayLike | None = None
    ) -> NDArray[np.float64]:
        """Return the standard deviation of each variable of the law at a condition; see `mean`."""
        return self._reduced(alpha1, speed, spin, lambda states: states.std(axis=0))

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
        if not isinstance(variable, str) or variable not in self.columns:
            allowed = f"one of {', '.join(self.columns)}"
            raise InputError("variable", repr(variable), allowed)
        column = self.columns.index(variable)
        probability = as_reals_up_to("p", p, 1.0)
        given = {"alpha1": alpha1, "speed": speed} | present(spin=spin)
        shapes = {name: as_rows_of(name, values).shape for name, values in given.items()}
        if spin is not None:
            shapes["spin"] = shapes["spin"][:-1]
        shape = common_shape({"p": probability.shape} | shapes)
        probabilities = np.unique(probability)
        values = self._reduced(
            alpha1, speed, spin, lambda states: np.quantile(states[:, column], probabilities)
        )
        # of all probabilities at each condition, those that belong to it
        which = np.broadcast_to(np.searchsorted(probabilities, probability), shape)
        values = np.broadcast_to(values, (*shape, probabilities.size))
        return np.take_along_axis(values, which[..., None], axis=-1)[..., 0]

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
            problem = f"the table {self.pair} has no spin law, so its particles have no grains"
            raise InputError("grains", problem=problem)
        shape, rows = broadcast({}, Keys(seed, index))
        index = rows.arrays["index"]
        return library.grains(self._table, rows.seed, index, rows.n).reshape(*shape, 3)

    def mean_half_size(self, diameter: ArrayLike) -> NDArray[np.float64]:
        """Compute the mean of `sampler.half_size` over the population, m, from diameters, m.

        Raises `InputError` if the table has no spin law, or meshes, whose volume it does not hold.
        """
        mean = library.library().rbt_mean_half_size(self.handle, 1.0)
        if mean == 0.0:
            problem = f"the table {self.pair} has no spin law, or has meshes"
            raise InputError("mean_half_size", problem=problem)
        return mean * as_positive("diameter", diameter)

    def to_device(self, dtype: Literal["float64", "float32"] = "float64") -> "DeviceTable":
        """Copy the table to the GPU that is current for CuPy, to draw from arrays that live there.

        Needs CuPy (``pip install 'rebound-tables[cuda]'``) and a GPU; raises `InputError` where one
        is missing.

        Parameters
        ----------
        dtype : {"float64", "float32"}
            Type of the numbers of all arrays that go in and come out. The arithmetic of a draw is
            the same; with float32 its result is rounded once, and takes half of the memory.

        Returns
        -------
        DeviceTable
            Its `sample` and `rebound` give the states of this table for equal keys.
        """
        from sampler.device.device_table import DeviceTable

        return DeviceTable(self, self._table.image, dtype)

    def check_spin(self, name: str, spin: Any, grain: Grain) -> None:
        """Refuse a spin ("spin" or "omega") or a grain that the table has no law for."""
        check_grain_word(grain)
        if self.has_spin:
            return
        problem = f"the table {self.pair} has no spin law"
        fresh = "" if name == "spin" else ', and give grain="fresh"'
        if spin is not None:
            raise InputError(name, problem=problem, remedy=f"leave it out{fresh}")
        if not isinstance(grain, str):
            raise InputError("grain", problem=problem, remedy=f"leave it out{fresh}")
        if fresh and grain == "own":
            remedy = 'give grain="fresh", the law of first impacts'
            raise InputError("grain", problem=problem, remedy=remedy)

    def _call(self, given: dict[str, Any], grain: Grain, keys: Keys) -> Call:
        """Make rows of the arguments of a call."""
        name = "omega" if "velocity" in given else "spin"
        self.check_spin(name, given.get(name), grain)
        if isinstance(grain, str):
            return broadcast(given, keys, fresh=grain == "fresh")
        return broadcast(given | {"grain": grain}, keys)

    def _reduced(
        self, alpha1: ArrayLike, speed: ArrayLike, spin: ArrayLike | None, reduce: Reduction
    ) -> NDArray[np.float64]:
        """Reduce the draws at each condition to some numbers."""
        given = {"alpha1": alpha1, "speed": speed} | present(spin=spin)
        call = self._call(given, "own", Keys(rng=np.random.default_rng(0)))
        report = library.sample(self._table, call.rows, None, 1)
        self._codes.refuse(call, report)
        self._codes.count(call, report, 4)
        return reduced_draws(self._table, call, len(self.columns), reduce)


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
        What to do with an angle, speed or spin outside the table; see `Table`.

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
    return Table(read_table(find_table(name_or_path)), outside=outside)
