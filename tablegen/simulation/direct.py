"""Direct rebounds of particles that each have their own velocity, spin and grain."""

from collections.abc import Callable
from functools import partial
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sampler.arguments import MAX_ROUGHNESS, Keys, Rebound, Rows, as_reals_up_to, broadcast, place
from sampler.errors import InputError
from sampler.formats.channels import STATE
from tablegen.config.config import Config, ModelSettings
from tablegen.config.pairs import MaterialPair
from tablegen.config.population import Population
from tablegen.model.impact_condition import CONDITION_SIZE
from tablegen.model.impacts import lab_conditions, states_to_lab, wall_conditions
from tablegen.model.model_bounds import ASPECT
from tablegen.model.one_rebound import DirectArrays, work_size
from tablegen.model.particle_run import simulate_batch
from tablegen.model.random_particles import draw_grains, first_misfit
from tablegen.model.roughness import MAX_ROUGHNESS
from tablegen.simulation.batches import first_not_finite
from tablegen.simulation.direct_rows import OWN, Failure, Particles, work_all
from tablegen.simulation.rough_walls import RoughImpacts, rough_rebounds

#: Whose grain a particle has: its own, a fresh one at every hit, or the one given.
Grain = Literal["own", "fresh"] | ArrayLike

#: Arguments that make an impact in the lab frame.
_IMPACT = ("velocity", "normal", "half_size", "wall_velocity")


class DirectModel:
    """Rebounds by direct simulation, with the methods of `sampler.Table` that draw them.

    So a program that takes its rebounds from a table can take them from here, and anyone can check
    a table in their own flow. Each particle has a velocity, a spin and a grain of its own; a grain
    is a shape and its ratios b/a and c/b.

    Parameters
    ----------
    config : Config
        From `tablegen.load_config`: laws, particles and numerical parameters.
    population : Population, optional
        Other particles than the configuration's, for example
        ``config.population.restricted_to("prism")``.

    Attributes
    ----------
    columns : tuple of str
        The variables in the columns of a state: u, v, w, omega_x, omega_y, omega_z.
    arrays : DirectArrays
        For `tablegen.rebound` and `tablegen.draw` in the user's own compiled code.
    work_size : int
        Numbers of the work space that they need.
    """

    columns = STATE

    def __init__(self, config: Config, population: Population | None = None) -> None:
        self._take(config.pair, population or config.population, config.model)

    @classmethod
    def of_parts(
        cls, pair: MaterialPair, population: Population, numerics: ModelSettings
    ) -> "DirectModel":
        """Make a model of laws, particles and numerical parameters without a configuration."""
        model = cls.__new__(cls)
        model._take(pair, population, numerics)
        return model

    def _take(self, pair: MaterialPair, population: Population, numerics: ModelSettings) -> None:
        """Keep laws, particles and numerical parameters as kernels take them."""
        self.arrays = DirectArrays(
            pair.kernel_arguments(),
            population.kernel_arguments(),
            (numerics.contact_resolution, numerics.tolerance),
        )
        self.work_size: int = work_size(self.arrays.population)

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
        """Simulate rebounds in the frame of the wall.

        Parameters
        ----------
        alpha1 : float or array
            Impact angle in rad from the wall, in (0, pi/2].
        speed : float or array
            Impact speed V in m/s, > 0. All arrays broadcast, as in numpy.
        spin : array, shape (..., 3), optional
            Angular velocity before the impact times a/V, wall frame; none if left out. A particle
            may turn by at most 1e6 rad before its first contact: 2 |spin| / sin(alpha1).
        grain : "own", "fresh" or array, shape (..., 3)
            "own": a particle has the same grain at every hit, drawn from the population by
            (seed, index). "fresh": it has another one at every hit, drawn by (seed, index, hit).
            An array: shape code, b/a and c/b of each particle, as `grains` returns them.
        seed : int
            Seed of the run, uint64.
        index : int or array of int
            Identity of each particle, uint64.
        hit : int or array of int, optional
            How many walls each particle has met before, uint32; 0, the first, if left out. It
            selects the orientation.
        rng, size
            In place of the keys, as for `sampler.Table.sample`.
        threads : int, optional
            Threads to use; by default one a processor. The states do not depend on it.

        Returns
        -------
        float64 array, shape (..., 6)
            u, v, w over V and omega_x, omega_y, omega_z times a/V, in the wall frame: x along the
            tangential velocity before impact, y into the gas. With equal angles, speeds and spins,
            index 0, 1, ... and hit 0 they are those of `tablegen.simulate` with this seed.

        Raises
        ------
        InputError
            If an input has a wrong type or shape, is not finite or not allowed. Names the first
            row.
        RuntimeError
            If a particle is still in contact after 10**8 collisions.
        """
        given = {"alpha1": alpha1, "speed": speed, "spin": np.zeros(3) if spin is None else spin}
        particles = self._particles(given, grain, Keys(seed, index, hit, rng, size))
        values, numerics = particles.rows.values, self.arrays.numerics
        fill = partial(wall_conditions, values["alpha1"], values["speed"], values["spin"], numerics)
        states = self._simulated(particles, threads, fill)
        return states.reshape(*particles.rows.shape, 6)

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
            Angular velocity before impact, rad/s; none if left out.
        grain, seed, index, hit, rng, size, threads
            As for `sample`.
        wall_velocity : array, shape (..., 3), optional
            Velocity of the wall at the point of contact, m/s; at rest if left out.
        roughness : float or array, shape (...), optional
            Standard deviation of the random tilt of a rough wall's normal, rad, from 0 to 0.5;
            a smooth wall if left out. Facets are those that `sampler.Table.rebound` draws with
            these keys; a particle that leaves one into the wall hits again, with the spin that it
            has then and the same grain.

        Returns
        -------
        Rebound
            ``velocity, omega``, both of shape (..., 3), m/s and rad/s. At exactly normal impact the
            direction along the wall is uniform.

        Raises
        ------
        InputError
            As `sample`; also if a particle does not approach the wall or a normal is zero.
        RuntimeError
            As `sample`.
        """
        given = {
            "velocity": velocity,
            "normal": normal,
            "half_size": half_size,
            "wall_velocity": np.zeros(3) if wall_velocity is None else wall_velocity,
            "omega": np.zeros(3) if omega is None else omega,
        }
        if roughness is not None:
            given["roughness"] = as_reals_up_to("roughness", roughness, MAX_ROUGHNESS, " rad")
        particles = self._particles(given, grain, Keys(seed, index, hit, rng, size))
        rows = particles.rows
        if roughness is None:
            states = self._smooth(particles, threads)
        else:
            states = self._rough(particles, threads)
        parts = (states[:, :3], states[:, 3:])
        return Rebound(*(part.copy().reshape(*rows.shape, 3) for part in parts))

    def _lab_conditions(self, rows: Rows) -> Callable[..., Any]:
        """Give what fills the conditions of impacts on the mean wall."""
        numbers = tuple(rows.values[name] for name in _IMPACT)
        return partial(
            lab_conditions, numbers, rows.values["omega"], rows.keys, self.arrays.numerics
        )

    def _smooth(self, particles: Particles, threads: int | None) -> NDArray[np.float64]:
        """Velocities and angular velocities after impacts on smooth walls, (n, 6)."""
        rows = particles.rows
        numbers = tuple(rows.values[name] for name in _IMPACT)
        finish = partial(states_to_lab, numbers, rows.keys)
        return self._simulated(particles, threads, self._lab_conditions(rows), finish)

    def _rough(self, particles: Particles, threads: int | None) -> NDArray[np.float64]:
        """Velocities and angular velocities after impacts on rough walls, (n, 6)."""
        rows = particles.rows
        states, fill = np.empty((rows.n, 6)), self._lab_conditions(rows)

        def work(part: slice) -> Failure | None:
            row, code = fill(np.empty((part.stop - part.start, CONDITION_SIZE)), part.start)
            if row >= 0:
                return Failure(row, code)
            grains = particles.grains(self.arrays.population, part)
            impacts = RoughImpacts.of_rows(rows, part, grains)
            row, code = rough_rebounds(self.arrays, impacts, states[part])
            return Failure(part.start + row, code) if row >= 0 else None

        work_all(work, rows, threads)
        _check_finite(states, rows)
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
            Shape code of `tablegen.model.shape_codes.SHAPE_CODES` (of mesh number k of the
            population FIRST_MESH + k, of `tablegen.model.shapes`), b/a and c/b.
        """
        rows = broadcast({}, Keys(seed, index))
        key, particles, _ = rows.keys
        grains = np.empty((rows.n, 3))
        draw_grains(self.arrays.population, key, particles, OWN, grains)
        return grains.reshape(*rows.shape, 3)

    def _particles(self, given: dict[str, ArrayLike], grain: Grain, keys: Keys) -> Particles:
        """Rows of the arguments, and where their grains come from."""
        if not isinstance(grain, str):
            rows = broadcast(given | {"grain": grain}, keys)
            return Particles(rows, OWN, self._checked_grains(rows))
        if grain not in ("own", "fresh"):
            allowed = "'own', 'fresh', or numbers of shape (..., 3)"
            raise InputError(f"grain: got {grain!r}, allowed: {allowed}")
        rows = broadcast(given, keys)
        return Particles(rows, rows.keys[2] if grain == "fresh" else OWN, None)

    def _checked_grains(self, rows: Rows) -> NDArray[np.float64]:
        """Take the grains out of the rows; refuse the first that is none."""
        grains = rows.values.pop("grain")
        row = first_misfit(self.arrays.population, grains)
        if row < 0:
            return grains
        got = ", ".join(f"{x:.9g}" for x in grains[row])
        meshes = self.arrays.population.meshes.resolutions.size
        raise InputError(
            f"grain: got {got} at {place(row, rows.shape)}, allowed: the code of a shape"
            f"{' or mesh' if meshes else ''}, and b/a and c/b, both {ASPECT.words}, of a sphere 1"
        )

    def _simulated(
        self,
        particles: Particles,
        threads: int | None,
        fill: Callable[..., Any],
        finish: Callable[..., Any] | None = None,
    ) -> NDArray[np.float64]:
        """States of all rows, (n, 6).

        Parameters
        ----------
        particles : Particles
        threads : int or None
        fill : callable
            Takes conditions to write and their first row; gives a bad row, or -1, and its code.
        finish : callable, optional
            Takes states in the frame of the wall, which it may replace, and their first row.
        """
        n = particles.rows.n
        states = np.empty((n, 6))
        law, population, _ = self.arrays

        def work(part: slice) -> Failure | None:
            start, count = part.start, part.stop - part.start
            conditions = np.empty((count, CONDITION_SIZE))
            row, code = fill(conditions, start)
            if row >= 0:
                return Failure(row, code)
            keys, kind = particles.keys(part), particles.kind(part)
            outcome = (states[part], np.empty(count, dtype=np.int64), kind, np.empty((count, 2)))
            stuck = simulate_batch(law, population, conditions, keys, *outcome)
            if stuck >= 0:
                return Failure(start + stuck, 0)
            if finish is not None:
                finish(states[part], start)
            return None

        work_all(work, particles.rows, threads)
        _check_finite(states, particles.rows)
        return states


def _check_finite(states: NDArray[np.float64], rows: Rows) -> None:
    """Raise RuntimeError for the first row with a number that is not finite."""
    bad = first_not_finite(states)
    if bad >= 0:
        raise RuntimeError(f"the particle at {place(bad, rows.shape)} is not finite")
