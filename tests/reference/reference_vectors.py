"""Vectors as tuples of three floats, which a kernel keeps in registers."""

import math

from tablegen.model.jit import kernel

Vector = tuple[float, float, float]


@kernel
def dot(a, b):
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def norm(a):
    """Length."""
    return math.sqrt(dot(a, a))


@kernel
def cross(a, b):
    """Vector product."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@kernel
def along(a, t, b):
    """a + t b."""
    return (a[0] + t * b[0], a[1] + t * b[1], a[2] + t * b[2])


@kernel
def times(a, b):
    """Products of the components."""
    return (a[0] * b[0], a[1] * b[1], a[2] * b[2])


@kernel
def over(a, b):
    """Quotients of the components."""
    return (a[0] / b[0], a[1] / b[1], a[2] / b[2])
