"""Contact laws: restitution a_nc of the normal contact velocity, and resistance C_f to sliding.

The laws of the paper, for a contact point r_c from the centre, which moves with V_c and has the
normal velocity v_c, and a centre that moves with V_p:

    a_nc = 1 - [1 - exp(-coefficient |V_c|^exponent)] |v_c| / |V_c|        equation (6)
    C_f = factor exp(strength r_c . V_p / (|r_c| |V_p|))                   equation (7)

tables/LAWS.md has the other laws, and tablegen/config/pairs.py their fields in files.

`restitution` and `resistance` pick the law that a material pair names, by a number that is the same
for every collision of a run. So the processor predicts the branch, and one compiled model serves
all pairs. Laws that need the C library or a search in a table are computed lane by lane. Coulomb's
law of friction has no coefficient for a whole collision; it is in `tablegen.model.coulomb`.

Units: speeds of contacts in m/s for a_nc, in units of the impact speed V for C_f, which depends on
their direction only; angles in rad.

Source: Panfilov & Tsirkunov, Tech. Phys. 2022, equations (6) and (7).
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sampler.formats.bounds import RESISTANCE_LAWS, RESTITUTION_LAWS
from tablegen.model.elementary import exponential, power
from tablegen.model.jit import inline_kernel, no_refcount_inline_kernel, no_refcount_kernel
from tablegen.model.simd import extract, insert, select, width

#: Codes of the laws that kernels tell apart.
EXPONENTIAL = RESTITUTION_LAWS.index("exponential")
POLYNOMIAL = RESTITUTION_LAWS.index("polynomial")
POWER = RESTITUTION_LAWS.index("power")
TABULATED = RESTITUTION_LAWS.index("tabulated")
ORIENTATION = RESISTANCE_LAWS.index("exponential-orientation")
TABULATED_RESISTANCE = RESISTANCE_LAWS.index("tabulated")
COULOMB = RESISTANCE_LAWS.index("coulomb")


class LawArguments(NamedTuple):
    """Contact laws of a pair as kernels take them, made by `MaterialPair.kernel_arguments`.

    Each law reads only the entries that it uses.
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
    #: Code of the law of restitution.
    restitution_law: int
    #: Code of the law of resistance.
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
    """Pack a table of coefficients into one array, as `tabulated_coefficient` reads it.

    ``angle`` (n,) are increasing impact angles at the contact [rad], ``speed`` (m,) increasing
    contact speeds [m/s], ``value`` is (n, m). The array has n, m, the angles, the speeds, and the
    values row by row.
    """
    sizes = np.array(value.shape, dtype=np.float64)
    return np.concatenate([sizes, angle, speed, value.ravel()])


@inline_kernel
def exponential_restitution(coefficient, exponent, contact_speed, cosine):
    """Compute the restitution coefficient a_nc of the normal contact velocity, equation (6).

    ``contact_speed`` is |V_c| [m/s], ``cosine`` |v_c| / |V_c|; corundum on steel has the constants
    0.1 and 0.61.
    """
    return 1.0 + (exponential(-coefficient * power(contact_speed, exponent)) - 1.0) * cosine


@inline_kernel
def impact_angle(cosine):
    """Compute the impact angle at the contact [rad], from the wall, from |v_c| / |V_c|."""
    # by rounding the ratio may exceed one, where the arc sine would be NaN
    return math.asin(min(cosine, 1.0))


@no_refcount_inline_kernel
def polynomial_restitution(coefficients, angle):
    """Compute the restitution coefficient c_0 + c_1 beta + c_2 beta^2 + ..., beta in rad."""
    value = 0.0
    for i in range(coefficients.size - 1, -1, -1):
        value = value * angle + coefficients[i]
    return value


@inline_kernel
def power_restitution(coefficient, exponent, normal_speed):
    """Compute the restitution coefficient min(1, coefficient |v_c|^(-exponent)), speed in m/s.

    Towards rest the power alone grows without bound. A contact can be no more than elastic.
    """
    # comparing before dividing avoids a division by zero and an overflow at low speeds
    loss = normal_speed**exponent
    return coefficient / loss if loss > coefficient else 1.0


@no_refcount_inline_kernel
def table_cell(numbers, first, count, x):
    """Find the interval of x among ``count`` nodes from ``first`` on.

    Returns the lower node and the weight of the upper node. Beyond an end they are those of the
    end.
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
    """Interpolate a coefficient of restitution or resistance: bilinear, constant beyond the ends.

    ``numbers`` come from `pack_table`; ``angle`` is the impact angle at the contact [rad],
    ``contact_speed`` is |V_c| [m/s].
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
    """Compute the restitution coefficient of one particle by a law other than the exponential one.

    It is not inlined, so that the code of the most common law stays short.
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
    """Compute restitution coefficients of all lanes by a law other than the exponential one."""
    value = cosine
    for i in range(width(cosine)):
        coefficient = other_restitution(law, extract(contact_speed, i), extract(cosine, i))
        value = insert(value, i, coefficient)
    return value


@no_refcount_inline_kernel
def restitution(law, contact_speed, cosine):
    """Compute the restitution coefficient a_nc of the normal contact velocity by the pair's law.

    ``contact_speed`` is |V_c| [m/s]; ``cosine`` is |v_c| / |V_c|, the cosine of the angle between
    V_c and the normal, or the sine of the impact angle at the contact.
    """
    if law.restitution_law == EXPONENTIAL:
        return exponential_restitution(law.coefficient, law.exponent, contact_speed, cosine)
    return _each_other_restitution(law, contact_speed, cosine)


@inline_kernel
def orientation_resistance(strength, r_dot_v, r_length, speed):
    """Compute the resistance to sliding by the exponential of equation (7).

    ``strength`` is 1 in equation (7); ``r_dot_v`` is r_c . V_p, with the contact point from the
    centre and the velocity of the centre; ``r_length`` and ``speed`` are |r_c| and |V_p|. If the
    centre rests, the result is 1.
    """
    moves = speed > 0.0
    cosine = select(moves, r_dot_v / (r_length * select(moves, speed, 1.0)), 0.0)
    return exponential(strength * cosine)


@no_refcount_kernel
def tabulated_resistance(law, cosine):
    """Interpolate the table of resistances in each lane; it has one speed."""
    value = cosine
    for i in range(width(cosine)):
        angle = impact_angle(extract(cosine, i))
        value = insert(value, i, tabulated_coefficient(law.resistances, angle, 1.0))
    return value


@no_refcount_inline_kernel
def resistance(law, r_dot_v, r_length, speed, cosine):
    """Compute the coefficient C_f of resistance to sliding by the pair's law.

    Arguments are those of `orientation_resistance`, and ``cosine`` of `restitution`. Under
    Coulomb's law there is no C_f; `tablegen.model.coulomb` follows each collision.
    """
    if law.resistance_law == ORIENTATION:
        return law.factor * orientation_resistance(law.strength, r_dot_v, r_length, speed)
    if law.resistance_law == TABULATED_RESISTANCE:
        return tabulated_resistance(law, cosine)
    return law.factor + 0.0 * speed
