"""The impact speeds at which measured rebounds are simulated."""

import numpy as np

from sampler.errors import InputError
from tablegen.config.pairs import MaterialPair
from tablegen.measured.records import Measurements
from tablegen.model.float_array import FloatArray

#: Speed [m/s] of rows without one where every speed gives the same rebounds.
_ANY_SPEED = 100.0


def impact_speeds(
    pair: MaterialPair, measured: Measurements, speed: float | None = None
) -> FloatArray:
    """Speed of each row.

    Parameters
    ----------
    pair : MaterialPair
        Laws of restitution and of resistance.
    measured : Measurements
    speed : float, optional
        Speed of the rows that state none, m/s.

    Returns
    -------
    (n,) float64
        m/s.

    Raises
    ------
    InputError
        If a row states none, none is given, and the rebounds depend on it.
    """
    unstated = np.isnan(measured.speed)
    if speed is None and unstated.any() and pair.restitution.depends_on_speed:
        raise InputError(
            f"speed: missing for {unstated.sum()} of {unstated.size} rows of {measured.name}, "
            "allowed: the speed of those rows in m/s, because the restitution depends on it"
        )
    return np.where(unstated, _ANY_SPEED if speed is None else speed, measured.speed)
