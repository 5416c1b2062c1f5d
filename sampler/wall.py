"""Around the wall: the gas and the spin, sizes of grains, deposits, profiles; by C, for arrays."""

import math
from typing import Any

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
from sampler.formats.shape_codes import SHAPE_CODES, SHAPE_NAMES
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


def _by_rows(function: str, *tail: int, dtype: Any = np.float64, **given: ArrayLike) -> Any:
    """Call a function of sampler/c/library.c, given its arguments in order, on broadcast rows."""
    arrays = _checked(**given)
    tails = {name: (VECTORS[name],) if name in VECTORS else () for name in arrays}
    shape = common_shape({name: a.shape[: a.ndim - len(tails[name])] for name, a in arrays.items()})
    rows = [
        np.ascontiguousarray(np.broadcast_to(array, shape + tails[name]))
        for name, array in arrays.items()
    ]
    results = np.empty((*shape, *tail), dtype)
    addresses = (array.ctypes.data for array in (*rows, results))
    getattr(library(), function)(math.prod(shape), *addresses)
    return results


def gas_torque(
    omega: ArrayLike,
    diameter: ArrayLike,
    density: ArrayLike,
    viscosity: ArrayLike,
    gas_rotation: ArrayLike = _AT_REST,
) -> Reals:
    """Compute the torque of the gas on spinning particles, N m.

    Parameters
    ----------
    omega : array, shape (..., 3)
        Angular velocity, rad/s, as a rebound gives it: the mean over the particle's tumbling.
    diameter : float or array, shape (...)
        Of the sphere of equal volume, m.
    density, viscosity : float or array, shape (...)
        Of the gas, kg/m3 and Pa s; without viscosity, 0, there is no torque.
    gas_rotation : array, shape (..., 3)
        Half the curl of the gas velocity, rad/s.

    Returns
    -------
    float64 array, shape (..., 3)

    Notes
    -----
    It is the torque on a sphere: that of Stokes, pi viscosity diameter^3 slip with slip =
    gas_rotation - omega, where Re = density diameter^2 ``|slip|`` / viscosity is below 32; beyond
    times (12.9 sqrt(Re) + 128.4) / (64 pi), which jumps by 0.2 % at 32. It holds up to Re = 1000;
    beyond, the formula extrapolates. Source: Dennis, Singh & Ingham, J. Fluid Mech. 101 (1980)
    257-279, in the form of Crowe, Schwarzkopf, Sommerfeld & Tsuji, "Multiphase Flows with Droplets
    and Particles".
    """
    gas = {"density": density, "viscosity": viscosity, "gas_rotation": gas_rotation}
    return _by_rows("rbt_gas_torque_rows", 3, omega=omega, diameter=diameter, **gas)


def spin_after(
    omega: ArrayLike,
    time: ArrayLike,
    inertia: ArrayLike,
    diameter: ArrayLike,
    density: ArrayLike,
    viscosity: ArrayLike,
    gas_rotation: ArrayLike = _AT_REST,
) -> Reals:
    """Compute the angular velocity that `gas_torque` leaves after a time [s], rad/s.

    The solution is exact: time steps of any size give the same, and none overshoots; where the gas
    turns evenly, one call for a whole flight will do. `inertia` is the particle's own moment of
    inertia, kg m2: k m a^2 with the k that a rebound gives (`Rebound.inertia`), or `inertia` of the
    grain times m a^2 where it is not known. All others as of `gas_torque`.
    """
    gas = {"density": density, "viscosity": viscosity, "gas_rotation": gas_rotation}
    given = {"omega": omega, "time": time, "inertia": inertia, "diameter": diameter}
    return _by_rows("rbt_spin_after_rows", 3, **given, **gas)


def half_size(diameter: ArrayLike, grain: ArrayLike) -> Reals:
    """Compute the largest half-size a of grains with the volume of a sphere, m.

    Parameters
    ----------
    diameter : float or array, shape (...)
        Of the sphere, m.
    grain : array, shape (..., 3)
        Shape code, b/a and c/b, as `Table.grains` gives them. Meshes are refused: no table has
        their volume.

    Returns
    -------
    float64 array, shape (...)
    """
    return _by_rows("rbt_half_size_rows", diameter=diameter, grain=_known(grain))


def inertia(grain: ArrayLike) -> Reals:
    """Compute the mean moment of inertia of grains over m a^2, for those whose own is not known.

    ``grain`` is as in `half_size`; the result has shape (...).
    """
    return _by_rows("rbt_inertia_rows", grain=_known(grain))


def sphericity(grain: ArrayLike) -> Reals:
    """Compute the surface of the sphere of equal volume over that of grains, for laws of drag.

    ``grain`` is as in `half_size`; the result has shape (...). Source of the law of ellipsoids:
    Carlson, Numer. Algorithms 10 (1995) 13-26.
    """
    return _by_rows("rbt_sphericity_rows", grain=_known(grain))


def _known(grain: ArrayLike) -> Reals:
    """Coerce grains; refuse meshes, and ratios that no grain has."""
    rows = as_finite("grain", grain)
    codes, ratios = rows[..., 0], rows[..., 1:]
    usable = np.isin(codes, [SHAPE_CODES[name] for name in SHAPE_NAMES])
    usable &= ((ratios > 0.0) & (ratios <= 1.0 + SINGLE_ROUNDING)).all(axis=-1)
    if not usable.all():
        row = int(np.argmin(usable))
        given = ", ".join(f"{x:.9g}" for x in rows.reshape(-1, 3)[row])
        known = ", ".join(f"{SHAPE_CODES[name]} {name}" for name in SHAPE_NAMES)
        allowed = f"a code ({known}), and b/a and c/b above 0 and at most 1"
        index = row_index(row, usable.shape) if usable.ndim else None
        raise InputError("grain", given, allowed, row=index)
    return rows


def critical_speed(
    diameter: ArrayLike,
    density: ArrayLike,
    young: ArrayLike,
    poisson: ArrayLike,
    wall_young: ArrayLike,
    wall_poisson: ArrayLike,
) -> Reals:
    """Compute the normal speed below which smooth dry elastic spheres stay on a wall, m/s.

    Parameters
    ----------
    diameter, density : float or array, shape (...)
        Of the particles, m and kg/m3.
    young, poisson, wall_young, wall_poisson : float or array, shape (...)
        Young's modulus, Pa, and Poisson's ratio of particles and wall.

    Returns
    -------
    float64 array, shape (...)

    Notes
    -----
    (2 E / diameter)^(10/7) with E = 0.51 (5 pi^2 (k + k') / (4 density^(3/2)))^(2/5) in SI units
    and k = (1 - poisson^2) / (pi young), k' of the wall. Source: Brach & Dunn, Aerosol Sci.
    Technol. 16 (1992) 51-64, as El-Batsh takes it (dissertation, TU Wien, 2001).
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
    """Tell which particles stay on the wall that they meet; ask before the rebound.

    Parameters
    ----------
    velocity, normal, wall_velocity : array, shape (..., 3)
        As for `Table.rebound`.
    critical_speed : float or array, shape (...)
        Particles stay that approach at a lower normal speed, m/s; see `critical_speed`.

    Returns
    -------
    bool array, shape (...)
        Particles that leave the wall already do not stay.
    """
    if not as_rows_of("normal", normal).any(axis=-1).all():
        raise InputError("normal", "a vector of length zero", "any length but zero")
    given = {"velocity": velocity, "normal": normal, "critical_speed": critical_speed}
    return _by_rows("rbt_deposits_rows", dtype=np.bool_, **given, wall_velocity=wall_velocity)


def wall_tilt(ra: ArrayLike, rq: ArrayLike, rsm: ArrayLike, diameter: ArrayLike) -> Reals:
    """Compute the standard deviation of the tilt of facets, for `Table.rebound` as `roughness`.

    It is atan(2 Ra / RSm) for a particle with a diameter below RSm / sin(atan(2 Ra / RSm)), which
    meets the flanks of the profile's elements, and atan(2 Rq / RSm) for a larger one. All lengths
    are in the same unit.

    Parameters
    ----------
    ra, rq : float or array, shape (...)
        Mean and root mean square of the profile's height (ISO 21920-2, ISO 4287), not negative.
        Rq below Ra, which no profile has, is refused; 1 % is left to rounded digits.
    rsm : float or array, shape (...)
        Mean width of the profile's elements, above 0.
    diameter : float or array, shape (...)
        Of the particles, above 0.

    Returns
    -------
    float64 array, shape (...)
        rad. Tilts above 0.5 are refused.

    Notes
    -----
    Source: Sommerfeld & Huber, "Experimental analysis and modelling of particle-wall collisions",
    Int. J. Multiphase Flow 25 (1999) 1457-1489.
    """
    given = _checked(ra=ra, rq=rq, rsm=rsm, diameter=diameter)
    below = np.atleast_1d(given["rq"] < 0.99 * given["ra"])
    if below.any():
        row = int(below.argmax())
        mean, root_mean_square = (
            np.broadcast_to(given[name], below.shape).flat[row] for name in ("ra", "rq")
        )
        allowed = f"ra = {mean:.9g} or more, as in every profile"
        raise InputError("rq", f"{root_mean_square:.9g}", allowed)
    tilts = _by_rows("rbt_wall_tilt_rows", **given)
    refused = np.isnan(tilts)
    if refused.any():
        row = int(refused.argmax())
        each = (np.broadcast_to(array, tilts.shape).flat[row] for array in given.values())
        values = ", ".join(f"{x:.9g}" for x in each)
        raise InputError("ra, rq, rsm, diameter", values, "tilts up to 0.5 rad")
    return tilts
