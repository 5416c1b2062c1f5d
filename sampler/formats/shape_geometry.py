"""Volume, mean moment of inertia and surface of shapes, as spin/shape_geometry has them."""

import math
from typing import NamedTuple

from sampler.formats.shape_codes import SHAPE_NAMES

#: Fraction of each half-edge at which a truncated prism loses its corners, by default: a cube
#: becomes a regular truncated cube.
TRUNCATION = 2.0 - math.sqrt(2.0)


class Geometry(NamedTuple):
    """Numbers of a shape that do not depend on its half-sizes a, b and c.

    The surface of an ellipsoid is no such sum, so that its last two numbers are 0.
    """

    #: Over a b c.
    volume: float
    #: Mean of the principal moments of inertia over m (a^2 + b^2 + c^2).
    moment: float
    #: s and t of the surface s (a b + b c + c a) + t (a^2 b^2 + b^2 c^2 + c^2 a^2)^(1/2).
    surface_of_box: float
    surface_across: float


def geometry_of_shape(shape_code: int, truncation: float = TRUNCATION) -> Geometry:
    """Give the geometry of a shape other than a mesh."""
    f = truncation
    corners = f**3 / 6.0  # volume of the corners of a truncated prism, over that of the prism
    # mean of x^2 / a^2 in these corners
    square = (3.0 + (1.0 - f) ** 2 + (4.0 - f) ** 2) / 20.0
    truncated = (1.0 / 3.0 - corners * square) / (1.0 - corners)
    ellipsoid = Geometry(4.0 / 3.0 * math.pi, 2.0 / 15.0, 0.0, 0.0)
    shapes = {
        "ellipsoid": ellipsoid,
        "prism": Geometry(8.0, 2.0 / 9.0, 8.0, 0.0),
        # a corner takes f^2 a b / 2 of a face, and leaves a triangle
        "truncated-prism": Geometry(
            8.0 * (1.0 - corners), 2.0 / 3.0 * truncated, 8.0 - 4.0 * f**2, 4.0 * f**2
        ),
        "tetrahedron": Geometry(8.0 / 3.0, 2.0 / 15.0, 0.0, 8.0),
        "sphere": ellipsoid,
    }
    return shapes[SHAPE_NAMES[shape_code]]
