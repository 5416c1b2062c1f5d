"""Rough walls: facets with randomly tilted normals, in the plane of incidence or in all planes.

The facets of a wall have tilts gamma from a normal law with mean zero and a standard deviation, the
roughness. A facet with a positive tilt faces the particle. A particle that arrives at an angle
alpha from the mean wall sees each facet by its projected area, so the tilts that it meets have the
density

    p(gamma) ~ exp(-gamma^2 / (2 roughness^2)) sin(alpha + gamma) / sin(alpha)

where 0 < alpha + gamma < pi and |gamma| < pi/2. Source: Sommerfeld & Huber, "Experimental analysis
and modelling of particle-wall collisions", Int. J. Multiphase Flow 25 (1999) 1457-1489.

A tilt is drawn exactly, by rejection. The sine lies below its tangent at alpha, so

    sin(alpha + gamma) <= sin(alpha) + gamma cos(alpha) = roughness cos(alpha) (c + z),
    z = gamma / roughness, c = tan(alpha) / roughness,

and a z with the density ~ phi(z) (c + z), z > -c, is accepted with the ratio of the two sides,
which is more than 0.88 on average. That density is the sum of c phi(z), with the weight c Phi(c),
and of z phi(z) for z > c, with the weight phi(c), after the first has moved a part of its share
from -z to z. Each trial takes one of the blocks 3, 4, ... of random words. The C library draws the
same facets from the same keys.

If the roughness is isotropic, facets are also tilted by h across the plane of incidence. Their
normals are along e_y - tan(gamma) e_x + tan(h) e_z, and p(h) ~ exp(-h^2 / (2 roughness^2)) cos(h)
for any gamma (docs/method.md). A normal h is accepted with the probability cos(h), by the blocks
after those of gamma.

Units: angles in rad.
"""

import math

import numpy as np

from tablegen.model.frames import (
    combine,
    cross,
    dot,
    impact_angle,
    item,
    keys_of_row,
    tangent,
    unit,
    vector,
)
from tablegen.model.jit import kernel, no_refcount_kernel
from tablegen.model.random_numbers import normal_cdf, normal_quantile, philox_block, uniform

#: Largest roughness [rad]. With a larger one a normal law of tilts describes no surface.
MAX_ROUGHNESS = 0.5

#: Bounces of one hit after which the particle is reported as an error.
MAX_BOUNCES = 64

_MAX_TRIALS = 64
_FIRST_BLOCK = 3

#: Smallest angle [rad] between path and facet. One in 10^14 angles is smaller.
_SHADOW = 1e-9

#: Upper bound of c. A larger c changes no draw, and would overflow.
_STEEP = 1e9

_BOUNCE_KEY = np.uint64(0x9E37_79B9_7F4A_7C15)
_ROOT_HALF_PI = 1.0 / math.sqrt(2.0 * math.pi)


@no_refcount_kernel
def seed_of_bounce(seed, bounce):
    """Compute the seed of bounce 0, 1, ... of a hit, uint64; bounce 0 has the seed of the hit."""
    return np.uint64(seed) ^ (np.uint64(bounce) * _BOUNCE_KEY)


@kernel
def proposed_score(c, u_part, u_size, u_side):
    """Draw z with a density ~ phi(z) (c + z), z > -c, for c >= 0, from three uniform numbers.

    The three numbers choose the part of the density, the size of z, and its sign.
    """
    plain = c * normal_cdf(c)
    rayleigh = _ROOT_HALF_PI * math.exp(-0.5 * c * c)
    if u_part * (plain + rayleigh) >= plain:
        # the part z phi(z), for z > c
        return math.sqrt(c * c - 2.0 * math.log(u_size))
    below = normal_cdf(-c)
    z = normal_quantile(below + u_size * (1.0 - below))
    # for |z| < c, phi(z) becomes phi(z) (1 + z / c), because -z gives a share of itself to z
    return -z if z < c and 2.0 * u_side * c < c - z else z


@kernel
def draw_tilt(alpha1, roughness, keys):
    """Draw the tilt of the facet that a particle meets; 0 if the path is too flat to meet one.

    ``alpha1``, in [0, pi/2], is the angle between path and mean wall, ``roughness``, positive, the
    standard deviation of the tilt of all facets; angles in rad. The keys are seed, index and hit.
    """
    c = min(math.tan(alpha1) / roughness, _STEEP)
    for trial in range(_MAX_TRIALS):
        w0, w1, w2, w3 = philox_block(keys[0], keys[1], keys[2], _FIRST_BLOCK + trial)
        tilt = roughness * proposed_score(c, uniform(w0), uniform(w1), uniform(w2))
        local = alpha1 + tilt
        if _SHADOW < local < math.pi - _SHADOW and abs(tilt) < 0.5 * math.pi:
            bound = math.sin(alpha1) + tilt * math.cos(alpha1)
            if uniform(w3) * bound < math.sin(local):
                return tilt
    return 0.0


@kernel
def draw_across(roughness, keys):
    """Draw the tilt across the plane of incidence."""
    for trial in range(_MAX_TRIALS):
        w0, w1, _, _ = philox_block(keys[0], keys[1], keys[2], _FIRST_BLOCK + _MAX_TRIALS + trial)
        tilt = roughness * normal_quantile(uniform(w0))
        if abs(tilt) < 0.5 * math.pi and uniform(w1) < math.cos(tilt):
            return tilt
    return 0.0


@no_refcount_kernel
def facet_normals(moving, normal, roughness, across, keys, facets):
    """Draw the facets that particles meet.

    ``moving`` (n, 3) are velocities relative to the mean wall, towards it or along it [m/s];
    ``normal`` (n, 3) are normals of the mean wall into the gas, of any length but zero;
    ``roughness`` (n,) is in rad, 0 for a smooth wall; ``across`` (n,) is the same for the tilt
    across the plane of incidence; ``keys`` are seed, index and hit. Each has n rows, or one for
    all. The normals of the facets, of any length but zero, are written to ``facets`` (n, 3).
    """
    for k in range(facets.shape[0]):
        velocity, facet = vector(moving, k), unit(vector(normal, k))
        along, side = item(roughness, k), item(across, k)
        if along > 0.0:
            one = keys_of_row(keys, k)
            alpha1 = max(impact_angle(velocity, facet), 0.0)
            tilt = draw_tilt(alpha1, along, one)
            # at normal impact the plane of incidence is that of an azimuth drawn by the keys
            e_x = tangent(velocity, facet, one)
            tilted = combine(math.cos(tilt), facet, -math.sin(tilt), e_x)
            if side > 0.0:
                other, e_z = draw_across(side, one), cross(e_x, facet)
                size = math.cos(tilt) * math.sin(other)
                tilted = combine(math.cos(other), tilted, size, e_z)
            facet = tilted
        facets[k, 0], facets[k, 1], facets[k, 2] = facet


@no_refcount_kernel
def mark_leaving(moving, normal, leaving):
    """Tell which particles leave the mean wall, in ``leaving`` (n,) bool, which is written."""
    for k in range(leaving.size):
        leaving[k] = dot(vector(moving, k), unit(vector(normal, k))) > 0.0
