"""Direct rebounds of particles that each have their own velocity, spin and grain."""

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
    check_written,
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
from tablegen.model.random_particles import first_misfit
from tablegen.parallel import in_slices
from tablegen.simulation.direct_impacts import (
    DirectArrays,
    DirectImpacts,
    DirectResults,
    Failure,
    failure_of,
)
from tablegen.simulation.failures import first_not_finite
from tablegen.simulation.rough_walls import rough_rebounds
from tablegen.simulation.smooth_walls import smooth_rebounds


class DirectRebound(NamedTuple):
    """Result of `DirectModel.rebound`, as `sampler.table.Rebound`."""

    velocity: NDArray[np.float64]
    omega: NDArray[np.float64]
    #: Inertia about omega over m a^2, (...); 0 without spin, and of fresh grains.
    inertia: NDArray[np.float64]


class DirectModel:
    """Rebounds by direct simulation, with the methods of `sampler.Table` that draw them.

    A grain is a shape and its ratios b/a and c/b. Between walls it tumbles; what stays is its mean
    angular velocity, omega = (2T/L^2) L, and the inertia about it, L^2 / (2T m a^2), which go in
    and out. The orientation in which it meets the next wall is drawn by the keys: each orientation
    of free tumbling with these four numbers is as likely as the share of time that the grain spends
    in it, which is right after a flight of a few turns (`tablegen.model.tumbling`). So a chain of
    rebounds is direct simulation of a whole path. A grain without spin is oriented uniformly, and
    so is one with a spin whose inertia is not known.

    A grain may tumble around either end of an axis. The four numbers do not tell the ends of a mesh
    without symmetry apart; one of them is drawn at every wall.

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
        self._arrays = DirectArrays.of(config.pair, population or config.population, config.model)

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
        inertia: ArrayLike | None = None,
        grain: Grain = "own",
        seed: int | None = None,
        index: ArrayLike | None = None,
        hit: ArrayLike | None = None,
        rng: np.random.Generator | None = None,
        size: int | tuple[int, ...] | None = None,
        threads: int | None = None,
        inertia_after: FloatArray | None = None,
    ) -> NDArray[np.float64]:
        """Simulate rebounds in the frame of the wall.

        Parameters
        ----------
        alpha1, speed, seed, index, hit, rng, size, threads
            As for `sampler.Table.sample`. `hit` selects the orientation; it is needed with a spin.
        spin : array, shape (..., 3), optional
            Mean angular velocity before the impact times a/V, wall frame; none if left out. A
            particle may turn by at most 1e6 rad before its first contact:
            ``2 |spin| / sin(alpha1)``.
        inertia : array, shape (...), optional
            That about the spin over m a^2, from the smallest to the largest moment of the grain;
            0, or left out: not known.
        grain : "own", "fresh" or array, shape (..., 3)
            "own": a particle has the same grain at every hit, drawn from the population by
            (seed, index). "fresh": it has another one at every hit, drawn by (seed, index, hit).
            An array: shape code, b/a and c/b of each particle, as `grains` returns them.
        inertia_after : float64 array, shape (n,), written
            Inertia of the n particles about their spin after the impact, over m a^2: 0 without
            spin, and of fresh grains.

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
        given = {"alpha1": alpha1, "speed": speed} | present(spin=spin, inertia=inertia)
        call, impacts = self._impacts(given, grain, Keys(seed, index, hit, rng, size))
        check_written("inertia_after", inertia_after, (call.rows.n,), np.float64)
        results = self._simulated(call, impacts, threads)
        if inertia_after is not None:
            inertia_after[:] = results.inertia
        return results.states.reshape(*call.shape, 6)

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
        velocity, normal, half_size, omega, inertia, wall_velocity
            As for `sampler.Table.rebound`.
        grain, seed, index, hit, rng, size, threads
            As for `sample`.
        roughness : float or array, shape (...), optional
            Standard deviation of the random tilt of a rough wall's normal, rad, from 0 to 0.5;
            a smooth wall if left out. The facets are those of `sampler.Table.rebound` with the same
            keys. A particle that leaves one into the wall hits again with its new spin and
            inertia and the same grain.
        isotropic : bool
            As for `sampler.Table.rebound`.
        works : float64 array, shape (n, 2), written
            Energies that the normal and the tangential impulses of the n rebounds took, J/kg; of
            smooth walls only.

        Returns
        -------
        DirectRebound
            ``velocity, omega``, both of shape (..., 3), m/s and rad/s, and ``inertia``, shape
            (...), over m a^2. At exactly normal impact the direction along the wall is uniform.

        Raises
        ------
        InputError, RuntimeError
            As `sample`; also if a particle does not approach the wall or a normal is zero.
        """
        given = {"velocity": velocity, "normal": normal, "half_size": half_size}
        given |= present(wall_velocity=wall_velocity, omega=omega, inertia=inertia)
        isotropic = as_isotropic(isotropic, roughness)
        if roughness is not None and works is not None:
            raise InputError("works: got an array, allowed: none with roughness")
        if roughness is not None:
            given["roughness"] = as_reals_up_to("roughness", roughness, MAX_ROUGHNESS, " rad")
            given["across"] = given["roughness"] if isotropic else 0.0
        call, impacts = self._impacts(given, grain, Keys(seed, index, hit, rng, size))
        results = self._simulated(call, impacts, threads, works)
        velocity, omega = results.states[:, :3].copy(), results.states[:, 3:].copy()
        shape = call.shape
        return DirectRebound(
            velocity.reshape(*shape, 3), omega.reshape(*shape, 3), results.inertia.reshape(shape)
        )

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
        fresh = drawn and grain == "fresh"
        call = broadcast(given if drawn else given | {"grain": grain}, keys, fresh)
        for name in ("omega", "wall_velocity") if "velocity" in given else ("spin",):
            call.rows.arrays.setdefault(name, np.zeros((1, 3)))
        call.rows.arrays.setdefault("inertia", np.zeros(1))
        impacts = DirectImpacts.of_call(call)
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
        if call.rows.fresh:
            results.inertia[:] = 0.0
        bad = first_not_finite(results.states)
        if bad >= 0:
            raise RuntimeError(f"the particle at {place(bad, call.shape)} is not finite")
        return results
