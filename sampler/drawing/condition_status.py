"""Whether a condition can be drawn, lies outside of a table, or can belong to no rebound."""

import math

from sampler.compilation.jit import inline_kernel, no_refcount_inline_kernel
from sampler.errors import CLAMPED, NOT_APPROACHING, NOT_FINITE, OK, SPEED_NOT_POSITIVE
from sampler.formats.bounds import ROUNDING, Axis, TableArrays

_HALF_PI = 0.5 * math.pi


@inline_kernel
def condition_status(alpha1: float, speed: float) -> int:
    """Negative code if no rebound can have this angle (rad) and speed (m/s), else `OK`."""
    if not (math.isfinite(alpha1) and math.isfinite(speed)):
        return NOT_FINITE
    if alpha1 <= 0.0 or alpha1 > _HALF_PI + ROUNDING:
        return NOT_APPROACHING
    if speed <= 0.0:
        return SPEED_NOT_POSITIVE
    return OK


@no_refcount_inline_kernel
def is_outside(value: float, axis: Axis) -> bool:
    """Whether a value lies off the axis by more than the rounding of a unit conversion."""
    return value < axis.low or value > axis.high


@no_refcount_inline_kernel
def status_of(arrays: TableArrays, alpha1: float, speed: float) -> int:
    """`OK`, `CLAMPED` or the negative code of a condition."""
    alpha, velocity = arrays.alpha, arrays.speed
    # true for what is most common, false for NaN
    inside = alpha.low <= alpha1 <= alpha.high and velocity.low <= speed <= velocity.high
    if inside:
        return OK
    status = condition_status(alpha1, speed)
    return CLAMPED if status == OK else status
