"""Facets of rough walls, as `sampler.drawing.roughness` draws them."""

from sampler.compilation.jit import no_refcount_kernel
from sampler.drawing.frames import impact_angle
from sampler.drawing.roughness import bounce_seed, draw_tilt, facet_normal
from sampler.drawing.vectors import dot, unit, vector
from sampler.errors import OK, TILT_NOT_FOUND


@no_refcount_kernel
def facet_normals(moving, normal, roughness, keys, facets):
    """Draw the facets that particles meet.

    Parameters
    ----------
    moving : (n, 3) float64
        Velocities relative to the mean wall, towards it or along it [m/s].
    normal : (n, 3) float64
        Of the mean wall, into the gas, of any length but zero.
    roughness : (n,) float64
        Standard deviation of the tilt of facets [rad]; 0: a smooth wall.
    keys : tuple
        Seed; index and hit, of n rows.
    facets : (n, 3) float64
        Output: unit normals.

    Returns
    -------
    tuple of two int
        First row without a facet, or -1; its code.
    """
    seed, index, hit = keys
    for k in range(facets.shape[0]):
        velocity, facet = vector(moving, k), unit(vector(normal, k))
        if roughness[k] > 0.0:
            alpha1 = max(impact_angle(velocity, facet)[0], 0.0)
            found, tilt = draw_tilt(alpha1, roughness[k], seed, index[k], hit[k])
            if not found:
                return k, TILT_NOT_FOUND
            facet = facet_normal(velocity, facet, tilt, seed, index[k], hit[k])
        facets[k, 0], facets[k, 1], facets[k, 2] = facet
    return -1, OK


@no_refcount_kernel
def mark_leaving(moving, normal, leaving):
    """Mark the particles that leave the mean wall: ``leaving`` (n,) bool is written."""
    for k in range(leaving.size):
        leaving[k] = dot(vector(moving, k), unit(vector(normal, k))) > 0.0


@no_refcount_kernel
def seed_of_bounce(seed, bounce):
    """Seed of the random numbers of a bounce within a hit, uint64."""
    return bounce_seed(seed, bounce)
