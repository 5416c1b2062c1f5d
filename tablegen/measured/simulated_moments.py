"""Direct simulation of what was measured: means and spreads at given impact conditions."""

import math
from collections.abc import Sequence
from dataclasses import fields
from functools import reduce
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from sampler.arguments import MAX_ROUGHNESS, as_reals
from sampler.errors import InputError
from tablegen.config.config import ModelSettings
from tablegen.config.pairs import MaterialPair
from tablegen.config.population import Population
from tablegen.measured.strata import (
    CentralMoments,
    SimulatedMoments,
    Strata,
    central_moments,
    merged,
    variables_of,
)
from tablegen.model.float_array import FloatArray
from tablegen.model.model_bounds import as_number, told
from tablegen.progress import bar
from tablegen.simulation.batches import batches
from tablegen.simulation.direct import DirectModel
from tablegen.simulation.simulate import check_impact_angle, check_run
from tablegen.tasks.side_by_side import side_by_side

#: Most particles of a shape at a condition, and most conditions: the keys have room for them.
_MOST_PARTICLES = 2**32 - 1
_MOST_ROWS = 2**16

#: Largest standard deviation of the tilt of facets.
MOST_TILT_DEG = math.degrees(MAX_ROUGHNESS)


class _Piece(NamedTuple):
    """Particles of one shape at one condition."""

    row: int
    stratum: int
    part: slice


class _Wall(NamedTuple):
    """What a particle meets, and with what spin."""

    #: Standard deviation of the tilt of facets [rad].
    roughness: float
    #: Spin before the impact times a/V, (3,).
    spin: FloatArray


def _checked_conditions(
    alpha_deg: ArrayLike, speed: ArrayLike
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Angles in degrees and in rad, and speeds, all of shape (n,)."""
    degrees, speeds = as_reals("alpha_deg", alpha_deg), as_reals("speed", speed)
    try:
        degrees, speeds = np.broadcast_arrays(np.atleast_1d(degrees), speeds)
    except ValueError:
        allowed = f"one that broadcasts with {degrees.shape}"
        raise InputError(f"speed: got shape {speeds.shape}, allowed: {allowed}") from None
    if degrees.ndim != 1 or not 0 < degrees.size <= _MOST_ROWS:
        allowed = f"(n,), n from 1 to {_MOST_ROWS}"
        raise InputError(f"alpha_deg: got shape {degrees.shape}, allowed: {allowed}")
    alpha = np.array([check_impact_angle(a, "alpha_deg") for a in np.radians(degrees)])
    return degrees, alpha, speeds


def _checked_wall(wall_tilt_deg: float, spin: ArrayLike | None) -> _Wall:
    """Put the tilt of facets and the spin in the form that the model takes."""
    tilt = as_number(wall_tilt_deg)
    if not 0.0 <= tilt <= MOST_TILT_DEG:
        allowed = f"0 to {MOST_TILT_DEG:.4g} degrees"
        raise InputError(f"wall_tilt_deg: got {told(wall_tilt_deg)}, allowed: {allowed}")
    numbers = as_reals("spin", np.zeros(3) if spin is None else spin)
    if numbers.shape != (3,):
        raise InputError(f"spin: got shape {numbers.shape}, allowed: (3,)")
    return _Wall(min(math.radians(tilt), MAX_ROUGHNESS), numbers)


def _stacked(parts: Sequence[CentralMoments], shape: tuple[int, int]) -> CentralMoments:
    """Moments of all rows and strata as arrays of shape (n, s, ...)."""
    names = [field.name for field in fields(CentralMoments) if field.name != "count"]
    arrays = {name: np.array([getattr(part, name) for part in parts]) for name in names}
    return CentralMoments(
        count=parts[0].count,
        **{name: array.reshape(*shape, *array.shape[1:]) for name, array in arrays.items()},
    )


class SimulatedRows:
    """Rebounds of each shape of a population at each of some impact conditions, its rows.

    Common random numbers: a particle is keyed by (seed, row, shape, number) whatever the laws, the
    ratios and the weights, so moments change smoothly with them. A shape has as many particles
    whatever its weight, so that raw moments are exactly linear in the weights.

    Parameters
    ----------
    pair : MaterialPair
        Laws of restitution and of resistance.
    population : Population
        Shapes and aspect ratios.
    alpha_deg : (n,) array
        Impact angles from the wall, degrees, above 0 and up to 90.
    speed : float or (n,) array
        Impact speeds, m/s.
    seed : int
        0 to 2**64 - 1.
    numerics : ModelSettings, optional
        Resolution of contacts and tolerance of flights, such as ``config.model``.
    wall_tilt_deg : float
        Standard deviation of the tilt of the facets of a rough wall, degrees, up to 28.65; 0: a
        smooth wall. Facets are drawn as by `sampler.Table.rebound` with ``roughness``, and means
        and spreads refer to the mean wall.
    spin : three floats, optional
        Angular velocity before the impact times a/V, wall frame.
    threads : int, optional
        Default: one a processor. No result depends on it.

    Raises
    ------
    InputError
        If an argument is out of range; here, or by the methods.
    RuntimeError
        By the methods, if a particle is still in contact after 10**8 collisions.
    """

    def __init__(
        self,
        pair: MaterialPair,
        population: Population,
        alpha_deg: ArrayLike,
        speed: ArrayLike,
        *,
        seed: int,
        numerics: ModelSettings | None = None,
        wall_tilt_deg: float = 0.0,
        spin: Sequence[float] | None = None,
        threads: int | None = None,
    ) -> None:
        self._alpha_deg, self._alpha, self._speed = _checked_conditions(alpha_deg, speed)
        self._wall = _checked_wall(wall_tilt_deg, spin)
        self._shapes = population.strata()
        numerics = numerics or ModelSettings()
        self._models = [DirectModel.of_parts(pair, one, numerics) for _, _, one in self._shapes]
        self._seed, self._threads = seed, threads

    def strata(self, count: int, progress: bool = False) -> Strata:
        """Simulate the moments of each shape at each row.

        `Strata.mixed` gives those of the population, and of any other shares of its shapes without
        a new simulation.

        Parameters
        ----------
        count : int
            Particles of each shape at each row, 2 or more.
        progress : bool
            Show a progress bar on standard error.
        """
        workers = self._workers(count)
        shape = self._alpha.size, len(self._shapes)
        places = np.ndindex(*shape)
        pieces = [_Piece(row, k, part) for row, k in places for part in batches(count)]
        done: list[list[CentralMoments]] = []
        total = count * shape[0] * shape[1]
        with bar(progress, "rebound", total=total, unit_scale=True, desc="simulating") as counted:
            results = side_by_side(self._moments, pieces, workers, ahead=2 * workers)
            for piece, moments in zip(pieces, results, strict=True):
                if piece.part.start == 0:
                    done.append([])
                done[-1].append(moments)
                counted.update(moments.count)
        shares = np.array([one.share for one in self._shapes])
        stacked = _stacked([reduce(merged, parts) for parts in done], shape)
        return Strata(self._alpha_deg, shares, stacked)

    def moments(self, count: int, progress: bool = False) -> SimulatedMoments:
        """Simulate means and standard deviations of what can be measured; see `strata`."""
        return self.strata(count, progress).mixed()

    def variables(self, count: int) -> list[list[FloatArray]]:
        """Simulate the rebounds whose moments `strata` gives.

        Parameters
        ----------
        count : int
            As for `strata`.

        Returns
        -------
        list of n lists of s arrays
            For each row and shape, (count, N_VARIABLES) float64.
        """
        workers = self._workers(count)
        rows, shapes = range(self._alpha.size), range(len(self._shapes))
        pieces = [_Piece(row, k, slice(0, count)) for row in rows for k in shapes]
        done = iter(list(side_by_side(self._variables, pieces, workers, ahead=2 * workers)))
        return [[next(done) for _ in shapes] for _ in rows]

    def _workers(self, count: int) -> int:
        """Check a run; how many threads work on it."""
        workers = check_run(count, self._seed, 0, self._threads)
        if not 2 <= count <= _MOST_PARTICLES:
            raise InputError(f"count: got {count}, allowed: 2 to {_MOST_PARTICLES}")
        return workers

    def _moments(self, piece: _Piece) -> CentralMoments:
        """Moments of the rebounds of a piece."""
        return central_moments(self._variables(piece))

    def _variables(self, piece: _Piece) -> FloatArray:
        """Variables of the rebounds of a piece, (m, N_VARIABLES)."""
        row, stratum, part = piece
        first = (self._shapes[stratum].code << 48) + (row << 32)
        index = np.arange(first + part.start, first + part.stop, dtype=np.uint64)
        keys: dict[str, Any] = {"seed": self._seed, "index": index, "threads": 1}
        model, alpha, speed = self._models[stratum], self._alpha[row], self._speed[row]
        if self._wall.roughness == 0.0:
            state = model.sample(alpha, speed, spin=self._wall.spin, **keys)
        else:
            state = self._rough_states(model, alpha, speed, keys)
        return variables_of(state)

    def _rough_states(
        self, model: DirectModel, alpha: float, speed: float, keys: dict[str, Any]
    ) -> FloatArray:
        """States after impacts on a rough wall, in the frame of the mean wall, (m, 6)."""
        velocity = speed * np.array([math.cos(alpha), -math.sin(alpha), 0.0])
        rebound = model.rebound(
            velocity,
            (0.0, 1.0, 0.0),
            1.0,
            omega=speed * self._wall.spin,
            roughness=self._wall.roughness,
            **keys,
        )
        return np.hstack(rebound) / speed
