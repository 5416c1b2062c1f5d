"""Vectors of three numbers, as kernels use them: tuples, which live in registers."""

import math

import numpy as np
from numpy.typing import NDArray

from sampler.compilation.jit import inline_kernel, no_refcount_inline_kernel

Vector = tuple[float, float, float]


@inline_kernel
def dot(a: Vector, b: Vector) -> float:
    """Return a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inline_kernel
def cross(a: Vector, b: Vector) -> Vector:
    """Return a x b."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@inline_kernel
def combine(p: float, a: Vector, q: float, b: Vector) -> Vector:
    """Return p a + q b."""
    return (p * a[0] + q * b[0], p * a[1] + q * b[1], p * a[2] + q * b[2])


@inline_kernel
def scaled(p: float, a: Vector) -> Vector:
    """Return p a."""
    return (p * a[0], p * a[1], p * a[2])


@inline_kernel
def unit(a: Vector) -> Vector:
    """Return the unit vector along a nonzero finite vector of any magnitude."""
    largest = max(abs(a[0]), abs(a[1]), abs(a[2]))
    # Divided, not multiplied by 1/largest, which overflows for the smallest vectors.
    a = (a[0] / largest, a[1] / largest, a[2] / largest)
    return scaled(1.0 / math.sqrt(dot(a, a)), a)


@inline_kernel
def is_finite(a: Vector) -> bool:
    """Tell whether every component is finite."""
    return math.isfinite(a[0]) and math.isfinite(a[1]) and math.isfinite(a[2])


@no_refcount_inline_kernel
def vector(values: NDArray[np.float64], k: int) -> Vector:
    """Row k of an (n, 3) array, or the only row of an array of one."""
    k = k if values.shape[0] > 1 else 0
    return (values[k, 0], values[k, 1], values[k, 2])
