"""Direct rebounds of particles that each have their own velocity, spin and grain."""

import math
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sampler.arguments import (
    MAX_ROUGHNESS,
    Call,
    Grain,
    Keys,
    as_isotropic,
    as_reals_up_to,
    as_threads,
    broadcast,
    check_grain_word,
    place,
    present,
)
from sampler.errors import InputError
from sampler.formats.channels import STATE
from sampler.library import processors
from tablegen.config.config import Config, ModelSettings
from tablegen.config.pairs import MaterialPair
from tablegen.config.population import Population
from tablegen.model.float_array import FloatArray
from tablegen.model.impacts import CONDITION_SIZE, lab_conditions, states_to_lab, wall_conditions
from tablegen.model.model_bounds import ASPECT
from tablegen.model.orientation import axes_from, orientations_from, tumble_all
from tablegen.model.particle_run import simulate_batch
from tablegen.model.random_particles import first_misfit
from tablegen.simulation.batches import first_not_finite, in_slices
from tablegen.simulation.direct_rows import OWN, DirectArrays, Failure, Particles, failure_of
from tablegen.simulation.rough_walls import RoughImpacts, rough_rebounds

#: Arguments that make an impact in the lab frame.
_IMPACT = ("velocity", "normal", "half_size", "wall_velocity")

#: An impact whose frame is the lab frame.
_WALL = (
    np.array([[1.0, -1.0, 0.0]]),
    np.array([[0.0, 1.0, 0.0]]),
    np.ones(1),
    np.zeros((1, 3)),
)


class DirectRebound(NamedTuple):
    """Result of `DirectModel.rebound`; velocity and omega are those of `sampler.table.Rebound`."""

    velocity: NDArray[np.float64]
    omega: NDArray[np.float64]
    #: As the particle leaves, (..., 4), scalar first and not negative, from body axes to the lab.
    orientation: NDArray[np.float64]


class DirectModel:
    """Rebounds by direct simulation, with the methods of `sampler.Table` that draw them.

    A grain is a shape and its ratios b/a and c/b. Between walls it tumbles, and meets the next one
    in the orientation that it then has: `rebound` takes and returns orientations, and `tumble`
    turns them. Angular velocities are means over free tumbling, (2T/L^2) L, which together with the
    orientation determine a rotation; with ``domain.omega = "departure"`` they are those of the
    instant.

    The torque of the gas acts on the mean: take `sampler.spin_after` over a time step, then
    `tumble` by the new one. A batch may mix first and later hits: give a first hit zeros as omega
    and a random orientation, as ``scipy.spatial.transform.Rotation.random`` makes.

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
    """

    columns = STATE

    def __init__(self, config: Config, population: Population | None = None) -> None:
        instant = config.domain.omega == "departure"
        self._take(config.pair, population or config.population, config.model, instant)

    @classmethod
    def of_parts(
        cls, pair: MaterialPair, population: Population, numerics: ModelSettings
    ) -> "DirectModel":
        """Make a model of laws, particles and numerical parameters without a configuration."""
        model = cls.__new__(cls)
        model._take(pair, population, numerics, instant=False)
        return model

    def _take(
        self, pair: MaterialPair, population: Population, numerics: ModelSettings, instant: bool
    ) -> None:
        """Keep laws, particles and numerical parameters as kernels take them."""
        self.arrays = DirectArrays(
            pair.kernel_arguments(population.only_spheres),
            population.kernel_arguments(),
            (numerics.contact_resolution, numerics.tolerance, float(instant)),
        )

    def sample(
        self,
        alpha1: ArrayLike,
        speed: ArrayLike,
        *,
        spin: ArrayLike | None = None,
        grain: Grain = "own",
        orientation: ArrayLike | None = None,
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
        alpha1, speed, seed, index, hit, rng, size, threads
            As for `sampler.Table.sample`. `hit` selects the orientation; it is needed with a spin.
        spin : array, shape (..., 3), optional
            Angular velocity before the impact times a/V, wall frame; none if left out. A particle
            may turn by at most 1e6 rad before its first contact: ``2 |spin| / sin(alpha1)``.
        grain : "own", "fresh" or array, shape (..., 3)
            "own": a particle has the same grain at every hit, drawn from the population by
            (seed, index). "fresh": it has another one at every hit, drawn by (seed, index, hit).
            An array: shape code, b/a and c/b of each particle, as `grains` returns them.
        orientation : array, shape (..., 4), optional
            Quaternion from body axes to the wall frame, scalar first; uniformly random if left out.
            That is right for a particle that does not spin, and only roughly for one that does.

        Returns
        -------
        float64 array, shape (..., 6)
            States as of `sampler.Table.sample`. With equal angles, speeds and spins, index 0, 1,
            ... and hit 0 they are those of `tablegen.simulate` with this seed.

        Raises
        ------
        InputError
            If an input has a wrong type or shape or is not allowed. Names the first row.
        RuntimeError
            If a particle is still in contact after 10**8 collisions.
        """
        given = {"alpha1": alpha1, "speed": speed} | present(spin=spin, orientation=orientation)
        particles = self._particles(given, grain, Keys(seed, index, hit, rng, size))
        alpha1, speed, spins = map(particles.array, ("alpha1", "speed", "spin"))
        fill = partial(wall_conditions, alpha1, speed, spins, self.arrays.numerics)
        states, _ = self._simulated(particles, threads, fill, _WALL)
        return states.reshape(*particles.call.shape, 6)

    def rebound(
        self,
        velocity: ArrayLike,
        normal: ArrayLike,
        half_size: ArrayLike,
        *,
        omega: ArrayLike | None = None,
        grain: Grain = "own",
        orientation: ArrayLike | None = None,
        seed: int | None = None,
        index: ArrayLike | None = None,
        hit: ArrayLike | None = None,
        rng: np.random.Generator | None = None,
        size: int | tuple[int, ...] | None = None,
        wall_velocity: ArrayLike | None = None,
        roughness: ArrayLike | None = None,
        isotropic: bool = False,
        threads: int | None = None,
        works: FloatArray | None = None,
    ) -> DirectRebound:
        """Rebound particles from a wall, in the lab frame.

        Parameters
        ----------
        velocity, normal, half_size, omega, wall_velocity
            As for `sampler.Table.rebound`.
        grain, seed, index, hit, rng, size, threads
            As for `sample`.
        orientation : array, shape (..., 4), optional
            Quaternion as the centre is the bounding radius away from the wall, from body axes to
            the lab, scalar first; uniformly random if left out, as for `sample`.
        roughness : float or array, shape (...), optional
            Standard deviation of the random tilt of a rough wall's normal, rad, from 0 to 0.5;
            a smooth wall if left out. The facets are those of `sampler.Table.rebound` with the same
            keys. A particle that leaves one into the wall hits again with its new spin, its
            orientation and the same grain.
        isotropic : bool
            As for `sampler.Table.rebound`.
        works : float64 array, shape (n, 2), written
            Energies that the normal and the tangential impulses of the n rebounds took, J/kg; of
            smooth walls only.

        Returns
        -------
        DirectRebound
            ``velocity, omega``, both of shape (..., 3), m/s and rad/s, and ``orientation``, shape
            (..., 4). At exactly normal impact the direction along the wall is uniform.

        Raises
        ------
        InputError, RuntimeError
            As `sample`; also if a particle does not approach the wall or a normal is zero.
        """
        given = {"velocity": velocity, "normal": normal, "half_size": half_size}
        given |= present(wall_velocity=wall_velocity, omega=omega, orientation=orientation)
        isotropic = as_isotropic(isotropic, roughness)
        if roughness is not None and works is not None:
            raise InputError("works: got an array, allowed: none with roughness")
        if roughness is not None:
            given["roughness"] = as_reals_up_to("roughness", roughness, MAX_ROUGHNESS, " rad")
            given["across"] = given["roughness"] if isotropic else 0.0
        particles = self._particles(given, grain, Keys(seed, index, hit, rng, size))
        numbers = tuple(particles.array(name) for name in _IMPACT)
        keys_of_rows = particles.lab_keys
        fill = partial(
            lab_conditions, numbers, particles.array("omega"), keys_of_rows, self.arrays.numerics
        )
        finish = partial(states_to_lab, numbers, keys_of_rows)
        states, turned = self._simulated(particles, threads, fill, numbers, finish, works)
        if works is not None:
            works *= 0.5 * np.square(numbers[0] - numbers[3]).sum(axis=1, keepdims=True)
        parts = (states[:, :3].copy(), states[:, 3:].copy(), turned)
        shape = particles.call.shape
        return DirectRebound(*(part.reshape(*shape, part.shape[1]) for part in parts))

    def tumble(
        self,
        orientation: ArrayLike,
        omega: ArrayLike,
        grain: ArrayLike,
        half_size: ArrayLike,
        time: ArrayLike,
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Turn particles by free rotation between walls.

        Parameters
        ----------
        orientation : array, shape (..., 4)
            Quaternions as `rebound` returns them.
        omega : array, shape (..., 3)
            Angular velocities as `rebound` returns them, rad/s, lab frame.
        grain : array, shape (..., 3)
            As `grains` returns them.
        half_size : array, shape (...)
            Largest half-sizes a, m. Free rotation is the same for any.
        time : array, shape (...)
            Of the flight, s; a particle may turn by at most 1e6 rad.

        Returns
        -------
        orientation : float64 array, shape (..., 4)
            After the flight.
        omega : float64 array, shape (..., 3)
            As before; with ``domain.omega = "departure"`` that of the instant after the flight.

        Raises
        ------
        InputError
            If an input has a wrong type or shape or is not allowed. Names the first row.
        """
        given = {
            "orientation": orientation,
            "omega": omega,
            "grain": grain,
            "half_size": as_reals_up_to("half_size", half_size, math.inf, " m"),
            "time": time,
        }
        call = broadcast(given, Keys(rng=np.random.default_rng(0)))
        particles = Particles(call, OWN, None)
        n = call.rows.n
        turned, spins = (
            np.array(np.broadcast_to(particles.array(name), (n, width)))
            for name, width in (("orientation", 4), ("omega", 3))
        )
        _, population, numerics = self.arrays
        others = self._checked_grains(call), spins, particles.array("time"), turned
        row, code = tumble_all(population, numerics, *others)
        if row >= 0:
            raise failure_of(call, Failure(row, code))
        return turned.reshape(*call.shape, 4), spins.reshape(*call.shape, 3)

    def grains(self, seed: int, index: ArrayLike) -> NDArray[np.float64]:
        """Return the grains that particles keep, (..., 3), as `sampler.Table.grains`.

        The shape code of mesh number k of the population is FIRST_MESH + k.
        """
        particles = Particles(broadcast({}, Keys(seed, index)), OWN, None)
        grains = particles.grains(self.arrays, slice(0, particles.call.rows.n))
        return grains.reshape(*particles.call.shape, 3)

    def _particles(self, given: dict[str, Any], grain: Grain, keys: Keys) -> Particles:
        """Broadcast the arguments, and say where the grains come from."""
        check_grain_word(grain)
        drawn = isinstance(grain, str)
        call = broadcast(given if drawn else given | {"grain": grain}, keys)
        for name in ("omega", "wall_velocity") if "velocity" in given else ("spin",):
            call.rows.arrays.setdefault(name, np.zeros((1, 3)))
        made_at = call.rows.arrays["hit"] if drawn and grain == "fresh" else OWN
        return Particles(call, made_at, None if drawn else self._checked_grains(call))

    def _checked_grains(self, call: Call) -> FloatArray:
        """Return the given grains; refuse the first that is not a grain."""
        grains = Particles(call, OWN, None).array("grain")
        row = first_misfit(self.arrays.population, grains)
        if row < 0:
            return grains
        got = ", ".join(f"{x:.9g}" for x in grains[row])
        meshes = self.arrays.population.meshes.resolutions.size
        raise InputError(
            f"grain: got {got} at {place(row, call.shape)}, allowed: the code of a shape"
            f"{' or mesh' if meshes else ''}, and b/a and c/b, both {ASPECT.words}, of a sphere 1"
        )

    def _simulated(
        self,
        particles: Particles,
        threads: int | None,
        fill: Callable[..., Any],
        impacts: tuple[NDArray[Any], ...],
        finish: Callable[..., Any] | None = None,
        works: FloatArray | None = None,
    ) -> tuple[FloatArray, FloatArray]:
        """Simulate all rows in threads; raise the error of the first that fails.

        `fill` writes conditions from a row on and returns the first bad row, or -1, and its code;
        `impacts` are velocity, normal, half-size and wall velocity, whose frames orientations are
        given in; `finish` turns states from a row on into another frame; `works` (n, 2) is written.
        Returns states (n, 6) and orientations (n, 4), which only `finish` brings.
        """
        call = particles.call
        states, turned = np.empty((call.rows.n, 6)), np.empty((call.rows.n, 4))
        energy = np.empty((call.rows.n, 2 if works is None else 4))
        rough = "roughness" in call.rows.arrays

        def work(part: slice) -> Failure | None:
            conditions = np.empty((part.stop - part.start, CONDITION_SIZE))
            row, code = fill(conditions, part.start)
            if row >= 0:
                return Failure(row, code)
            if rough:
                found = RoughImpacts.of_rows(particles, part, self.arrays)
                both = states[part], turned[part]
                row, code = rough_rebounds(self.arrays, particles.seed, found, *both)
                row += part.start if row >= 0 else 0
            else:
                outputs = states, None if finish is None else turned, energy
                failure = self._smooth(particles, part, impacts, conditions, *outputs)
                row, code = failure
            if row >= 0:
                return Failure(row, code)
            if works is not None:  # those of the kernel are over all energy, that of spin too
                square = np.square(states[part, :3]).sum(axis=1)
                works[part] = energy[part, 2:] * (square / energy[part, 0])[:, None]
            if finish is not None and not rough:
                finish(states[part], part.start)
            return None

        for _, failure in in_slices(work, call.rows.n, as_threads(threads) or processors()):
            if failure is not None:
                raise failure_of(call, failure)
        bad = first_not_finite(states)
        if bad >= 0:
            raise RuntimeError(f"the particle at {place(bad, call.shape)} is not finite")
        return states, turned

    def _smooth(
        self,
        particles: Particles,
        part: slice,
        impacts: tuple[NDArray[Any], ...],
        conditions: FloatArray,
        states: FloatArray,
        turned: FloatArray | None,
        energy: FloatArray,
    ) -> Failure:
        """Simulate some rows on smooth walls; return the first that fails, or -1.

        Orientations that nobody asks for need not be computed, nor their kernel compiled.
        """
        n, lab_keys = part.stop - part.start, particles.lab_keys
        axes = np.empty((n, 6))
        if "orientation" in particles.call.rows.arrays:
            given = particles.array("orientation")
            row, code = axes_from(given, impacts, lab_keys, axes, part.start)
            if row >= 0:
                return Failure(row, code)
        unused = np.empty(n, dtype=np.int64), particles.kind(part)
        law, population, _ = self.arrays
        how = law, population, conditions, particles.keys(part)
        stuck = simulate_batch(*how, axes, states[part], *unused, energy[part])
        if stuck >= 0:
            return Failure(part.start + stuck, 0)
        if turned is not None:
            orientations_from(axes, impacts, lab_keys, turned[part], part.start)
        return Failure(-1, 0)
