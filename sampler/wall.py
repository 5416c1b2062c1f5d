"""What a particle tracker needs beside a draw: torque of the gas, sizes, deposits, roughness.

The functions take numbers and arrays, and call the compiled library.
"""

import math
from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sampler.arguments import (
    VECTORS,
    as_finite,
    as_positive,
    as_reals_up_to,
    as_rows_of,
    common_shape,
    row_index,
)
from sampler.errors import InputError
from sampler.formats.bounds import SINGLE_ROUNDING
from sampler.formats.shape_geometry import Geometry
from sampler.library import library

Reals = NDArray[np.float64]

#: Arguments, but vectors, that may be 0.
_FROM_ZERO = ("time", "viscosity", "critical_speed", "ra", "rq", "poisson", "wall_poisson")

_AT_REST = (0.0, 0.0, 0.0)


def _checked(**given: ArrayLike) -> dict[str, Reals]:
    """Coerce vectors, and numbers that are positive or may be 0; raises `InputError`."""
    return {
        name: as_finite(name, values)
        if name in VECTORS
        else as_positive(name, values, 0.0 if name in _FROM_ZERO else math.ulp(0.0))
        for name, values in given.items()
    }


def _common(arrays: Mapping[str, Reals]) -> tuple[int, ...]:
    """Find the shape to which the rows of arguments broadcast; raises `InputError`."""
    tails = {name: name in VECTORS for name in arrays}
    return common_shape({name: a.shape[: a.ndim - tails[name]] for name, a in arrays.items()})


def _called(function: str, *tail: int, dtype: Any = np.float64, **given: ArrayLike) -> Any:
    """Call a function of sampler/c/library.c, given its arguments in order, on broadcast rows."""
    arrays = _checked(**given)
    shape = _common(arrays)
    rows = [
        np.ascontiguousarray(
            np.broadcast_to(array, shape + ((VECTORS[name],) if name in VECTORS else ()))
        )
        for name, array in arrays.items()
    ]
    results = np.empty((*shape, *tail), dtype)
    addresses = (array.ctypes.data for array in (*rows, results))
    getattr(library(), function)(math.prod(shape), *addresses)
    return results


def _by_rows(function: str, *tail: int, **given: ArrayLike) -> Any:
    """Call a function as `_called`; raises `InputError` if a result is not finite."""
    results = _called(function, *tail, **given)
    finite = np.isfinite(results)
    refused = ~(finite.all(axis=-1) if tail else finite)
    if refused.any():
        row = row_index(int(refused.argmax()), refused.shape) if refused.ndim else None
        problem = "the result is not a finite number"
        remedy = "check that these arguments are in SI units"
        raise InputError(", ".join(given), problem=problem, remedy=remedy, row=row)
    return results


def gas_torque(
    omega: ArrayLike,
    diameter: ArrayLike,
    density: ArrayLike,
    viscosity: ArrayLike,
    gas_rotation: ArrayLike = _AT_REST,
) -> Reals:
    """Compute the torque of the gas on spinning particles.

    Parameters
    ----------
    omega : array, shape (..., 3)
        Mean angular velocity of the particle over its tumbling, as a rebound gives it [rad/s].
    diameter : float or array, shape (...)
        Diameter of the sphere that has the volume of the particle [m].
    density : float or array, shape (...)
        Density of the gas [kg/m^3].
    viscosity : float or array, shape (...)
        Dynamic viscosity of the gas [Pa s]. With 0 there is no torque.
    gas_rotation : array, shape (..., 3), optional
        Angular velocity of the gas, half of the curl of its velocity [rad/s]. By default the gas
        does not rotate.

    Returns
    -------
    float64 array, shape (..., 3)
        Torque [N m].

    Raises
    ------
    InputError
        If an argument has a wrong type or shape, is not finite, or is below the smallest allowed
        value.

    Notes
    -----
    The torque is that on a sphere. With the slip ``s = gas_rotation - omega`` and the rotational
    Reynolds number ``Re = density diameter^2 |s| / viscosity``, Stokes' torque is ``pi viscosity
    diameter^3 s``. It holds for Re below 32. Above that it is multiplied by ``(12.9 sqrt(Re) +
    128.4) / (64 pi)``, which jumps by 0.2 % at Re = 32 and was computed for Re up to 1000. Above
    1000 the formula is extrapolated. Source: Dennis, Singh & Ingham, J. Fluid Mech. 101 (1980)
    257-279, in the form of Crowe, Schwarzkopf, Sommerfeld & Tsuji, "Multiphase Flows with Droplets
    and Particles".

    Examples
    --------
    A grain of 60 micrometres spins in air at rest:

    >>> import sampler
    >>> torque = sampler.gas_torque([0.0, 0.0, 1e5], 60e-6, density=1.2, viscosity=1.8e-5)
    >>> print(f"{torque[2]:.2e} N m")
    -1.22e-12 N m
    """
    gas = {"density": density, "viscosity": viscosity, "gas_rotation": gas_rotation}
    return _by_rows("rbt_gas_torque_rows", 3, omega=omega, diameter=diameter, **gas)


def spin_after(
    omega: ArrayLike,
    time: ArrayLike,
    moment: ArrayLike,
    diameter: ArrayLike,
    density: ArrayLike,
    viscosity: ArrayLike,
    gas_rotation: ArrayLike = _AT_REST,
) -> Reals:
    """Compute the spin that the torque of the gas leaves after a time of flight.

    Call it just before a rebound, with the time since the last one. The solution of the equation of
    motion is exact, so one call for a whole flight gives the same as many short steps, as long as
    the gas stays the same on the way.

    Parameters
    ----------
    omega : array, shape (..., 3)
        Mean angular velocity at the beginning, as a rebound gives it [rad/s].
    time : float or array, shape (...)
        Time of flight [s].
    moment : float or array, shape (...)
        Moment of inertia of the particle about its spin [kg m^2]: k m a^2, with the inertia k that
        a rebound gives (`Rebound.inertia`), the mass m and the largest half-size a. If k is 0, take
        `sampler.mean_inertia` of the grain in its place.
    diameter, density, viscosity, gas_rotation
        As for `gas_torque`.

    Returns
    -------
    float64 array, shape (..., 3)
        Mean angular velocity at the end [rad/s].

    Raises
    ------
    InputError
        As for `gas_torque`.

    Notes
    -----
    The torque is that of `gas_torque`. It also moves the inertia k slowly towards the largest
    moment of inertia of the grain, which is neglected.

    Examples
    --------
    >>> import sampler
    >>> air = {"density": 1.2, "viscosity": 1.8e-5}
    >>> omega = sampler.spin_after(
    ...     [0.0, 0.0, 1e5], time=1e-3, moment=5e-22, diameter=20e-6, **air
    ... )
    >>> print(f"{omega[2]:.0f} rad/s")
    40463 rad/s
    """
    gas = {"density": density, "viscosity": viscosity, "gas_rotation": gas_rotation}
    given = {"omega": omega, "time": time, "moment": moment, "diameter": diameter}
    return _by_rows("rbt_spin_after_rows", 3, **given, **gas)


class HasGrains(Protocol):
    """A `Table` or a `tablegen.DirectModel`."""

    @property
    def shape_geometry(self) -> Mapping[int, Geometry]:
        """Volume, moment of inertia and surface of its shapes and meshes, by shape code."""


def half_size(table: HasGrains, diameter: ArrayLike, grain: ArrayLike) -> Reals:
    """Compute the largest half-size of grains from the diameter of a sphere of equal volume.

    Parameters
    ----------
    table : Table or tablegen.DirectModel
        Table or direct model to which the grains belong.
    diameter : float or array, shape (...)
        Diameter of the sphere that has the volume of the grain [m].
    grain : array, shape (..., 3)
        Shape code, b/a and c/b, as `Table.grains` gives them.

    Returns
    -------
    float64 array, shape (...)
        Half of the longest dimension of the grain, a [m].

    Raises
    ------
    InputError
        If a diameter is not positive, or if the table does not have a shape.

    Examples
    --------
    >>> import sampler
    >>> spheres = sampler.load("kharaz-2001")
    >>> sampler.half_size(spheres, 60e-6, [4, 1.0, 1.0])
    array(3.e-05)
    """
    return _by_rows("rbt_half_size_rows", **_size_arguments(table, grain, diameter=diameter))


def mean_inertia(table: HasGrains, grain: ArrayLike) -> Reals:
    """Compute the mean moment of inertia of grains over m a^2.

    It takes the place of the inertia about the spin if that is not known.

    Parameters
    ----------
    table : Table or tablegen.DirectModel
        Table or direct model to which the grains belong.
    grain : array, shape (..., 3)
        Shape code, b/a and c/b, as for `half_size`.

    Returns
    -------
    float64 array, shape (...)
        Mean of the three principal moments, divided by the mass and the square of the largest
        half-size a.

    Raises
    ------
    InputError
        As for `half_size`.

    Examples
    --------
    >>> import sampler
    >>> sampler.mean_inertia(sampler.load("kharaz-2001"), [4, 1.0, 1.0])  # a sphere
    array(0.4)
    """
    return _by_rows("rbt_mean_inertia_rows", **_size_arguments(table, grain))


def sphericity(table: HasGrains, grain: ArrayLike) -> Reals:
    """Compute the sphericity of grains, for laws of drag.

    Parameters
    ----------
    table : Table or tablegen.DirectModel
        Table or direct model to which the grains belong.
    grain : array, shape (..., 3)
        Shape code, b/a and c/b, as for `half_size`.

    Returns
    -------
    float64 array, shape (...)
        Surface of the sphere of equal volume, divided by the surface of the grain.

    Raises
    ------
    InputError
        As for `half_size`.

    Notes
    -----
    The surface of an ellipsoid is computed after Carlson, Numer. Algorithms 10 (1995) 13-26.

    Examples
    --------
    >>> import sampler
    >>> table = sampler.load("corundum-steel-compact")
    >>> print(f"{sampler.sphericity(table, [1, 1.0, 1.0]):.3f}")  # a cube
    0.806
    """
    return _by_rows("rbt_sphericity_rows", **_size_arguments(table, grain))


def _size_arguments(table: HasGrains, grain: ArrayLike, **given: ArrayLike) -> dict[str, ArrayLike]:
    """Find the geometry of grains, and return the arguments of a function in C, in order.

    Refuses shapes that the table does not have, and ratios that no grain has.
    """
    rows = as_finite("grain", grain)
    codes, ratios = rows[..., 0], rows[..., 1:]
    usable = np.isin(codes, list(table.shape_geometry))
    usable &= ((ratios > 0.0) & (ratios <= 1.0 + SINGLE_ROUNDING)).all(axis=-1)
    if not usable.all():
        row = int(np.argmin(usable))
        refused = ", ".join(f"{x:.9g}" for x in rows.reshape(-1, 3)[row])
        known = ", ".join(map(str, table.shape_geometry)) or "no spin law, so none"
        allowed = f"a shape code of the table ({known}), and b/a and c/b above 0 and at most 1"
        index = row_index(row, usable.shape) if usable.ndim else None
        raise InputError("grain", refused, allowed, row=index)
    kinds, places = np.unique(codes, return_inverse=True)
    geometry = np.array([table.shape_geometry[int(code)] for code in kinds]).reshape(-1, 4)
    return {"geometry": geometry[places].reshape(*codes.shape, 4), **given, "grain": rows}


def critical_speed(
    diameter: ArrayLike,
    density: ArrayLike,
    young: ArrayLike,
    poisson: ArrayLike,
    wall_young: ArrayLike,
    wall_poisson: ArrayLike,
) -> Reals:
    """Compute the normal speed below which dry elastic spheres stay on a smooth wall.

    Parameters
    ----------
    diameter, density : float or array, shape (...)
        Diameter [m] and density [kg/m^3] of the particles.
    young, poisson : float or array, shape (...)
        Young's modulus [Pa] and Poisson's ratio of the particles; Poisson's ratio is from 0 to 0.5.
    wall_young, wall_poisson : float or array, shape (...)
        The same for the wall.

    Returns
    -------
    float64 array, shape (...)
        Normal speed of approach [m/s]; pass it to `deposits`.

    Raises
    ------
    InputError
        If an argument has a wrong type or shape, or a value that is not allowed.

    Notes
    -----
    The speed is ``(2 E / diameter)^(10/7)``, with ``E = 0.51 (5 pi^2 (k + k') / (4
    density^(3/2)))^(2/5)`` in SI units and ``k = (1 - poisson^2) / (pi young)``; k' is that of the
    wall. Source: Brach & Dunn, Aerosol Sci. Technol. 16 (1992) 51-64, in the form of El-Batsh
    (dissertation, TU Wien, 2001). Humidity, charge and softening let particles stay at higher
    speeds.

    Examples
    --------
    Quartz of 10 micrometres on steel:

    >>> import sampler
    >>> speed = sampler.critical_speed(10e-6, 2650.0, 95e9, 0.1, wall_young=200e9, wall_poisson=0.3)
    >>> print(f"{speed:.4f} m/s")
    0.0237 m/s
    """
    return _by_rows(
        "rbt_critical_speed_rows",
        diameter=diameter,
        density=density,
        young=young,
        poisson=as_reals_up_to("poisson", poisson, 0.5),
        wall_young=wall_young,
        wall_poisson=as_reals_up_to("wall_poisson", wall_poisson, 0.5),
    )


def deposits(
    velocity: ArrayLike,
    normal: ArrayLike,
    critical_speed: ArrayLike,
    *,
    wall_velocity: ArrayLike = _AT_REST,
) -> NDArray[np.bool_]:
    """Tell which particles stay on the wall that they meet.

    Call it before the rebound, and do not let the particles rebound that stay.

    Parameters
    ----------
    velocity, normal : array, shape (..., 3)
        Velocity before the impact [m/s] and normal of the wall, as for `Table.rebound`.
    critical_speed : float or array, shape (...)
        Normal speed of approach below which a particle stays [m/s]; see `critical_speed`.
    wall_velocity : array, shape (..., 3), optional
        Velocity of the wall [m/s]. By default the wall is at rest.

    Returns
    -------
    bool array, shape (...)
        True if the particle stays. A particle that moves away from the wall does not stay.

    Raises
    ------
    InputError
        If an argument has a wrong type or shape, or a normal is zero.

    Examples
    --------
    >>> import sampler
    >>> sampler.deposits([[80.0, -0.01, 0.0], [80.0, -5.0, 0.0]], [0.0, 1.0, 0.0], 0.0237)
    array([ True, False])
    """
    if not as_rows_of("normal", normal).any(axis=-1).all():
        raise InputError("normal", "a vector of length zero", "any length but zero")
    given = {"velocity": velocity, "normal": normal, "critical_speed": critical_speed}
    return _called("rbt_deposits_rows", dtype=np.bool_, **given, wall_velocity=wall_velocity)


def wall_tilt(ra: ArrayLike, rq: ArrayLike, rsm: ArrayLike, diameter: ArrayLike) -> Reals:
    """Compute the roughness of a wall from a measured profile.

    Pass the result to `Table.rebound` as ``roughness``: it is the standard deviation of the random
    tilt of the wall's facets. The result depends on the size of the particle.

    Parameters
    ----------
    ra, rq : float or array, shape (...)
        Mean and root mean square of the profile's height (ISO 21920-2, ISO 4287), 0 or more. In
        every profile rq is at least ra; an rq that is smaller by more than 1 % is refused.
    rsm : float or array, shape (...)
        Mean width of the profile's elements, above 0.
    diameter : float or array, shape (...)
        Diameter of the particles, above 0. All four lengths are in the same unit.

    Returns
    -------
    float64 array, shape (...)
        Standard deviation of the tilt [rad], at most 0.5.

    Raises
    ------
    InputError
        If an argument has a wrong type, shape or value, or if the tilt is above 0.5 rad.

    Notes
    -----
    A particle with a diameter below ``RSm / sin(atan(2 Ra / RSm))`` meets the flanks of the
    profile's elements, which have the tilt ``atan(2 Ra / RSm)``. For a larger particle the tilt is
    ``atan(2 Rq / RSm)``. Source: Sommerfeld & Huber, "Experimental analysis and modelling of
    particle-wall collisions", Int. J. Multiphase Flow 25 (1999) 1457-1489.

    Examples
    --------
    >>> import numpy as np
    >>> import sampler
    >>> tilt = sampler.wall_tilt(ra=2e-6, rq=2.5e-6, rsm=50e-6, diameter=60e-6)
    >>> print(f"{np.degrees(tilt):.1f} degrees")
    4.6 degrees
    """
    given = _checked(ra=ra, rq=rq, rsm=rsm, diameter=diameter)
    _common(given)
    below = np.atleast_1d(given["rq"] < 0.99 * given["ra"])
    if below.any():
        row = int(below.argmax())
        mean, root_mean_square = (
            np.broadcast_to(given[name], below.shape).flat[row] for name in ("ra", "rq")
        )
        allowed = f"ra = {mean:.9g} or more, as in every profile"
        raise InputError("rq", f"{root_mean_square:.9g}", allowed)
    tilts = _called("rbt_wall_tilt_rows", **given)
    refused = np.isnan(tilts)
    if refused.any():
        row = int(refused.argmax())
        each = (np.broadcast_to(array, tilts.shape).flat[row] for array in given.values())
        values = ", ".join(f"{x:.9g}" for x in each)
        raise InputError("ra, rq, rsm, diameter", values, "tilts up to 0.5 rad")
    return tilts
