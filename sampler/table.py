"""A loaded table, which checks its arguments and draws states and rebounds."""

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
    with_zero_spin_if_own,
    without_none,
)
from sampler.covered import make_covered
from sampler.errors import InputError
from sampler.files import find_table
from sampler.formats.hdf5 import TableContents, read_table
from sampler.formats.image import table_image
from sampler.formats.shape_geometry import Geometry
from sampler.law import Reduction, reduced_draws
from sampler.library import OpenedTable, OpenTable, Report
from sampler.row_codes import RowCodes

if TYPE_CHECKING:
    from sampler.device.device_table import DeviceTable


class Table:
    """A rebound table in memory.

    `load` makes a table from a file. A draw is a pure function of its condition and its keys, so
    any number of threads may use one table. A table may be pickled: the copy has the same data and
    settings, and counts its draws from zero.

    Parameters
    ----------
    contents : TableContents
        Contents of a table file, from `sampler.read_table`.
    outside : {"clamp", "raise"}, optional
        What to do if an impact lies outside the table, that is, if its angle, speed or spin is
        beyond the range of the table, or if the grain cannot have the given inertia. "clamp", the
        default, draws the nearest condition, counts the draw in `counts`, and warns at the first
        draw of each kind (`OutsideTableWarning`). "raise" raises `InputError`.

    Attributes
    ----------
    pair : str
        Name of the material pair.
    config : str
        TOML text of the configuration from which the table was made.
    content_sha256 : str
        Checksum of the contents of its file, hexadecimal.
    columns : tuple of str
        Names of the variables in the columns of a state: u, v, w, omega_x, omega_y and omega_z, or
        fewer. A table may also have rotational_energy, collisions, work_normal and work_shear.
    covered : Covered
        Range of angles, speeds and spins that lie inside the table; ``str(table.covered)`` writes
        it in words.
    has_spin : bool
        Whether the table has a spin law, for particles that arrive spinning.
    speed_independent : bool
        Whether rebounds do not depend on the speed. Then no speed lies outside the table.
    shape_geometry : dict
        Geometry of the shapes of its grains, by shape code, for `sampler.half_size`. It has the
        numbers of ``spin/shape_geometry`` in a file (tables/FORMAT.md).
    alpha_nodes_deg : float64 array, shape (n_alpha,)
        Impact angles of the nodes [degrees]. For spheres they are the ends of the configured range.
    speed_nodes : float64 array, shape (n_speed,)
        Impact speeds of the nodes [m/s]. For spheres they are the ends of the configured range.
    accuracy : dict of arrays
        Distances to direct simulation, measured at n conditions between the nodes. The conditions
        are ``alpha_deg`` [degrees] and ``speed`` [m/s], shape (n,). ``ks`` has the shape (n,
        n_columns), with a column for each of `columns`; ``sliced_wasserstein``,
        ``correlation_error`` and ``auc`` have the shape (n,). If nothing was measured, n is 0.
    outside : str
        The argument.
    counts : dict of int
        Number of draws so far with an ``angle``, ``speed`` or ``spin`` outside the table, and of
        those at a speed at which the pair was not measured (``extrapolated``).
    handle : int
        Address of the open table, for `sampler.numba`. It is valid as long as the table exists.
    nbytes : int
        Memory of the table [bytes].

    Raises
    ------
    InputError
        If `outside` is another word.

    Examples
    --------
    >>> import sampler
    >>> table = sampler.load("corundum-steel-compact")
    >>> print(table.covered)
    0.05 to 90 deg, 5 to 300 m/s, spin to 10
    """

    def __init__(
        self,
        contents: TableContents,
        *,
        outside: Literal["clamp", "raise"] = "clamp",
    ) -> None:
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
        self.shape_geometry = _geometry_by_code(contents)
        low, high = contents.datasets.get("spin/alpha_range_deg", (0.0, 0.0))
        others = (float(low), float(high)) if high > 0.0 else None
        image = table_image(contents)
        self.nbytes = int(image.nbytes)
        self._open(OpenTable(image), outside, others)

    def _open(
        self,
        opened: OpenedTable,
        outside: Literal["clamp", "raise"],
        spin_alpha_deg: tuple[float, float] | None = None,
    ) -> None:
        """Take what the library has opened, and its range."""
        if not isinstance(outside, str) or outside not in ("clamp", "raise"):
            raise InputError("outside", repr(outside), "'clamp', 'raise'")
        self._table = opened
        self.covered = make_covered(opened.covered(), self.has_spin, spin_alpha_deg)
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
        """What is done with draws outside the table, "clamp" or "raise"."""
        return self._codes.outside

    @property
    def counts(self) -> dict[str, int]:
        """Numbers of draws so far, with an angle, a speed or a spin outside, and extrapolated."""
        return dict(self._codes.counts)

    def sample(
        self,
        alpha1: ArrayLike,
        speed: ArrayLike,
        *,
        spin: ArrayLike | None = None,
        inertia: ArrayLike | None = None,
        grain: Grain | None = None,
        seed: int | None = None,
        index: ArrayLike | None = None,
        hit: ArrayLike | None = None,
        rng: "np.random.Generator | None" = None,
        size: int | tuple[int, ...] | None = None,
        threads: int | None = None,
        out: NDArray[Any] | None = None,
        inertia_after: NDArray[np.float64] | None = None,
    ) -> NDArray[Any]:
        """Draw the states of particles after a rebound, in the frame of the wall.

        The random numbers come from keys or from a generator. With the keys `seed`, `index` and
        `hit`, equal keys give equal states in every call. With the generator `rng`, each call gives
        other states.

        Parameters
        ----------
        alpha1 : float or array, shape (...)
            Impact angle from the wall [rad], above 0 and at most pi/2. All arguments broadcast as
            in numpy, but arrays with several rows must have the same number of dimensions.
        speed : float or array, shape (...)
            Impact speed V [m/s], above 0.
        spin : array, shape (..., 3), optional
            Mean angular velocity before the impact times a/V, in the frame of the wall. If it is
            given, even as zeros, the draw is from the spin law, in which each particle has a grain
            of its own. Otherwise the draw is from the law of first impacts, which holds for random
            grains. To follow particles from wall to wall, give zeros or ``grain="own"`` at their
            first hit.
        inertia : float or array, shape (...), optional
            Inertia k about the spin over m a^2; the rotational energy is ``k |spin|^2`` in units of
            m V^2 / 2. With 0, the default, it is not known, and the keys draw it from the inertias
            that rebounds leave. Without a spin it has no effect.
        grain : {"own", "fresh"} or array, shape (..., 3), optional
            Grain of each particle. With "own" a particle has the same grain at every hit, drawn by
            (seed, index), as `grains` returns it. With "fresh" it has another grain at every hit,
            drawn by (seed, index, hit). An array has the shape code, b/a and c/b of each grain. By
            default it is "own" with a spin; without one the draw is from the law of first impacts,
            which is that of fresh grains. Own grains, and those of an array, arrive at rest if
            `spin` is not given.
        seed : int
            Seed of the run, 0 to 2**64 - 1.
        index : int or array of int, shape (...)
            Identity of each particle, 0 to 2**64 - 1.
        hit : int or array of int, shape (...), optional
            Number of walls that each particle has met before, 0 to 2**32 - 1. It is required with a
            spin; otherwise it is 0 by default.
        rng : numpy.random.Generator, optional
            Generator to use instead of the keys. It gives one 64-bit number, which becomes the
            seed. The rows are counted by index, and hit is 0.
        size : int or tuple of int, optional
            With `rng`, the shape of the result without its last axis. By default it is the shape to
            which the arguments broadcast.
        threads : int, optional
            Number of threads, which does not change the states. By default the call chooses it.
        out : float64 or float32 array, shape (..., n_columns), optional
            Array to which the states are written. If an input is refused, it stays as it was.
        inertia_after : float64 array, shape (...), optional
            Array to which the inertias about the spin after the rebound are written. The law of
            first impacts writes 0.

        Returns
        -------
        float64 array, shape (..., n_columns), or `out`
            States, with the variables of `columns`: velocities over V, and angular velocities times
            a/V. The x axis lies along the tangential velocity before the impact, and the y axis
            points into the gas. If all arguments are numbers, the shape is (n_columns,).

        Raises
        ------
        InputError
            If an argument has a wrong type or shape, is not finite, or has a value that is not
            allowed. With ``outside="raise"`` also if an impact lies outside the table. The message
            names the first row.

        Notes
        -----
        tables/FORMAT.md describes the draw step by step.

        Examples
        --------
        >>> import numpy as np
        >>> import sampler
        >>> table = sampler.load("corundum-steel-compact")
        >>> states = table.sample(np.radians(30.0), 150.0, seed=7, index=np.arange(1000))
        >>> states.shape
        (1000, 6)
        >>> bool((states[:, 1] > 0.0).all())  # v: every particle leaves the wall
        True
        """
        given = {"alpha1": alpha1, "speed": speed} | without_none(spin=spin, inertia=inertia)
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
            Velocity before the impact [m/s].
        normal : array, shape (..., 3)
            Normal of the wall, from the wall into the gas, of any length but zero.
        half_size : float or array, shape (...)
            Half of the longest dimension of the particle, a [m], 1e-9 to 100.
        omega : array, shape (..., 3), optional
            Mean angular velocity before the impact [rad/s], as a rebound returns it. By default
            particles do not spin, as with zeros.
        inertia : float or array, shape (...), optional
            Inertia about ``omega`` over m a^2, as a rebound returns it. With 0, the default, it is
            not known, as for `sample`.
        grain : {"own", "fresh"} or array, shape (..., 3), optional
            As for `sample`. With "fresh", a smooth wall and no `omega`, the draw is from the law of
            first impacts. A table without a spin law allows nothing else.
        seed, index, hit, rng, size, threads
            As for `sample`. If `omega` is given, `hit` is required.
        wall_velocity : array, shape (..., 3), optional
            Velocity of the wall at the point of contact [m/s]. By default the wall is at rest.
        roughness : float or array, shape (...), optional
            Standard deviation of the random tilt of a rough wall's normal [rad], 0 to 0.5;
            `sampler.wall_tilt` computes it from a measured profile. By default the wall is smooth.
        isotropic : bool, optional
            Whether the normal is also tilted across the plane of incidence, with the same standard
            deviation. By default it is tilted in the plane of incidence only.
        works : float64 array, shape (..., 2), optional
            Array to which the energies are written that impulses along the normal and along the
            wall take [J for each kg of the particle], summed over all bounces from a rough wall.
            The table needs ``work_normal`` and ``work_shear``.
        codes : int32 array, shape (...), optional
            Array to which the code of each row is written: 0, a sum of flags, or an error below 0
            (`sampler.errors`). Then no row raises an error. A row that cannot be drawn gets NaN,
            but a particle that moves away from the wall (`NOT_APPROACHING`) keeps its velocity,
            spin and inertia, and gets NaN for works only.

        Returns
        -------
        Rebound
            Named tuple with the fields ``velocity`` [m/s] and ``omega`` [rad/s], shape (..., 3),
            and ``inertia`` over m a^2, shape (...).

        Raises
        ------
        InputError
            As for `sample`. Without `codes` also if a particle does not approach the wall, or if a
            normal is zero.

        Notes
        -----
        At exactly normal impact the tangential velocity has no direction, so the keys draw one.

        Examples
        --------
        >>> import sampler
        >>> table = sampler.load("corundum-steel-compact")
        >>> keys = {"seed": 7, "index": 0}
        >>> first = table.rebound([160.0, -60.0, 0.0], [0.0, 1.0, 0.0], 2e-5, hit=0, **keys)
        >>> second = table.rebound(
        ...     first.velocity,
        ...     [0.0, -1.0, 0.0],
        ...     2e-5,
        ...     omega=first.omega,
        ...     inertia=first.inertia,
        ...     hit=1,
        ...     **keys,
        ... )
        >>> bool(second.velocity[1] < 0.0)  # away from the second wall
        True
        """
        isotropic = as_isotropic(isotropic, roughness)
        given = {"velocity": velocity, "normal": normal, "half_size": half_size}
        given |= without_none(omega=omega, inertia=inertia)
        given |= without_none(wall_velocity=wall_velocity, roughness=roughness)
        call = self._call(given, grain, Keys(seed, index, hit, rng, size))
        check_written("works", works, (*call.shape, 2), np.float64)
        check_written("codes", codes, call.shape, np.intc)
        if works is not None and not self._table.has_works():
            problem = f"the table {self.pair} does not store works"
            remedy = "take one that does, as corundum-steel-wear"
            raise InputError("works", problem=problem, remedy=remedy)
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
        """Compute the mean of each variable of a rebound at a condition.

        Parameters
        ----------
        alpha1 : float or array, shape (...)
            Impact angle from the wall [rad], above 0 and at most pi/2.
        speed : float or array, shape (...)
            Impact speed V [m/s], above 0.
        spin : array, shape (..., 3), optional
            Spin before the impact, as for `sample`. The mean is then over all grains of the
            population, and over the inertias about the spin that rebounds leave.

        Returns
        -------
        float64 array, shape (..., n_columns)
            Means in the order of `columns`, in the units of `sample`.

        Raises
        ------
        InputError
            As for `sample`.

        Notes
        -----
        The mean is that of 2**18 draws with fixed keys, so equal arguments give equal results, and
        the error varies slowly with angle and speed. Its standard error is 0.002 standard
        deviations of the variable. A condition takes tens of milliseconds. In `counts`, a condition
        outside the table counts as one draw.

        Examples
        --------
        >>> import numpy as np
        >>> import sampler
        >>> table = sampler.load("corundum-steel-compact")
        >>> u, v, *_ = table.mean(np.radians(60.0), 200.0)
        >>> print(f"{u:.2f} {v:.2f}")
        0.23 0.16
        """
        return self._reduced(alpha1, speed, spin, lambda states: states.mean(axis=0))

    def std(
        self, alpha1: ArrayLike, speed: ArrayLike, spin: ArrayLike | None = None
    ) -> NDArray[np.float64]:
        """Compute the standard deviation of each variable of a rebound at a condition.

        The arguments, the shape of the result and the errors are those of `mean`.
        """
        return self._reduced(alpha1, speed, spin, lambda states: states.std(axis=0))

    def quantile(
        self,
        p: ArrayLike,
        variable: str,
        alpha1: ArrayLike,
        speed: ArrayLike,
        spin: ArrayLike | None = None,
    ) -> NDArray[np.float64]:
        """Compute quantiles of one variable of a rebound at a condition.

        Parameters
        ----------
        p : float or array, shape (...)
            Probabilities, 0 to 1.
        variable : str
            One of `columns`.
        alpha1, speed, spin
            As for `mean`. They broadcast with each other and with `p`.

        Returns
        -------
        float64 array, shape (...)
            Value below which the variable lies with the probability p.

        Raises
        ------
        InputError
            As for `sample`, or if there is no such variable.

        Notes
        -----
        Like `mean`, a quantile is that of 2**18 draws. The probability that belongs to the returned
        value has a standard error of ``sqrt(p (1 - p) / 2**18)``, which is at most 0.001.
        """
        if not isinstance(variable, str) or variable not in self.columns:
            allowed = f"one of {', '.join(self.columns)}"
            raise InputError("variable", repr(variable), allowed)
        column = self.columns.index(variable)
        probability = as_reals_up_to("p", p, 1.0)
        given = {"alpha1": alpha1, "speed": speed} | without_none(spin=spin)
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
        """Return the grains that particles keep from wall to wall.

        Parameters
        ----------
        seed : int
            Seed of the run, 0 to 2**64 - 1.
        index : int or array of int, shape (...)
            Identity of each particle, 0 to 2**64 - 1.

        Returns
        -------
        float64 array, shape (..., 3)
            Shape code, b/a and c/b. The shape codes are those of `sampler.formats.shape_codes`;
            64 + k is mesh number k of the population.

        Raises
        ------
        InputError
            If the table has no spin law, or if a key has a wrong type or value.

        Notes
        -----
        `tablegen.DirectModel` gives the same grains for the same keys and population.

        Examples
        --------
        >>> import sampler
        >>> table = sampler.load("corundum-steel-compact")
        >>> code, b_a, c_b = table.grains(seed=7, index=0)
        >>> bool(0.5 <= b_a <= 1.0)
        True
        """
        if not self.has_spin:
            problem = f"the table {self.pair} has no spin law, so its particles have no grains"
            raise InputError("grains", problem=problem)
        shape, rows = broadcast({}, Keys(seed, index))
        index = rows.arrays["index"]
        return library.grains(self._table, rows.seed, index, rows.n).reshape(*shape, 3)

    def mean_half_size(self, diameter: ArrayLike) -> NDArray[np.float64]:
        """Compute the mean of `sampler.half_size` over the grains of the table.

        Parameters
        ----------
        diameter : float or array, shape (...)
            Diameter of the sphere that has the volume of the particle [m].

        Returns
        -------
        float64 array, shape (...)
            Mean of the largest half-size a [m].

        Raises
        ------
        InputError
            If a diameter is not positive, or if the table has no spin law.
        """
        if not self.has_spin:
            problem = f"the table {self.pair} has no spin law, so its particles have no grains"
            raise InputError("mean_half_size", problem=problem)
        mean = library.library().rbt_mean_half_size(self.handle, 1.0)
        return mean * as_positive("diameter", diameter)

    def to_device(self, dtype: Literal["float64", "float32"] = "float64") -> "DeviceTable":
        """Copy the table to a GPU, to draw from arrays that live there.

        Parameters
        ----------
        dtype : {"float64", "float32"}, optional
            Type of all arrays that go in and come out. The arithmetic of a draw is the same; with
            "float32" the results are rounded once, and take half of the memory.

        Returns
        -------
        DeviceTable
            Table whose `sample` and `rebound` give the states of this table for equal keys. It
            lives on the GPU that is current for CuPy.

        Raises
        ------
        InputError
            If CuPy or a GPU is missing. ``pip install 'rebound-tables[cuda]'`` installs CuPy.
        """
        from sampler.device.device_table import DeviceTable

        if not isinstance(self._table, OpenTable):
            problem = "direct simulation does not run on a GPU"
            raise InputError("to_device", problem=problem, remedy="load a table")
        return DeviceTable(self, self._table.image, dtype)

    def check_spin(self, name: str, spin: Any, grain: Grain | None) -> None:
        """Refuse a spin (named "spin" or "omega") or a grain for which the table has no law."""
        check_grain_word(grain)
        if self.has_spin:
            return
        problem = f"the table {self.pair} has no spin law"
        fresh = "" if name == "spin" else ', and give grain="fresh"'
        if spin is not None:
            raise InputError(name, problem=problem, remedy=f"leave it out{fresh}")
        if grain is not None and not isinstance(grain, str):
            raise InputError("grain", problem=problem, remedy=f"leave it out{fresh}")
        if grain == "own":
            remedy = 'give grain="fresh", the law of first impacts'
            raise InputError("grain", problem=problem, remedy=remedy)

    def _call(self, given: dict[str, Any], grain: Grain | None, keys: Keys) -> Call:
        """Make rows of the arguments of a call."""
        name = "omega" if "velocity" in given else "spin"
        self.check_spin(name, given.get(name), grain)
        if grain is None or isinstance(grain, str):
            return broadcast(with_zero_spin_if_own(given, grain), keys, fresh=grain == "fresh")
        return broadcast(given | {"grain": grain}, keys)

    def _reduced(
        self, alpha1: ArrayLike, speed: ArrayLike, spin: ArrayLike | None, reduce: Reduction
    ) -> NDArray[np.float64]:
        """Reduce the draws at each condition to some numbers."""
        given = {"alpha1": alpha1, "speed": speed} | without_none(spin=spin)
        call = self._call(given, None, Keys(rng=np.random.default_rng(0)))
        report = library.sample(self._table, call.rows, None, 1)
        self._codes.refuse(call, report)
        self._codes.count(call, report, 4)
        return reduced_draws(self._table, call, len(self.columns), reduce)


def _geometry_by_code(contents: TableContents) -> dict[int, Geometry]:
    """Pair the codes of the shapes that grains have with their geometries."""
    if not contents.has_spin:
        return {}
    rows = zip(
        contents["spin/shape_codes"].tolist(),
        contents["spin/shape_weights"].tolist(),
        contents["spin/shape_geometry"].tolist(),
        strict=True,
    )
    return {code: Geometry(*numbers) for code, weight, numbers in rows if weight > 0.0}


def load(
    name_or_path: str | os.PathLike[str],
    outside: Literal["clamp", "raise"] = "clamp",
) -> Table:
    """Load a rebound table.

    Parameters
    ----------
    name_or_path : str or path-like
        Name of a table that comes with the package, or path of a .h5 file.
    outside : {"clamp", "raise"}, optional
        What to do with impacts outside the table; see `Table`.

    Returns
    -------
    Table

    Raises
    ------
    TableError
        If the file cannot be used as a table. The message says why.
    InputError
        If there is no such table, or if `outside` is another word.

    Examples
    --------
    >>> import sampler
    >>> sampler.load("corundum-steel")
    <sampler.Table corundum-steel: 0.05 to 90 deg, 5 to 300 m/s, spin to 10>
    """
    return Table(read_table(find_table(name_or_path)), outside=outside)
