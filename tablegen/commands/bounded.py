"""Types of flags that have bounds of the direct model."""

from sampler.options import Number
from tablegen.model import model_bounds as bounds


def _within(allowed: bounds.Bounds) -> Number:
    """Make the type of a number within bounds."""
    return Number(allowed.words, allowed.low, allowed.high)


ANGLE = _within(bounds.ALPHA_DEG)
SPEED = _within(bounds.SPEED)
RATIO = _within(bounds.ASPECT)
SPIN = _within(bounds.SPIN)
