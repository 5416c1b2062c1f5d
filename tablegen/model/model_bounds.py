"""Bounds of the arguments of the direct model, in the order in which LAWS.md shows them.

Inside of the bounds every rebound ends with a finite state; LAWS.md has the cost of the worst
corners. Outside, the time of a rebound or its rounding errors grow without limit. The same bounds
apply in files, flags and functions.
"""

from sampler.limits import Bounds

#: Ratios b/a and c/b.
ASPECT = Bounds(1e-3, 1.0)

#: Impact angle from the wall.
ALPHA_DEG = Bounds(1e-6, 90.0, " degrees")

#: Impact speed.
SPEED = Bounds(1e-6, 1e5, " m/s")

#: Angular velocity before the impact along each axis.
SPIN = Bounds(-1e3, 1e3, " V/a")

#: Inertia about a spin over m a^2. No particle has one larger than 2.
INERTIA = Bounds(0.0, 2.0)

#: Angle [rad] by which a particle may turn before its first contact, 2 |spin| / sin(alpha1).
MOST_TURNED = 1e6

#: Half-size [m] for rebounds in units of a, which do not depend on it. It is a power of two, so
#: that a change of units loses no bits.
HALF_SIZE = 2.0**-17

#: Smallest rebound speed of a contact point over V.
CONTACT_RESOLUTION = Bounds(1e-6, 0.1)

#: Truncation of the flight series.
TOLERANCE = Bounds(1e-14, 1e-4)

#: Least extent of a mesh in the units of its file, and largest coordinate. The cubes of these
#: numbers neither overflow nor underflow.
MESH_SIZE = Bounds(1e-30, 1e30)
