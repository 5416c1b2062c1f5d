"""Contact laws: restitution of the normal contact velocity, resistance to sliding.

Each law is a small kernel. `restitution` and `resistance` pick the one that a material pair names,
by a number that is the same for every collision of a run, so the branch is always predicted and
one compiled model serves all pairs. The paper's laws take the numbers of one particle or of lanes
(see `tablegen.model.simd`); the others are worked out lane by lane. Coulomb's law of friction is
no coefficient of a whole collision; `tablegen.model.coulomb` has it.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sampler.formats.bounds import (
    EXPONENTIAL,
    ORIENTATION,
    POLYNOMIAL,
    POWER,
    TABULATED,
    TABULATED_RESISTANCE,
)
from tablegen.model.elementary import exponential, power
from tablegen.model.jit import inline_kernel, no_refcount_inline_kernel, no_refcount_kernel
from tablegen.model.simd import extract, insert, select, width


class LawArguments(NamedTuple):
    """Contact laws of a pair as kernels take them, made by `MaterialPair.kernel_arguments`.

    A law reads only the entries that it uses.
    """

    #: Restitution: coefficient of the exponential or the power law, or the constant itself.
    coefficient: float
    #: Restitution: exponent of the exponential or the power law.
    exponent: float
    #: Resistance: factor in the exponent of the orientation law, or Coulomb's static coefficient.
    strength: float
    #: Resistance: overall factor of the orientation law, the constant itself, or Coulomb's dynamic
    #: coefficient.
    factor: float
    #: Which law of restitution, EXPONENTIAL to TABULATED.
    restitution_law: int
    #: Which law of resistance, ORIENTATION to COULOMB.
    resistance_law: int
    #: float64, (n,): coefficients of the polynomial, lowest power first, or the packed table of
    #: `pack_table`; empty for the other laws.
    numbers: NDArray[np.float64]
    #: float64, (n,): the packed table of the tabulated law of resistance, or that of Coulomb's
    #: tangential restitution where a sphere has one; else empty.
    resistances: NDArray[np.float64]


def pack_table(
    angle: NDArray[np.float64], speed: NDArray[np.float64], value: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Lay a table of coefficients out as `tabulated_coefficient` reads it.

    Of increasing angles (n,) at the contact [rad], increasing contact speeds (m,) [m/s] and values
    (n, m): sizes n and m, angles, speeds, values row by row.
    """
    sizes = np.array(value.shape, dtype=np.float64)
    return np.concatenate([sizes, angle, speed, value.ravel()])


@inline_kernel
def exponential_restitution(coefficient, exponent, contact_speed, cosine):
    """Restitution coefficient a_nc of the normal contact velocity, equation (6).

    ``contact_speed`` is |V_c| [m/s], ``cosine`` |v_c| / |V_c|; corundum on steel has the constants
    0.1 and 0.61.
    """
    return 1.0 + (exponential(-coefficient * power(contact_speed, exponent)) - 1.0) * cosine


@inline_kernel
def impact_angle(cosine):
    """Impact angle beta at the contact, measured from the wall [rad], for |v_c| / |V_c|."""
    # rounding may leave the ratio a hair above one, where the arc sine is not a number
    return math.asin(min(cosine, 1.0))


@no_refcount_inline_kernel
def polynomial_restitution(coefficients, angle):
    """Restitution coefficient c_0 + c_1 beta + c_2 beta^2 + ... of the angle beta [rad]."""
    value = 0.0
    for i in range(coefficients.size - 1, -1, -1):
        value = value * angle + coefficients[i]
    return value


@inline_kernel
def power_restitution(coefficient, exponent, normal_speed):
    """Restitution coefficient min(1, coefficient |v_c|^(-exponent)), speed in m/s.

    The power law grows without bound towards rest, where an elastic contact is the most there can
    be.
    """
    # in this form no speed divides by zero or overflows
    loss = normal_speed**exponent
    return coefficient / loss if loss > coefficient else 1.0


@no_refcount_inline_kernel
def table_cell(numbers, first, count, x):
    """Lower node and weight of the upper one for x among ``count`` nodes from ``first`` on.

    Beyond the ends the weight is that of the end itself.
    """
    if count == 1 or x <= numbers[first]:
        return 0, 0.0
    if x >= numbers[first + count - 1]:
        return count - 2, 1.0
    low, high = 0, count - 1
    while high - low > 1:
        middle = (low + high) // 2
        if numbers[first + middle] <= x:
            low = middle
        else:
            high = middle
    below = numbers[first + low]
    return low, (x - below) / (numbers[first + high] - below)


@no_refcount_kernel
def tabulated_coefficient(numbers, angle, contact_speed):
    """Coefficient of restitution or of resistance from a table: bilinear, constant beyond the ends.

    ``numbers`` come from `pack_table`, ``angle`` [rad] is that at the contact, from the wall,
    ``contact_speed`` |V_c| [m/s].
    """
    angles, speeds = int(numbers[0]), int(numbers[1])
    i, p = table_cell(numbers, 2, angles, angle)
    j, q = table_cell(numbers, 2 + angles, speeds, contact_speed)
    corner = 2 + angles + speeds + i * speeds + j
    # an axis of one node has no upper neighbour
    up = speeds if angles > 1 else 0
    right = 1 if speeds > 1 else 0
    near = (1.0 - q) * numbers[corner] + q * numbers[corner + right]
    far = (1.0 - q) * numbers[corner + up] + q * numbers[corner + up + right]
    return (1.0 - p) * near + p * far


@no_refcount_kernel
def other_restitution(law, contact_speed, cosine):
    """Restitution coefficient by a law that is not the exponential one.

    Not inlined, so that the path of the most common law stays short.
    """
    if law.restitution_law == POLYNOMIAL:
        return polynomial_restitution(law.numbers, impact_angle(cosine))
    if law.restitution_law == POWER:
        return power_restitution(law.coefficient, law.exponent, contact_speed * cosine)
    if law.restitution_law == TABULATED:
        return tabulated_coefficient(law.numbers, impact_angle(cosine), contact_speed)
    return law.coefficient


@no_refcount_kernel
def _each_other_restitution(law, contact_speed, cosine):
    """Restitution coefficients of lanes by a law that is not the exponential one."""
    value = cosine
    for i in range(width(cosine)):
        coefficient = other_restitution(law, extract(contact_speed, i), extract(cosine, i))
        value = insert(value, i, coefficient)
    return value


@no_refcount_inline_kernel
def restitution(law, contact_speed, cosine):
    """Restitution coefficient a_nc of the normal contact velocity, by the law of the pair.

    ``contact_speed`` is |V_c| [m/s], ``cosine`` |v_c| / |V_c|, the sine of the impact angle at the
    contact.
    """
    if law.restitution_law == EXPONENTIAL:
        return exponential_restitution(law.coefficient, law.exponent, contact_speed, cosine)
    return _each_other_restitution(law, contact_speed, cosine)


@inline_kernel
def orientation_resistance(strength, r_dot_v, r_length, speed):
    """Coefficient C_f of resistance to sliding, equation (7); a resting centre gives one.

    ``strength`` is 1 in equation (7); ``r_dot_v`` is r_c . V_p, of the contact point from the
    centre and the velocity of the centre, ``r_length`` and ``speed`` are |r_c| and |V_p|.
    """
    moves = speed > 0.0
    cosine = select(moves, r_dot_v / (r_length * select(moves, speed, 1.0)), 0.0)
    return exponential(strength * cosine)


@no_refcount_kernel
def tabulated_resistance(law, cosine):
    """Numbers of lanes from the table of resistances, which has one speed."""
    value = cosine
    for i in range(width(cosine)):
        angle = impact_angle(extract(cosine, i))
        value = insert(value, i, tabulated_coefficient(law.resistances, angle, 1.0))
    return value


@no_refcount_inline_kernel
def resistance(law, r_dot_v, r_length, speed, cosine):
    """Coefficient C_f of resistance to sliding, by the law of the pair.

    Arguments as in `orientation_resistance`, and ``cosine`` as in `restitution`. Coulomb's law has
    none: `tablegen.model.coulomb` follows each collision by it.
    """
    if law.resistance_law == ORIENTATION:
        return law.factor * orientation_resistance(law.strength, r_dot_v, r_length, speed)
    if law.resistance_law == TABULATED_RESISTANCE:
        return tabulated_resistance(law, cosine)
    return law.factor + 0.0 * speed
