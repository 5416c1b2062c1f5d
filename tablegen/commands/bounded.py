"""Types of command-line values: configurations, and numbers within bounds of the direct model."""

from sampler.options import Named, Number
from tablegen.model import model_bounds as bounds

#: Name of a material pair or a scene, or the path of its file.
CONFIG = Named(".toml")


def _within(allowed: bounds.Bounds) -> Number:
    return Number(allowed.words, allowed.low, allowed.high)


ANGLE = _within(bounds.ALPHA_DEG)
SPEED = _within(bounds.SPEED)
RATIO = _within(bounds.ASPECT)
SPIN = _within(bounds.SPIN)
