"""From channels to a state, the last step of a draw; equations: `sampler.formats.channels`."""

import math

import numpy as np
from numpy.typing import NDArray

from sampler.compilation.jit import no_refcount_inline_kernel


@no_refcount_inline_kernel
def channels_to_state(values: NDArray[np.float64]) -> None:
    """Turn channels into components, in place; those left out are 0 before and after.

    Parameters
    ----------
    values : float64 array, shape (8,)
        On entry the channels in the order of `sampler.formats.channels.CHANNELS`, on return the
        components in that of `COMPONENTS`.
    """
    v, u_hat, omega_z = values[0], values[1], values[2]
    w_hat, omega_x, omega_y = values[3], values[4], values[5]
    # Products of (1 - x)(1 + x) cannot become negative by rounding; 1 - v^2 - u^2 could.
    rest = (1.0 - v) * (1.0 + v)
    values[0] = u_hat * math.sqrt(rest)
    values[1] = v
    rest *= (1.0 - u_hat) * (1.0 + u_hat)
    values[2] = w_hat * math.sqrt(rest)
    values[3] = omega_x
    values[4] = omega_y
    values[5] = omega_z
    values[6] *= rest * ((1.0 - w_hat) * (1.0 + w_hat))
    values[7] = math.floor(values[7])
