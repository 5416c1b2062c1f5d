"""Gas round a body, and the drag on a particle in it.

Potential flow of an incompressible gas with speed 1 far away, round a body of radius 1; e.g.
Batchelor, An Introduction to Fluid Dynamics (1967), sec. 6.6 (cylinder) and 6.8 (sphere).
"""

import math
from typing import NamedTuple

from sampler.compilation.jit import inline_kernel

CYLINDER, SPHERE = 0, 1

#: Names of the bodies, in the order of their codes.
BODIES = ("cylinder", "sphere")


#: Response time of a particle's velocity over that of its spin, for a sphere: 60/18.
SPIN_RESPONSE = 10.0 / 3.0


class Flow(NamedTuple):
    """What moves a particle between its hits.

    ``body``: `CYLINDER` or `SPHERE`. ``response``: R/U over the Stokes response time of the
    particle, 1/St; 0 switches drag off. ``reynolds``: Reynolds number of a particle that slips
    through the gas with speed U; 0 leaves plain Stokes drag.
    """

    body: int
    response: float
    reynolds: float


@inline_kernel
def radius(body, x, y, z):
    """Distance from the axis of the cylinder or from the centre of the sphere."""
    return math.sqrt(x * x + y * y + (z * z if body == SPHERE else 0.0))


@inline_kernel
def outward(body, x, y, z):
    """Wall normal into the gas at a point on the surface, of length one."""
    r = radius(body, x, y, z)
    return x / r, y / r, (z / r if body == SPHERE else 0.0)


@inline_kernel
def gas_velocity(body, x, y, z):
    """Velocity of the gas."""
    if body == CYLINDER:
        r2 = x * x + y * y
        q = 1.0 / (r2 * r2)
        return 1.0 - (x * x - y * y) * q, -2.0 * x * y * q, 0.0
    r2 = x * x + y * y + z * z
    q = 0.5 / (r2 * math.sqrt(r2))
    s = -3.0 * q * x / r2
    return 1.0 + q + s * x, s * y, s * z


@inline_kernel
def spin_left(flow, passed):
    """Share of its spin that a particle has after some time.

    The viscous torque on a sphere, 8 pi mu (d/2)^3 times its angular velocity; potential flow has
    no vorticity, so the spin decays to zero.
    """
    return math.exp(-SPIN_RESPONSE * flow.response * passed)


@inline_kernel
def drag_factor(reynolds):
    """Drag on a sphere over that of Stokes; Schiller and Naumann (1933), Re below about 1000."""
    return 1.0 + 0.15 * reynolds**0.687


@inline_kernel
def acceleration(flow, x, y, z, u, v, w):
    """Acceleration of a particle by drag.

    (gas velocity - particle velocity) / St, times the `drag_factor` at the Reynolds number of the
    slip.
    """
    gu, gv, gw = gas_velocity(flow.body, x, y, z)
    du, dv, dw = gu - u, gv - v, gw - w
    slip = flow.reynolds * math.sqrt(du * du + dv * dv + dw * dw)
    rate = flow.response
    if slip > 0.0:
        rate *= drag_factor(slip)
    return rate * du, rate * dv, rate * dw
