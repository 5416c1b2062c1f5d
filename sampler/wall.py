"""Sizes of grains, and particles that stay on a wall: functions of the C header, for arrays."""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sampler.arguments import as_positive, as_reals, as_reals_up_to, as_rows_of
from sampler.errors import refuse
from sampler.formats.shape_codes import SHAPE_CODES, SHAPE_NAMES

Reals = NDArray[np.float64]

#: Volumes of the shapes over a b c, by their codes; of a truncated prism with the default cut.
_VOLUMES = np.array(
    [math.pi / 0.75, 8.0, 8.0 - (2.0 - math.sqrt(2.0)) ** 3 / 0.75, 8.0 / 3.0, math.pi / 0.75]
)


def half_size(diameter: ArrayLike, shape: str | ArrayLike, ratios: ArrayLike) -> Reals:
    """Compute the largest half-size a of grains with the volume of a sphere, m.

    Parameters
    ----------
    diameter : float or array, shape (...)
        Of the sphere, m.
    shape : str, or int or array of int, shape (...)
        "ellipsoid", "prism", "truncated-prism", "tetrahedron" or "sphere", or their codes, the
        first column of `Table.grains`. Meshes are refused: no table has their volume.
    ratios : array, shape (..., 2)
        b/a and c/b, above 0 and at most 1: the other columns of `Table.grains`.

    Returns
    -------
    float64 array, shape (...)
    """
    known = ", ".join(f"{SHAPE_CODES[name]} {name}" for name in SHAPE_NAMES)
    codes = as_reals("shape", SHAPE_CODES.get(shape, -1) if isinstance(shape, str) else shape)
    refused = ~np.isin(codes, range(len(_VOLUMES)))
    if refused.any():
        refuse("shape", shape if isinstance(shape, str) else f"{codes[refused][0]:g}", known)
    parts = as_reals("ratios", ratios)
    refused = ~((parts > 0.0) & (parts <= 1.0))
    if parts.shape[-1:] != (2,) or refused.any():
        got = f"{parts[refused][0]:.9g}" if refused.any() else f"shape {parts.shape}"
        refuse("ratios", got, "b/a and c/b, above 0 and at most 1, shape (..., 2)")
    volume = _VOLUMES[codes.astype(int)] * parts[..., 0] ** 2 * parts[..., 1]
    return 0.5 * as_positive("diameter", diameter) * np.cbrt(4.0 / 3.0 * math.pi / volume)


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
    soft = [
        (1.0 - as_reals_up_to(f"{of}poisson", ratio, 0.5) ** 2)
        / (math.pi * as_positive(f"{of}young", modulus))
        for of, ratio, modulus in (("", poisson, young), ("wall_", wall_poisson, wall_young))
    ]
    over = as_positive("density", density) ** 1.5
    e = 0.51 * (1.25 * math.pi**2 * (soft[0] + soft[1]) / over) ** 0.4
    return (2.0 * e / as_positive("diameter", diameter)) ** (10.0 / 7.0)


def deposits(
    velocity: ArrayLike,
    normal: ArrayLike,
    critical_speed: ArrayLike,
    *,
    wall_velocity: ArrayLike = (0.0, 0.0, 0.0),
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
    relative = as_rows_of("velocity", velocity) - as_rows_of("wall_velocity", wall_velocity)
    along = as_rows_of("normal", normal)
    length = np.linalg.norm(along, axis=-1)
    if not (length > 0.0).all():
        refuse("normal", "a vector of length zero", "any length but zero")
    approach = -(relative * along).sum(axis=-1) / length
    return (approach > 0.0) & (approach < as_positive("critical_speed", critical_speed, 0.0))
