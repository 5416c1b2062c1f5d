"""How far a tumbling grain can reach: where its fall to the wall may begin, and when it has left.

The phases of free tumbling are uniform at any time. So a fall may begin at any height at which the
grain cannot touch the wall, whatever the phases. That saves most of the time of grazing impacts: a
grain that reaches half as far as its bounding radius would turn thousands of radians between that
radius and the wall, and as many again after it has left.

The direction l of the angular momentum stands still in the lab, and so does its angle to the wall
normal n, whose cosine is c. In body axes the squares of l move on a straight line, on which each
has a largest and a smallest value. An axis of the body from which l is an angle b away is at least
the difference of b and the angle of l from n, or nothing, away from n: that bounds the components
of n, and with them the support function.
"""

from tablegen.model.frames import dot
from tablegen.model.jit import inline_kernel, no_refcount_kernel
from tablegen.model.simd import maximum, minimum, select, sqrt

#: Keeps quotients finite.
_TINY = 1e-200

#: Margin over the bound on a height, in units of a: a cosine near one, rounded, is that of an angle
#: wrong by 1e-8.
MARGIN = 1e-6


@inline_kernel
def _ends_of_squares(moments, squares):
    """Smallest and largest squares of l over the tumbling, for those of now."""
    i1, i2, i3 = 1.0 / moments[0], 1.0 / moments[1], 1.0 / moments[2]
    # along the line the squares change by these numbers, the second by minus the sum
    up1, up3 = i2 - i3, i1 - i2
    s1, s2, s3 = squares
    # until the second vanishes, and until the first or third does
    on = s2 / maximum(up1 + up3, _TINY)
    back = minimum(s1 / maximum(up1, _TINY), s3 / maximum(up3, _TINY))
    least = maximum(s1 - up1 * back, 0.0), 0.0 * s2, maximum(s3 - up3 * back, 0.0)
    return least, (s1 + up1 * on, s2 + (up1 + up3) * back, s3 + up3 * on)


@inline_kernel
def _most_of_normal(cosine, least, most):
    """Largest component of n along an axis of the body, from the ends of the square of l."""
    low, high = sqrt(minimum(least, 1.0)), sqrt(minimum(most, 1.0))
    near = minimum(maximum(cosine, low), high)
    return near * cosine + sqrt((1.0 - near * near) * maximum(1.0 - cosine * cosine, 0.0))


@inline_kernel
def _reach_of_ellipsoid(half, ends):
    """Largest support of an ellipsoid whose directions have components up to some ends."""
    _, b, c = half
    first = minimum(ends[0] * ends[0], 1.0)
    second = minimum(ends[1] * ends[1], 1.0 - first)
    return sqrt(first + b * b * second + c * c * (1.0 - first - second))


@no_refcount_kernel
def _reach_of_box(half, ends):
    """Largest support of a box of half-sizes ``half`` in directions with components up to ends.

    Those that would be larger along the diagonal are at their ends, and the rest shares what is
    left in proportion to the half-sizes.
    """
    a, b, c = half
    x, y, z = ends
    at_x = at_y = at_z = x < 0.0
    scale = 0.0 * x
    for _ in range(3):
        free = select(at_x, 0.0, a * a) + select(at_y, 0.0, b * b) + select(at_z, 0.0, c * c)
        left = 1.0 - select(at_x, x * x, 0.0) - select(at_y, y * y, 0.0) - select(at_z, z * z, 0.0)
        scale = sqrt(maximum(left, 0.0) / maximum(free, _TINY))
        at_x, at_y = at_x | (scale * a > x), at_y | (scale * b > y)
        at_z = at_z | (scale * c > z)
    return a * minimum(x, scale * a) + b * minimum(y, scale * b) + c * minimum(z, scale * c)


@no_refcount_kernel
def tumbling_reach(body, momentum, normal):
    """Height of the centre over the wall at which a tumbling grain cannot touch it.

    ``momentum``, its angular momentum in any unit, and the wall normal are in body axes now.
    """
    square = dot(momentum, momentum)
    scale = select(square > _TINY, 1.0 / sqrt(maximum(square, _TINY)), 0.0)
    l1, l2, l3 = momentum[0] * scale, momentum[1] * scale, momentum[2] * scale
    squares = l1 * l1, l2 * l2, l3 * l3
    cosine = minimum(abs(dot((l1, l2, l3), normal)), 1.0)
    least, most = _ends_of_squares(body.moments, squares)
    ends = (
        _most_of_normal(cosine, least[0], most[0]),
        _most_of_normal(cosine, least[1], most[1]),
        _most_of_normal(cosine, least[2], most[2]),
    )
    if body.candidates.shape[0] == 0:
        reach = _reach_of_ellipsoid(body.half, ends)
    else:
        reach = _reach_of_box(body.half, ends)
    return minimum(reach, body.bounding_radius) + MARGIN
