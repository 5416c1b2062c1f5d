"""How far a tumbling grain reaches: where its fall to the wall may begin, and when it has left.

In free tumbling all phases are equally likely at any time. So the simulation of a fall may begin at
any height at which the grain cannot touch the wall, whatever its phases. That saves most of the
time of grazing impacts: a grain whose reach is half of its bounding radius would turn by thousands
of radians between that radius and the wall, and as many again after it has left.

The direction l of the angular momentum is constant in the lab, and so is the cosine c of its angle
to the wall normal n. In body axes (l1^2, l2^2, l3^2) moves on a straight line, so each of the three
has a smallest and a largest value. If the angle between l and an axis of the body is beta, the
angle between n and that axis is at least |beta - arccos c|. That bounds n1, n2 and n3, and with
them the support function of the body.

Units: lengths in a; moments of inertia in any unit. The bound is ours.
"""

from tablegen.model.jit import inline_kernel, no_refcount_kernel
from tablegen.model.simd import maximum, minimum, select, sqrt
from tablegen.model.vectors import dot

#: Smallest divisor, so that quotients stay finite.
_TINY = 1e-200

#: Margin above the bound on a height, in units of a. The rounding of a cosine near one changes its
#: angle by 1e-8.
MARGIN = 1e-6


@inline_kernel
def _ends_of_squares(moments, squares):
    """Compute the smallest and the largest squares of l during the tumbling from present ones."""
    i1, i2, i3 = 1.0 / moments[0], 1.0 / moments[1], 1.0 / moments[2]
    # along the line the first and third square grow by up1 and up3, and the second falls by the sum
    up1, up3 = i2 - i3, i1 - i2
    s1, s2, s3 = squares
    # the line goes on until the second square is zero, and back until the first or third is
    on = s2 / maximum(up1 + up3, _TINY)
    back = minimum(s1 / maximum(up1, _TINY), s3 / maximum(up3, _TINY))
    least = maximum(s1 - up1 * back, 0.0), 0.0 * s2, maximum(s3 - up3 * back, 0.0)
    return least, (s1 + up1 * on, s2 + (up1 + up3) * back, s3 + up3 * on)


@inline_kernel
def _most_of_normal(cosine, least, most):
    """Bound the size of n along an axis of the body from the smallest and largest square of l."""
    low, high = sqrt(minimum(least, 1.0)), sqrt(minimum(most, 1.0))
    near = minimum(maximum(cosine, low), high)
    return near * cosine + sqrt((1.0 - near * near) * maximum(1.0 - cosine * cosine, 0.0))


@inline_kernel
def _reach_of_ellipsoid(half, ends):
    """Compute the largest support of an ellipsoid for n whose sizes along the axes are bounded."""
    _, b, c = half
    first = minimum(ends[0] * ends[0], 1.0)
    second = minimum(ends[1] * ends[1], 1.0 - first)
    return sqrt(first + b * b * second + c * c * (1.0 - first - second))


@no_refcount_kernel
def _reach_of_box(half, ends):
    """Compute the largest support of a box for n whose sizes along the axes are at most ``ends``.

    Without the bounds the best n is along the diagonal of the box. An axis along which that is too
    large is set to its bound; the other axes share what is left of the unit length in proportion to
    their half-sizes.
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
    """Compute a height of the centre at which a tumbling grain cannot touch the wall.

    ``momentum`` is the present angular momentum in body axes and any unit, ``normal`` the present
    wall normal in body axes.
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
