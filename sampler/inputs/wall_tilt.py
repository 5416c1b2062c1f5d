"""The roughness of a wall from its measured profile."""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sampler.arguments import MAX_ROUGHNESS, as_reals, place, told_apart
from sampler.errors import InputError


def wall_tilt(ra: float, rq: float, rsm: float, diameter: ArrayLike) -> NDArray[np.float64]:
    """Give the standard deviation of the tilt of facets, for `Table.rebound` as `roughness`.

    It is atan(2 Ra / RSm) for a particle with a diameter below RSm / sin(atan(2 Ra / RSm)), which
    meets the flanks of the profile's elements, and atan(2 Rq / RSm) for a larger one. All lengths
    are in the same unit.

    Parameters
    ----------
    ra, rq : float
        Mean and root mean square of the profile's height (ISO 21920-2, ISO 4287), not negative.
        That Rq is not below Ra, which holds for every profile, is not checked.
    rsm : float
        Mean width of the profile's elements, above 0.
    diameter : float or array, shape (...)
        Of the particles, above 0.

    Returns
    -------
    float64 array, shape (...)
        rad.

    Raises
    ------
    InputError
        If a length is not finite or not allowed, or the tilt of one of the particles is above
        0.5 rad, beyond which a normal law of tilts describes no surface.

    Notes
    -----
    Source: Sommerfeld & Huber, "Experimental analysis and modelling of particle-wall collisions",
    Int. J. Multiphase Flow 25 (1999) 1457-1489, as codes for inlet separators take it.
    """
    for name, value, least in (("ra", ra, 0.0), ("rq", rq, 0.0), ("rsm", rsm, math.ulp(0.0))):
        _check_lengths(name, as_reals(name, value), least)
        if np.ndim(value):
            raise InputError(f"{name}: got shape {np.shape(value)}, allowed: one number")
    diameters = as_reals("diameter", diameter)
    _check_lengths("diameter", diameters, math.ulp(0.0))
    # by the C library, as the header does: numpy's functions differ in the last digits
    flank, whole = math.atan(2.0 * float(ra) / float(rsm)), math.atan(2.0 * float(rq) / float(rsm))
    tilts = np.where(diameters * math.sin(flank) < rsm, flank, whole)
    if (tilts > MAX_ROUGHNESS).any():
        got = float(tilts.max())
        lengths = f"ra {ra:.9g}, rq {rq:.9g}, rsm {rsm:.9g}"
        raise InputError(
            f"ra, rq, rsm: got {lengths}, a tilt of {told_apart(got, MAX_ROUGHNESS)} rad, "
            f"allowed: a tilt up to {MAX_ROUGHNESS:g} rad"
        )
    return tilts


def _check_lengths(name: str, values: NDArray[np.float64], least: float) -> None:
    """Refuse the first length that is not finite, or below the least."""
    refused = ~((values >= least) & np.isfinite(values))
    if refused.any():
        k = int(refused.argmax())
        where = f" at {place(k, values.shape)}" if values.ndim else ""
        allowed = "a finite number, 0 or more" if least == 0.0 else "a finite number above 0"
        raise InputError(f"{name}: got {float(values.flat[k]):.9g}{where}, allowed: {allowed}")
