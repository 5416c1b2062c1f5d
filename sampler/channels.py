"""Channels: the six numbers in which a table describes one rebound.

A table does not hold u, v, w themselves but shares of the translational energy that is still
to be given out ("stick-breaking"): v is taken as it is, then

    u = u_hat sqrt(1 - v^2),        w = w_hat sqrt(1 - v^2 - u^2).

For 0 < v < 1, |u_hat| < 1 and |w_hat| < 1 this gives

    1 - (u^2 + v^2 + w^2) = (1 - v^2)(1 - u_hat^2)(1 - w_hat^2) > 0,

so no draw can leave the wall with more translational energy than it brought, whatever a fit or
an interpolation did to the channels. Angular velocities are taken as they are. The order of the
channels puts those of a plane flow (v, u, omega_z) first, so that a scene which needs no others
may stop there, and the three that change sign under reflection in the impact plane last.
"""

import math

import numpy as np
from numpy.typing import NDArray

from sampler.errors import InputError
from sampler.jit import borrowing_inline_kernel

#: Components of a state, in the order of every public array and file.
COMPONENTS = ("u", "v", "w", "omega_x", "omega_y", "omega_z")

#: Channels, in the order of the table's arrays.
CHANNELS = ("v", "u_hat", "omega_z", "w_hat", "omega_x", "omega_y")

#: Channels from this one on change sign under reflection in the impact plane.
FIRST_MIRRORED = 3


@borrowing_inline_kernel
def channels_to_state(state: NDArray[np.float64]) -> None:
    """Turn channels into a state, in place.

    Parameters
    ----------
    state : float64 array, shape (6,)
        On entry the channels in the order `CHANNELS`, on return the state in the order
        `COMPONENTS`.
    """
    v, u_hat, omega_z = state[0], state[1], state[2]
    w_hat, omega_x, omega_y = state[3], state[4], state[5]
    # Products of (1 - x)(1 + x) cannot become negative by rounding; 1 - v^2 - u^2 could.
    rest = (1.0 - v) * (1.0 + v)
    state[0] = u_hat * math.sqrt(rest)
    state[1] = v
    rest *= (1.0 - u_hat) * (1.0 + u_hat)
    state[2] = w_hat * math.sqrt(rest)
    state[3] = omega_x
    state[4] = omega_y
    state[5] = omega_z


def to_channels(state: NDArray[np.float64]) -> NDArray[np.float64]:
    """Channels of rebound states; the inverse of what a draw does last.

    Parameters
    ----------
    state : float64 array, shape (n, 6)
        u, v, w over V and omega_x, omega_y, omega_z times a/V.

    Returns
    -------
    float64 array, shape (n, 6)
        Channels in the order `CHANNELS`, dimensionless.

    Raises
    ------
    InputError
        If a state does not leave the wall (v <= 0) or carries all of the translational energy
        or more (u^2 + v^2 + w^2 >= 1), for which the channels are not defined.
    """
    state = np.asarray(state, dtype=np.float64)
    if state.ndim != 2 or state.shape[1] != len(COMPONENTS):
        raise InputError(f"state: got shape {state.shape}, allowed: (n, 6)")
    u, v, w = state[:, 0], state[:, 1], state[:, 2]
    energy = u * u + v * v + w * w
    # Negated so that NaN is refused as well.
    refused = ~((v > 0.0) & (energy < 1.0))
    if refused.any():
        k = int(refused.argmax())
        raise InputError(
            f"state: got v = {v[k]:g}, u^2 + v^2 + w^2 = {energy[k]:.17g} at index {k}, "
            "allowed: v > 0 and a sum below 1"
        )
    rest = (1.0 - v) * (1.0 + v)
    u_hat = u / np.sqrt(rest)
    w_hat = w / np.sqrt(rest - u * u)
    return np.column_stack((v, u_hat, state[:, 5], w_hat, state[:, 3], state[:, 4]))
