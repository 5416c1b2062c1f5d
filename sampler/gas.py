"""The gas and the spin of a particle between walls: the functions of the C header, for arrays."""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sampler.arguments import as_positive, as_reals, as_rows_of

Reals = NDArray[np.float64]

#: Over the torque of Stokes, from this Reynolds number on: A + B sqrt(Re).
_FROM, _A, _B = 32.0, 128.4 / (64.0 * math.pi), 12.9 / (64.0 * math.pi)
_AT_REST = (0.0, 0.0, 0.0)


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
        Of the gas, kg/m3 and Pa s.
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
    slip, reynolds, stokes = _slip(omega, gas_rotation, diameter, density, viscosity)
    law = np.where(reynolds < _FROM, 1.0, _A + _B * np.sqrt(reynolds))
    return (stokes * law)[..., None] * slip


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

    The solution is exact: time steps of any size give the same, and none overshoots. `inertia` is
    the moment of inertia, kg m2: mass diameter^2 / 10 for a sphere. All others as of `gas_torque`.
    """
    slip, reynolds, stokes = _slip(omega, gas_rotation, diameter, density, viscosity)
    times = stokes / as_positive("inertia", inertia) * as_positive("time", time, least=0.0)
    # root' = -(A + B root) root / 2 in relaxation times of Stokes, until root^2 = 32
    root, last = np.sqrt(np.maximum(reynolds, _FROM)), math.sqrt(_FROM)
    until = 2.0 / _A * np.log(root * (_A + _B * last) / (last * (_A + _B * root)))
    gone = np.expm1(-0.5 * _A * np.minimum(times, until))
    share = _A * (1.0 + gone) / (_A - _B * root * gone)
    left = share * share * np.exp(np.minimum(until - times, 0.0))
    return as_reals("gas_rotation", gas_rotation) - left[..., None] * slip


def _slip(
    omega: ArrayLike, gas_rotation: ArrayLike, *others: ArrayLike
) -> tuple[Reals, Reals, Reals]:
    """Rotation of the gas less that of the particle, its Reynolds number, and pi mu d^3."""
    slip = as_reals("gas_rotation", gas_rotation) - as_rows_of("omega", omega)
    size = np.sqrt(slip[..., 0] ** 2 + slip[..., 1] ** 2 + slip[..., 2] ** 2)
    d, rho, mu = map(as_positive, ("diameter", "density", "viscosity"), others)
    return slip, rho * d * d * size / mu, np.pi * mu * d * d * d
