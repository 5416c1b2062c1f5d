"""Direct rebounds of particles that each have their own velocity, spin and grain."""

from collections.abc import Callable
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sampler.compilation.processors import processors
from sampler.compilation.side_by_side import side_by_side
from sampler.errors import InputError
from sampler.formats.channels import STATE
from sampler.inputs.messages import row_message
from sampler.inputs.output import Rebound
from sampler.inputs.rows import Keys, Rows, as_integer, broadcast, place
from tablegen.batches import BATCH, first_not_finite
from tablegen.config import Config
from tablegen.model.bounds import ALPHA_DEG, ASPECT, MOST_TURNED, SPEED, SPIN
from tablegen.model.conditions import CONDITION_SIZE
from tablegen.model.impacts import (
    OUT_OF_BOUNDS,
    TURNS_TOO_OFTEN,
    lab_conditions,
    states_to_lab,
    wall_conditions,
)
from tablegen.model.particle_run import simulate_batch
from tablegen.model.random_particles import ParticleKeys
from tablegen.model.rebound import COLLISION_ALARM
from tablegen.model.shape_codes import SHAPE_CODES
from tablegen.model.shapes import FIRST_MESH
from tablegen.particles.population import Population

Grain = Literal["own", "fresh"] | ArrayLike


def _of(array: NDArray[Any], part: slice) -> NDArray[Any]:
    """Rows of an array that has one for each particle, or one for all."""
    return array[part] if len(array) > 1 else array


class DirectModel:
    """Rebounds by direct simulation, with the methods of `sampler.Table` that draw them.

    So a program that takes its rebounds from a table can take them from here instead. Each
    particle has its own velocity, spin and grain: its shape and its ratios b/a and c/b.

    Parameters
    ----------
    config : Config
        From `tablegen.load_config`: laws, particles and numerical parameters.
    population : Population, optional
        Other particles than the configuration's.
    """

    #: The variables in the columns of a state.
    columns = STATE

    def __init__(self, config: Config, population: Population | None = None) -> None:
        self._law = config.pair.kernel_arguments()
        self._population = (population or config.population).kernel_arguments()
        self._numerics = (config.model.contact_resolution, config.model.tolerance)

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
    ) -> NDArray[np.float64]:
        """Rebound states in the frame of the wall.

        Parameters
        ----------
        alpha1 : float or array
            Impact angle in rad from the wall, in (0, pi/2].
        speed : float or array
            Impact speed V in m/s, > 0.
        spin : array, shape (..., 3), optional
            Angular velocity before the impact times a/V, wall frame; none if left out.
        grain : "own", "fresh" or array, shape (..., 3)
            "own": each particle has a grain of its own, a function of (seed, index), at every
            hit. "fresh": a new one at every hit. An array: shape code of
            `tablegen.model.shape_codes.SHAPE_CODES`, b/a and c/b.
        seed, index, hit, rng, size
            As for `sampler.Table.sample`.
        threads : int, optional
            Default: one a processor. The states do not depend on it.

        Returns
        -------
        float64 array, shape (..., 6)
            u, v, w over V and omega_x, omega_y, omega_z times a/V, in the wall frame.
        """
        given = {"alpha1": alpha1, "speed": speed, "spin": np.zeros(3) if spin is None else spin}
        rows, grains = self._rows(given, grain, Keys(seed, index, hit, rng, size))
        states = np.empty((rows.n, 6))
        self._run(wall_conditions, rows, grains, states, threads)
        return states.reshape(*rows.shape, 6)

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
        threads: int | None = None,
    ) -> Rebound:
        """Rebound particles from a wall, in the lab frame.

        Parameters
        ----------
        velocity, normal, half_size, wall_velocity
            As for `sampler.Table.rebound`.
        omega : array, shape (..., 3), optional
            Angular velocity before the impact, rad/s; none if left out.
        grain, seed, index, hit, rng, size, threads
            As for `sample`.

        Returns
        -------
        Rebound
            ``velocity, omega``, both of shape (..., 3), m/s and rad/s.
        """
        given = {
            "velocity": velocity,
            "normal": normal,
            "half_size": half_size,
            "wall_velocity": np.zeros(3) if wall_velocity is None else wall_velocity,
            "omega": np.zeros(3) if omega is None else omega,
        }
        rows, grains = self._rows(given, grain, Keys(seed, index, hit, rng, size))
        states = np.empty((rows.n, 6))
        self._run(lab_conditions, rows, grains, states, threads)
        parts = (states[:, :3], states[:, 3:])
        return Rebound(*(part.copy().reshape(*rows.shape, 3) for part in parts))

    def _rows(
        self, given: dict[str, ArrayLike], grain: Grain, keys: Keys
    ) -> tuple[Rows, NDArray[np.float64] | str]:
        """Rows of the arguments, and the grains if they are given."""
        if isinstance(grain, str):
            if grain not in ("own", "fresh"):
                raise InputError(f"grain: got {grain!r}, allowed: 'own', 'fresh' or an array")
            return broadcast(given, keys), grain
        rows = broadcast(given | {"grain": grain}, keys)
        return rows, self._checked_grains(rows.values.pop("grain"), rows)

    def _checked_grains(self, grains: NDArray[np.float64], rows: Rows) -> NDArray[np.float64]:
        codes, ratios = grains[:, 0], grains[:, 1:]
        meshes = self._population.meshes.resolutions.size
        shapes = codes < SHAPE_CODES["mesh"]
        known = shapes | ((codes >= FIRST_MESH) & (codes < FIRST_MESH + meshes))
        fits = ((ratios >= ASPECT.low) & (ratios <= ASPECT.high)).all(axis=1)
        fits &= (codes != SHAPE_CODES["sphere"]) | (ratios == 1.0).all(axis=1)
        bad = ~(known & (codes >= 0) & (codes == np.floor(codes)) & (fits | ~shapes))
        if bad.any():
            k = int(bad.argmax())
            got = ", ".join(f"{x:.9g}" for x in grains[k])
            raise InputError(
                f"grain: got {got} at {place(k, rows.shape)}, allowed: shape code, b/a and c/b, "
                f"both {ASPECT.words}, 1 of a sphere"
            )
        return grains

    def _run(
        self,
        fill: Callable[..., Any],
        rows: Rows,
        grains: NDArray[np.float64] | str,
        states: NDArray[np.float64],
        threads: int | None,
    ) -> None:
        """Write the states of all rows; refuse the first bad one."""
        if threads is not None:
            threads = as_integer("threads", threads, 1, 4096, "an integer from 1 to 4096")
        seed, index, hit = rows.keys
        own = np.zeros(1, dtype=np.uint32)
        drawn = {"own": own, "fresh": hit}
        arguments = tuple(rows.values.values())

        def work(start: int) -> tuple[int, int, int]:
            part = slice(start, min(start + BATCH, rows.n))
            n = part.stop - part.start
            keys = ParticleKeys(seed, index, hit, own)
            conditions, kind = np.empty((n, CONDITION_SIZE)), np.empty((n, 3))
            row, code = fill(*arguments, self._numerics, keys, conditions, start)
            if row >= 0:
                return row, code, -1
            if isinstance(grains, str):
                grain = _of(drawn[grains], part)
            else:
                kind[:] = _of(grains, part)
                grain = own[:0]
            keys = ParticleKeys(seed, _of(index, part), _of(hit, part), grain)
            outcome = states[part], np.empty(n, dtype=np.int64), kind, np.empty((n, 2))
            stuck = simulate_batch(self._law, self._population, conditions, keys, *outcome)
            if stuck >= 0:
                return -1, 0, start + stuck
            if fill is lab_conditions:
                keys = ParticleKeys(seed, index, hit, own)
                velocity, normal, half_size, wall_velocity, _ = arguments
                impact = velocity, normal, half_size, wall_velocity
                states_to_lab(*impact, keys, states[part], start)
            return -1, 0, -1

        starts = range(0, rows.n, BATCH)
        for row, code, stuck in side_by_side(work, starts, threads or processors()):
            if row >= 0:
                raise InputError(_message(rows, row, code))
            if stuck >= 0:
                raise RuntimeError(
                    f"the particle at {place(stuck, rows.shape)} is still in contact after "
                    f"{COLLISION_ALARM:,} collisions; a larger contact_resolution ends its chain"
                )
        bad = first_not_finite(states)
        if bad >= 0:
            raise RuntimeError(f"the particle at {place(bad, rows.shape)} is not finite")


def _message(rows: Rows, row: int, code: int) -> str:
    """Message on a row that cannot be used."""
    if code == OUT_OF_BOUNDS:
        return _bounds_message(rows, row)
    if code != TURNS_TOO_OFTEN:
        return row_message(rows, row, code)
    name = "omega" if "omega" in rows.values else "spin"
    got = ", ".join(f"{x:.9g}" for x in rows.at(name, row))
    return (
        f"{name}: got {got} at {place(row, rows.shape)}, allowed: what turns the particle by at "
        f"most {MOST_TURNED:g} rad before its first contact"
    )


def _bounds_message(rows: Rows, row: int) -> str:
    """Message on a row whose angle, speed or spin is outside of the bounds of the model."""
    names = [name for name in rows.values if name not in ("normal", "half_size")]
    got = "; ".join(
        f"{name} {', '.join(f'{x:.9g}' for x in np.atleast_1d(rows.at(name, row)))}"
        for name in names
    )
    return (
        f"{names[0]}: got {got} at {place(row, rows.shape)}, allowed: an impact at "
        f"{ALPHA_DEG.words} and {SPEED.words}, with a spin of {SPIN.words}"
    )
