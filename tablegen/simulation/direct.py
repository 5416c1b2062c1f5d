"""Direct rebounds of particles that each have their own velocity, spin and grain."""

import math
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
from tablegen.model.model_bounds import ASPECT
from tablegen.model.orientation import tumble_all
from tablegen.model.random_particles import first_misfit
from tablegen.simulation.batches import first_not_finite, in_slices
from tablegen.simulation.direct_impacts import (
    DirectArrays,
    DirectImpacts,
    DirectResults,
    Failure,
    failure_of,
    writable_arrays,
)
from tablegen.simulation.rough_walls import rough_rebounds
from tablegen.simulation.smooth_walls import smooth_rebounds


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
        particles = population or config.population
        self._arrays = DirectArrays.of(config.pair, particles, config.model, instant)

    @classmethod
    def of_parts(
        cls, pair: MaterialPair, population: Population, numerics: ModelSettings
    ) -> "DirectModel":
        """Make a model of laws, particles and numerical parameters without a configuration."""
        model = cls.__new__(cls)
        model._arrays = DirectArrays.of(pair, population, numerics)
        return model

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
        call, impacts = self._impacts(given, grain, Keys(seed, index, hit, rng, size))
        return self._simulated(call, impacts, threads).states.reshape(*call.shape, 6)

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
        call, impacts = self._impacts(given, grain, Keys(seed, index, hit, rng, size))
        results = self._simulated(call, impacts, threads, works)
        parts = results.states[:, :3].copy(), results.states[:, 3:].copy(), results.orientation
        return DirectRebound(*(part.reshape(*call.shape, part.shape[1]) for part in parts))

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
        n, arrays = call.rows.n, writable_arrays(call)
        turned = np.array(np.broadcast_to(arrays["orientation"], (n, 4)))
        spins = np.array(np.broadcast_to(arrays["omega"], (n, 3)))
        self._check_grains(call, arrays["grain"])
        _, population, numerics = self._arrays
        row, code = tumble_all(population, numerics, arrays["grain"], spins, arrays["time"], turned)
        if row >= 0:
            raise failure_of(call, row, code)
        return turned.reshape(*call.shape, 4), spins.reshape(*call.shape, 3)

    def grains(self, seed: int, index: ArrayLike) -> NDArray[np.float64]:
        """Return the grains that particles keep, (..., 3), as `sampler.Table.grains`.

        The shape code of mesh number k of the population is FIRST_MESH + k.
        """
        call = broadcast({}, Keys(seed, index))
        grains = DirectImpacts.of_call(call).grains(call.rows.n, self._arrays.population)
        return grains.reshape(*call.shape, 3)

    def _impacts(
        self, given: dict[str, Any], grain: Grain, keys: Keys
    ) -> tuple[Call, DirectImpacts]:
        """Broadcast the arguments, with zeros for a spin or a wall velocity that is left out."""
        check_grain_word(grain)
        drawn = isinstance(grain, str)
        call = broadcast(given if drawn else given | {"grain": grain}, keys)
        for name in ("omega", "wall_velocity") if "velocity" in given else ("spin",):
            call.rows.arrays.setdefault(name, np.zeros((1, 3)))
        impacts = DirectImpacts.of_call(call, fresh=drawn and grain == "fresh")
        if impacts.grain is not None:
            self._check_grains(call, impacts.grain)
        return call, impacts

    def _check_grains(self, call: Call, grains: FloatArray) -> None:
        """Refuse the first row that is not a grain of the population."""
        row = first_misfit(self._arrays.population, grains)
        if row < 0:
            return
        got = ", ".join(f"{x:.9g}" for x in grains[row])
        meshes = self._arrays.population.meshes.resolutions.size
        raise InputError(
            f"grain: got {got} at {place(row, call.shape)}, allowed: the code of a shape"
            f"{' or mesh' if meshes else ''}, and b/a and c/b, both {ASPECT.words}, of a sphere 1"
        )

    def _simulated(
        self,
        call: Call,
        impacts: DirectImpacts,
        threads: int | None,
        works: FloatArray | None = None,
    ) -> DirectResults:
        """Simulate all impacts in threads; raise the error of the first row that fails."""
        results = DirectResults.empty(call.rows.n, works)
        rebounds = smooth_rebounds if impacts.roughness is None else rough_rebounds

        def work(part: slice) -> None:
            try:
                rebounds(self._arrays, impacts.of(part), results.of(part))
            except Failure as failure:
                raise failure_of(call, part.start + failure.row, failure.code) from None

        for _ in in_slices(work, call.rows.n, as_threads(threads) or processors()):
            pass  # the results are written
        bad = first_not_finite(results.states)
        if bad >= 0:
            raise RuntimeError(f"the particle at {place(bad, call.shape)} is not finite")
        return results
