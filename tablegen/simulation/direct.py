"""Direct simulation of particles that each have their own velocity, spin and grain."""

from functools import cached_property
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
    present,
    row_index,
)
from sampler.errors import InputError
from sampler.formats.channels import STATE
from sampler.formats.shape_geometry import Geometry
from sampler.library import processors
from tablegen.config.config import Config, ModelSettings
from tablegen.config.pairs import MaterialPair
from tablegen.config.population import Population
from tablegen.model.float_array import FloatArray
from tablegen.model.model_bounds import ASPECT
from tablegen.model.random_particles import first_wrong_grain
from tablegen.parallel import in_slices
from tablegen.simulation.direct_impacts import (
    DirectArrays,
    DirectImpacts,
    DirectResults,
    Failure,
    error_of_failure,
)
from tablegen.simulation.failures import first_not_finite
from tablegen.simulation.rough_walls import rough_rebounds
from tablegen.simulation.smooth_walls import smooth_rebounds


class DirectRebound(NamedTuple):
    """Velocity and rotation of particles after a rebound, from `DirectModel.rebound`.

    The fields are those of `sampler.Rebound`.

    Attributes
    ----------
    velocity : float64 array, shape (..., 3)
        Velocity after the rebound [m/s], lab frame.
    omega : float64 array, shape (..., 3)
        Mean angular velocity after the rebound [rad/s], lab frame.
    inertia : float64 array, shape (...)
        Inertia about ``omega`` over m a^2; 0 for particles without spin, and for fresh grains.
    """

    velocity: NDArray[np.float64]
    omega: NDArray[np.float64]
    inertia: NDArray[np.float64]


class DirectModel:
    """Rebounds by direct simulation.

    `sample` and `rebound` take and return the same as those of `sampler.Table`, and simulate each
    rebound instead of drawing it from a table. So a `DirectModel` can replace a table in any
    program, and a chain of its rebounds is the direct simulation of a whole path.

    Parameters
    ----------
    config : Config
        Configuration with laws, particles and numerical parameters, from `tablegen.load_config`.
    population : Population, optional
        Other particles than those of the configuration, for example
        ``config.population.restricted_to("prism")``.

    Attributes
    ----------
    columns : tuple of str
        The variables in the columns of a state: u, v, w, omega_x, omega_y, omega_z.
    shape_geometry : dict
        As of `sampler.Table`, for `sampler.half_size`.

    Notes
    -----
    Between walls a grain tumbles. Its angular momentum L and its rotational energy T are constant,
    and so are the mean angular velocity omega = (2T/L^2) L and the inertia about it, L^2 / (2T m
    a^2). These four numbers are passed to a rebound and returned by it.

    The keys draw the orientation in which a grain meets the next wall. An orientation is as likely
    as the share of time that a grain with these four numbers spends in it during free tumbling.
    That is right after a flight of a few turns (`tablegen.model.tumbling`). A grain without spin is
    oriented uniformly, and so is a grain with a spin whose inertia is not known.

    A grain may tumble around either end of an axis. For a mesh without symmetry the two ends
    differ, and the four numbers do not say which of them it is. One of them is drawn at each wall.

    Examples
    --------
    Two grains hit a wall and then a second one. Their spin and inertia go from rebound to rebound:

    >>> import numpy as np
    >>> from tablegen import DirectModel, load_config
    >>> model = DirectModel(load_config("corundum-steel"))
    >>> velocity = np.array([[80.0, -60.0, 0.0], [80.0, -60.0, 0.0]])
    >>> keys = {"seed": 7, "index": [0, 1]}
    >>> first = model.rebound(velocity, [0.0, 1.0, 0.0], 1e-5, hit=0, **keys)
    >>> bool(np.all(first.velocity[:, 1] > 0.0))
    True
    >>> second = model.rebound(
    ...     first.velocity,
    ...     [0.0, -1.0, 0.0],
    ...     1e-5,
    ...     omega=first.omega,
    ...     inertia=first.inertia,
    ...     hit=1,
    ...     **keys,
    ... )
    >>> second.velocity.shape
    (2, 3)
    """

    columns = STATE

    def __init__(self, config: Config, population: Population | None = None) -> None:
        self._population = population or config.population
        self._arrays = DirectArrays.from_parts(config.pair, self._population, config.model)

    @classmethod
    def from_parts(
        cls, pair: MaterialPair, population: Population, numerics: ModelSettings
    ) -> "DirectModel":
        """Make a model from laws, particles and numerical parameters."""
        model = cls.__new__(cls)
        model._population = population
        model._arrays = DirectArrays.from_parts(pair, population, numerics)
        return model

    @cached_property
    def shape_geometry(self) -> dict[int, Geometry]:
        """Volume, moment of inertia and surface of the shapes and meshes, by code."""
        return self._population.shape_geometry()

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
        alpha1 : float or array
            Impact angle from the wall [rad], in (0, pi/2].
        speed : float or array
            Impact speed V [m/s].
        spin : array, shape (..., 3), optional
            Mean angular velocity before the impact times a/V, in wall axes. By default particles do
            not spin. A particle may turn by at most 1e6 rad before its first contact,
            ``2 |spin| / sin(alpha1)``.
        inertia : float or array, optional
            Inertia about the spin over m a^2, from the smallest to the largest principal moment of
            the grain. With 0, the default, it is not known.
        grain : {"own", "fresh"} or array of shape (..., 3), optional
            With "own", the default, a particle has the same grain at every hit, drawn from the
            population by (seed, index). With "fresh" it has another grain at every hit, drawn by
            (seed, index, hit). An array gives shape code, b/a and c/b of each particle, as `grains`
            returns them.
        seed, index, hit, rng, size, threads
            As for `sampler.Table.sample`. The keys also draw the orientation at the impact, so
            ``hit`` is required with a spin.
        inertia_after : float64 array of shape (n,), optional
            If given, the inertias of the n particles about their spin after the impact, over m a^2,
            are written to it: 0 for particles without spin, and for fresh grains.

        Returns
        -------
        float64 array, shape (..., 6)
            States, with the variables of `columns`.

        Raises
        ------
        InputError
            If an argument has a wrong type or shape, or a value that is not allowed. The message
            names the first row.
        RuntimeError
            If a particle is still in contact after 10**8 collisions, or if its state is not finite.

        Notes
        -----
        For equal angles, speeds and spins, the particles ``index=0, 1, ...`` at ``hit=0`` are those
        of `tablegen.simulate` with the same seed.

        Examples
        --------
        >>> import numpy as np
        >>> from tablegen import DirectModel, load_config
        >>> model = DirectModel(load_config("corundum-steel"))
        >>> states = model.sample(np.radians(30.0), [80.0, 120.0], seed=7, index=[0, 1])
        >>> states.shape
        (2, 6)
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
        """Simulate rebounds from a wall in the lab frame.

        Parameters
        ----------
        velocity : array, shape (..., 3)
            Velocity before the impact [m/s].
        normal : array, shape (..., 3)
            Wall normal into the gas, of any length but zero.
        half_size : float or array
            Largest half-size a of the particle [m], from 1e-9 to 100.
        omega : array, shape (..., 3), optional
            Mean angular velocity before the impact [rad/s], as a rebound returns it. By default
            particles do not spin.
        inertia : float or array, optional
            Inertia about ``omega`` over m a^2, as a rebound returns it. With 0, the default, it is
            not known.
        grain, seed, index, hit, rng, size, threads
            As for `sample`.
        wall_velocity : array, shape (..., 3), optional
            Velocity of the wall at the point of contact [m/s]. By default the wall is at rest.
        roughness : float or array, optional
            Standard deviation of the random tilt of a rough wall's normal [rad], from 0 to 0.5. By
            default the wall is smooth. The facets are those of `sampler.Table.rebound` with the
            same keys. A particle that leaves a facet into the wall hits again, with its new spin
            and inertia and the same grain.
        isotropic : bool, optional
            Whether facets are tilted across the plane of incidence too, and not only in it.
        works : float64 array of shape (n, 2), optional
            If given, the energies that the normal and the tangential impulses of the n rebounds
            took [J/kg] are written to it. Only for smooth walls.

        Returns
        -------
        DirectRebound
            ``velocity`` [m/s], ``omega`` [rad/s] and ``inertia`` over m a^2, in the lab frame.

        Raises
        ------
        InputError
            As for `sample`; also if a particle does not approach the wall, or if a normal is zero.
        RuntimeError
            As for `sample`.

        Notes
        -----
        At exactly normal impact the tangential velocity has no direction, so the keys draw one.

        Examples
        --------
        >>> from tablegen import DirectModel, load_config
        >>> model = DirectModel(load_config("corundum-steel"))
        >>> after = model.rebound([80.0, -60.0, 0.0], [0.0, 1.0, 0.0], 1e-5, seed=7, index=0)
        >>> after.velocity.shape, after.omega.shape, after.inertia.shape
        ((3,), (3,), ())
        """
        given = {"velocity": velocity, "normal": normal, "half_size": half_size}
        given |= present(wall_velocity=wall_velocity, omega=omega, inertia=inertia)
        isotropic = as_isotropic(isotropic, roughness)
        if roughness is not None and works is not None:
            problem = "cannot be computed for rough walls"
            raise InputError("works", problem=problem, remedy="leave works= or roughness= out")
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
        """Return the grains that particles keep from wall to wall.

        Parameters
        ----------
        seed : int
            Seed of the run.
        index : int or array of int
            Identity of each particle.

        Returns
        -------
        float64 array, shape (..., 3)
            Shape code, b/a and c/b. The shape codes are those of `tablegen.Simulation`: 64 + k
            for mesh number k of the population.

        Examples
        --------
        >>> from tablegen import DirectModel, load_config
        >>> model = DirectModel(load_config("corundum-steel"))
        >>> model.grains(7, [0, 1, 2]).shape
        (3, 3)
        """
        call = broadcast({}, Keys(seed, index))
        grains = DirectImpacts.from_call(call).grains(call.rows.n, self._arrays.population)
        return grains.reshape(*call.shape, 3)

    def _impacts(
        self, given: dict[str, Any], grain: Grain, keys: Keys
    ) -> tuple[Call, DirectImpacts]:
        """Broadcast the arguments; a spin or a wall velocity that is not given is zero."""
        check_grain_word(grain)
        drawn = isinstance(grain, str)
        fresh = drawn and grain == "fresh"
        call = broadcast(given if drawn else given | {"grain": grain}, keys, fresh)
        for name in ("omega", "wall_velocity") if "velocity" in given else ("spin",):
            call.rows.arrays.setdefault(name, np.zeros((1, 3)))
        call.rows.arrays.setdefault("inertia", np.zeros(1))
        impacts = DirectImpacts.from_call(call)
        if impacts.grain is not None:
            self._check_grains(call, impacts.grain)
        return call, impacts

    def _check_grains(self, call: Call, grains: FloatArray) -> None:
        """Refuse the first row that is not a grain of the population."""
        row = first_wrong_grain(self._arrays.population, grains)
        if row < 0:
            return
        given = ", ".join(f"{x:.9g}" for x in grains[row])
        or_mesh = " or mesh" if self._arrays.population.meshes.resolutions.size else ""
        ratios = f"b/a and c/b, both {ASPECT.words}, of a sphere 1"
        raise call.refusal(row, "grain", given, f"the code of a shape{or_mesh}, and {ratios}")

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
                rebounds(self._arrays, impacts.select(part), results.select(part))
            except Failure as failure:
                raise error_of_failure(call, part.start + failure.row, failure.code) from None

        for _ in in_slices(work, call.rows.n, as_threads(threads) or processors()):
            pass  # the results are written
        if call.rows.fresh:
            results.inertia[:] = 0.0
        bad = first_not_finite(results.states)
        if bad >= 0:
            raise RuntimeError(f"the particle at index {row_index(bad, call.shape)} is not finite")
        return results
