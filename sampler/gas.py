"""The gas and the spin of a particle between walls: the functions of the C header, for arrays."""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sampler.arguments import as_reals, as_rows_of, place
from sampler.errors import refuse

Reals = NDArray[np.float64]

#: Over the torque of Stokes, from this Reynolds number on: A + B sqrt(Re).
_FROM, _A, _B = 32.0, 128.4 / (64.0 * math.pi), 12.9 / (64.0 * math.pi)


def gas_torque(
    omega: ArrayLike,
    diameter: ArrayLike,
    density: ArrayLike,
    viscosity: ArrayLike,
    gas_rotation: ArrayLike = (0.0, 0.0, 0.0),
) -> Reals:
    """Compute the torque of the gas on spinning particles, N m.

    Arguments broadcast as in numpy.

    Parameters
    ----------
    omega : array, shape (..., 3)
        Angular velocity, rad/s, as a rebound gives it: the mean over the particle's tumbling.
    diameter : float or array, shape (...)
        Of the sphere of equal volume, m.
    density, viscosity : float or array, shape (...)
        Of the gas, kg/m3 and Pa s.
    gas_rotation : array, shape (..., 3)
        Half the curl of the gas velocity, rad/s.

    Returns
    -------
    float64 array, shape (..., 3)

    Raises
    ------
    InputError
        If a diameter, density or viscosity is not a finite number above 0.

    Notes
    -----
    The torque is that on a sphere that turns in a gas at rest: Stokes', pi viscosity diameter^3
    slip with slip = gas_rotation - omega, below Re = density diameter^2 |slip| / viscosity = 32;
    from there on times (12.9 sqrt(Re) + 128.4) / (64 pi), which jumps by 0.2 % at 32. It holds up to
    Re = 1000; beyond, the same formula extrapolates, to the law of a laminar boundary layer.
    Source: Dennis, Singh & Ingham, J. Fluid Mech. 101 (1980) 257-279, in the form of Crowe,
    Schwarzkopf, Sommerfeld & Tsuji, "Multiphase Flows with Droplets and Particles".
    """
    slip, reynolds, stokes = _slip(omega, diameter, density, viscosity, gas_rotation)
    law = np.where(reynolds < _FROM, 1.0, _A + _B * np.sqrt(reynolds))
    return (stokes * law)[..., None] * slip


def spin_after(
    omega: ArrayLike,
    time: ArrayLike,
    inertia: ArrayLike,
    diameter: ArrayLike,
    density: ArrayLike,
    viscosity: ArrayLike,
    gas_rotation: ArrayLike = (0.0, 0.0, 0.0),
) -> Reals:
    """Compute the angular velocity that `gas_torque` leaves after a time, rad/s.

    The solution is exact: time steps of any size give the same, and none overshoots.

    Parameters
    ----------
    omega, diameter, density, viscosity, gas_rotation
        As of `gas_torque`.
    time : float or array, shape (...)
        s, not negative.
    inertia : float or array, shape (...)
        Moment of inertia, kg m2; mass diameter^2 / 10 for a sphere.

    Returns
    -------
    float64 array, shape (..., 3)
    """
    slip, reynolds, stokes = _slip(omega, diameter, density, viscosity, gas_rotation)
    times = stokes / _checked("inertia", inertia) * _checked("time", time, least=0.0)
    # root' = -(A + B root) root / 2 in relaxation times of Stokes, until root^2 = 32
    root, last = np.sqrt(np.maximum(reynolds, _FROM)), math.sqrt(_FROM)
    until = 2.0 / _A * np.log(root * (_A + _B * last) / (last * (_A + _B * root)))
    gone = np.expm1(-0.5 * _A * np.minimum(times, until))
    share = _A * (1.0 + gone) / (_A - _B * root * gone)
    left = share * share * np.exp(np.minimum(until - times, 0.0))
    return as_reals("gas_rotation", gas_rotation) - left[..., None] * slip


def _slip(
    omega: ArrayLike,
    diameter: ArrayLike,
    density: ArrayLike,
    viscosity: ArrayLike,
    gas_rotation: ArrayLike,
) -> tuple[Reals, Reals, Reals]:
    """Rotation of the gas less that of the particle, its Reynolds number, and Stokes' torque."""
    slip = as_reals("gas_rotation", gas_rotation) - as_rows_of("omega", omega)
    size = np.sqrt(slip[..., 0] ** 2 + slip[..., 1] ** 2 + slip[..., 2] ** 2)
    d, mu = _checked("diameter", diameter), _checked("viscosity", viscosity)
    return slip, _checked("density", density) * d * d * size / mu, np.pi * mu * d * d * d


def _checked(name: str, values: ArrayLike, least: float = math.ulp(0.0)) -> Reals:
    """Coerce real numbers, and refuse the first that is not finite or below the least."""
    array = as_reals(name, values)
    refused = ~((array >= least) & np.isfinite(array))
    if refused.any():
        k = int(refused.argmax())
        where = f" at {place(k, array.shape)}" if array.ndim else ""
        allowed = "a finite number, 0 or more" if least == 0.0 else "a finite number above 0"
        refuse(name, f"{float(array.flat[k]):.9g}{where}", allowed)
    return array
