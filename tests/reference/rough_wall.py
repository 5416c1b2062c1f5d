"""Facets of rough walls in plain Python, from the keys of a hit.

Source: Sommerfeld & Huber, Int. J. Multiphase Flow 25 (1999) 1457-1489. docs/method.md and
`sampler/c/src/rough.h` have the densities; here they are drawn by the same trials, with scipy's
normal law.
"""

import math
import sys
from pathlib import Path

import numpy as np
from scipy.special import ndtr, ndtri

sys.path.append(str(Path(__file__).resolve().parents[1] / "sampler"))
from reference_draw import MASK, philox

TRIALS, FIRST_BLOCK, SHADOW, STEEP = 64, 3, 1e-9, 1e9
BOUNCE_KEY = 0x9E37_79B9_7F4A_7C15


def seed_of_bounce(seed, bounce):
    """Seed of bounce 0, 1, ... of a hit."""
    return seed ^ (bounce * BOUNCE_KEY & (2**64 - 1))


def uniforms(keys, block):
    """Four uniform numbers of a block of random words."""
    seed, index, hit = keys
    words = philox((seed & MASK, seed >> 32), (index & MASK, index >> 32, hit, block))
    return [(word + 0.5) / 2**32 for word in words]


def proposed_score(c, part, size, side):
    """A score z with a density ~ phi(z) (c + z), z > -c."""
    plain = c * ndtr(c)
    rayleigh = math.exp(-0.5 * c * c) / math.sqrt(2.0 * math.pi)
    if part * (plain + rayleigh) >= plain:
        return math.sqrt(c * c - 2.0 * math.log(size))
    below = ndtr(-c)
    z = ndtri(below + size * (1.0 - below))
    return -z if z < c and 2.0 * side * c < c - z else z


def tilt_in_plane(alpha1, roughness, keys):
    """Tilt [rad] in the plane of incidence of the facet that a particle meets."""
    c = min(math.tan(alpha1) / roughness, STEEP)
    for trial in range(TRIALS):
        part, size, side, chance = uniforms(keys, FIRST_BLOCK + trial)
        tilt = roughness * proposed_score(c, part, size, side)
        local = alpha1 + tilt
        if SHADOW < local < math.pi - SHADOW and abs(tilt) < 0.5 * math.pi:
            bound = math.sin(alpha1) + tilt * math.cos(alpha1)
            if chance * bound < math.sin(local):
                return tilt
    return 0.0


def tilt_across(roughness, keys):
    """Tilt [rad] across the plane of incidence."""
    for trial in range(TRIALS):
        size, chance, _, _ = uniforms(keys, FIRST_BLOCK + TRIALS + trial)
        tilt = roughness * ndtri(size)
        if abs(tilt) < 0.5 * math.pi and chance < math.cos(tilt):
            return tilt
    return 0.0


def facets(velocity, seed, roughness, isotropic, index, hit):
    """Normals of the facets that particles with the velocities (n, 3) meet on a floor."""
    alpha = np.arctan2(-velocity[:, 1], np.hypot(velocity[:, 0], velocity[:, 2]))
    keys = [(int(seed), int(i), int(hit)) for i in index]
    tilts = [tilt_in_plane(a, roughness, key) for a, key in zip(alpha, keys, strict=True)]
    others = [tilt_across(roughness, key) if isotropic else 0.0 for key in keys]
    slope, across = (np.tan(each)[:, None] for each in (tilts, others))
    along = velocity * [1.0, 0.0, 1.0]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    up = np.array([0.0, 1.0, 0.0])
    return up - slope * along + across * np.cross(along, up)
