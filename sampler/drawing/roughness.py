"""Rough walls: the local wall normal is tilted at random in the plane of incidence.

A particle that arrives at an angle alpha from the mean wall meets facets whose tilt gamma is
normal with mean zero and a standard deviation, the roughness; a positive tilt faces the particle.
It sees a facet by its projected area, so the tilts that it meets have the density

    p(gamma) ~ exp(-gamma^2 / (2 roughness^2)) sin(alpha + gamma) / sin(alpha)

where 0 < alpha + gamma < pi and |gamma| < pi/2: facets that recede are in the shadow. The rebound
is that from a smooth wall along the facet. A particle that it sends back into the mean wall
bounces again, from another facet, until it leaves.

Source: Sommerfeld & Huber, "Experimental analysis and modelling of particle-wall collisions",
Int. J. Multiphase Flow 25 (1999) 1457-1489: the tilt and its effective density.

How a tilt is drawn, exactly. The tangent of the sine at alpha lies above it, so

    sin(alpha + gamma) <= sin(alpha) + gamma cos(alpha) = roughness cos(alpha) (c + z),
    z = gamma / roughness, c = tan(alpha) / roughness,

and z with a density ~ phi(z) (c + z), z > -c, is accepted with the ratio of the two sides: more
than 0.88 on average for all angles up to the largest roughness, 0.5 rad. This density is the sum
of c phi(z), with weight c Phi(c), and of z phi(z), with weight phi(c), once the first has given
part of what it has at -z to z. A trial takes one block of four random words: blocks 3, 4, ... of
the keys (seed, index, hit); a smooth rebound has blocks 0 to 2.

Bounce number k = 0, 1, ... of the same hit takes its random numbers, of tilt and of rebound, with
the seed (seed XOR k 0x9E3779B97F4A7C15 mod 2^64). The seed of the first bounce is the seed itself.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sampler.compilation.jit import (
    inline_kernel,
    kernel,
    no_refcount_inline_kernel,
    no_refcount_kernel,
)
from sampler.drawing.frames import (
    LEAST_SPEED,
    check_out,
    impact_angle,
    impact_status,
    rebound,
    tangent,
)
from sampler.drawing.grain import OWN_GRAIN
from sampler.drawing.kernel import grain_at
from sampler.drawing.normal import normal_cdf, normal_quantile
from sampler.drawing.philox import philox_block, uniform
from sampler.drawing.vectors import Vector, combine, dot, unit
from sampler.errors import (
    CASCADE_NOT_ENDED,
    NOT_APPROACHING,
    OK,
    ROUGHNESS_NOT_USABLE,
    SPEED_NOT_POSITIVE,
    TILT_NOT_FOUND,
)
from sampler.formats.bounds import TableArrays

#: Largest roughness, rad. Beyond it a normal law of tilts describes no surface.
MAX_ROUGHNESS = 0.5

#: Block of the random words of the first trial of a tilt.
TILT_BLOCK = 3

#: Trials of a tilt, and bounces of a hit, after which an error is returned.
MAX_TRIALS = 64
MAX_BOUNCES = 64

#: Angle between path and facet [rad] from which a facet is met. One in 10^14 is nearer to it.
_SHADOW = 1e-9

#: Bounds c where it has no effect any more, and its reciprocal would.
_STEEP = 1e9

_BOUNCE_KEY = np.uint64(0x9E37_79B9_7F4A_7C15)

_ROOT_HALF_PI = 1.0 / math.sqrt(2.0 * math.pi)


@inline_kernel
def bounce_seed(seed: int, bounce: int) -> Any:
    """Seed of the random numbers of a bounce within a hit, uint64."""
    return np.uint64(seed) ^ (np.uint64(bounce) * _BOUNCE_KEY)


@kernel
def proposed_score(c: float, u_part: float, u_size: float, u_side: float) -> float:
    """Draw z with a density ~ phi(z) (c + z), z > -c, from three uniform numbers in (0, 1).

    Parameters
    ----------
    c : float
        Not negative.
    u_part, u_size, u_side : float
        Choose the part of the density, the size of z, and its sign.
    """
    plain = c * normal_cdf(c)
    rayleigh = _ROOT_HALF_PI * math.exp(-0.5 * c * c)
    if u_part * (plain + rayleigh) >= plain:
        # z phi(z) for z > c
        return math.sqrt(c * c - 2.0 * math.log(u_size))
    below = normal_cdf(-c)
    z = normal_quantile(below + u_size * (1.0 - below))
    # phi(z) becomes phi(z) (1 + z / c) for |z| < c: each -z gives as much as z lacks
    return -z if z < c and 2.0 * u_side * c < c - z else z


@kernel
def tilt_from_words(
    alpha1: float, roughness: float, w0: np.uint32, w1: np.uint32, w2: np.uint32, w3: np.uint32
) -> tuple[bool, float]:
    """One trial of a tilt from four given random words; kept apart for scripted tests.

    Parameters
    ----------
    alpha1 : float
        Angle between path and mean wall, rad, in [0, pi/2].
    roughness : float
        Standard deviation of the tilt of all facets, rad, positive.
    w0, w1, w2, w3 : uint32

    Returns
    -------
    tuple (bool, float)
        Whether the tilt is accepted; the tilt, rad.
    """
    c = min(math.tan(alpha1) / roughness, _STEEP)
    tilt = roughness * proposed_score(c, uniform(w0), uniform(w1), uniform(w2))
    local = alpha1 + tilt
    if not _SHADOW < local < math.pi - _SHADOW or abs(tilt) >= 0.5 * math.pi:
        return False, tilt
    bound = math.sin(alpha1) + tilt * math.cos(alpha1)
    return uniform(w3) * bound < math.sin(local), tilt


@kernel
def draw_tilt(
    alpha1: float, roughness: float, seed: int, index: int, hit: int
) -> tuple[bool, float]:
    """Tilt of the facet that a particle meets; a pure function of its arguments.

    Parameters
    ----------
    alpha1, roughness : float
        As for `tilt_from_words`.
    seed, index, hit : int
        Keys, as for `sampler.draw`.

    Returns
    -------
    tuple (bool, float)
        Whether one was accepted; the tilt, rad.
    """
    for trial in range(MAX_TRIALS):
        w0, w1, w2, w3 = philox_block(seed, index, hit, TILT_BLOCK + trial)
        accepted, tilt = tilt_from_words(alpha1, roughness, w0, w1, w2, w3)
        if accepted:
            return True, tilt
    return False, 0.0


@inline_kernel
def facet_normal(
    velocity: Vector, e_y: Vector, tilt: float, seed: int, index: int, hit: int
) -> Vector:
    """Return the normal e_y of the mean wall tilted (rad) in the plane of incidence.

    At normal impact, where there is no such plane, in one at the azimuth of the keys.
    """
    e_x = tangent(velocity, e_y, seed, index, hit)
    return combine(math.cos(tilt), e_y, -math.sin(tilt), e_x)


@no_refcount_inline_kernel
def _first_spin(
    arrays: TableArrays, seed: int, index: int, omega: Vector | None, grain: Vector | None
) -> tuple[Vector, Vector]:
    """Spin before the first bounce and grain of all; without a spin neither counts."""
    if omega is None:
        return (0.0, 0.0, 0.0), (0.0, 1.0, 1.0)
    spin = (float(omega[0]), float(omega[1]), float(omega[2]))
    if grain is None:
        return spin, grain_at(arrays, seed, index, OWN_GRAIN)
    return spin, (float(grain[0]), float(grain[1]), float(grain[2]))


@no_refcount_inline_kernel
def _bounce(
    arrays: TableArrays,
    impact: tuple[Vector, Vector, float, Vector, int, int, int],
    spinning: Vector,
    kept: Vector,
    omega: Vector | None,
    grain: Vector | None,
    out: NDArray[np.float64],
) -> int:
    """One bounce: with the spin that the particle has where one was given before the first."""
    if omega is None:
        return rebound(arrays, *impact, out, None, grain)
    return rebound(arrays, *impact, out, spinning, kept)


@no_refcount_kernel
def rough_bounces(
    arrays: TableArrays,
    velocity: Vector,
    normal: Vector,
    half_size: float,
    wall_velocity: Vector,
    roughness: float,
    seed: int,
    index: int,
    hit: int,
    out: NDArray[np.float64],
    omega: Vector | None = None,
    grain: Vector | None = None,
) -> tuple[int, int]:
    """As `rough_rebound`; also how often the particle bounced before it left.

    With a spin, a bounce has that of the one before, and all have the same grain.

    Returns
    -------
    tuple of two int
        Status and number of bounces.
    """
    if not 0.0 <= roughness <= MAX_ROUGHNESS:  # nor NaN
        return ROUGHNESS_NOT_USABLE, 0
    if roughness == 0.0:
        smooth = (arrays, velocity, normal, half_size, wall_velocity, seed, index, hit, out)
        return rebound(*smooth, omega, grain), 1
    status = impact_status(velocity, normal, half_size, wall_velocity)
    if status != OK:
        return status, 0
    # until it leaves, the particle moves relative to the wall
    moving = combine(1.0, velocity, -1.0, wall_velocity)
    if math.sqrt(dot(moving, moving)) < LEAST_SPEED:
        return SPEED_NOT_POSITIVE, 0
    e_y, at_rest = unit(normal), (0.0, 0.0, 0.0)
    if not dot(moving, e_y) < 0.0:
        return NOT_APPROACHING, 0
    clamped = OK
    # all bounces have one grain, though each has a seed of its own
    spinning, kept = _first_spin(arrays, seed, index, omega, grain)
    for bounce in range(MAX_BOUNCES):
        key = bounce_seed(seed, bounce)
        alpha1 = max(impact_angle(moving, e_y)[0], 0.0)
        found, tilt = draw_tilt(alpha1, roughness, key, index, hit)
        if not found:
            return TILT_NOT_FOUND, bounce
        facet = facet_normal(moving, e_y, tilt, key, index, hit)
        impact = (moving, facet, half_size, at_rest, key, index, hit)
        status = _bounce(arrays, impact, spinning, kept, omega, grain, out)
        if status < OK:
            return status, bounce
        clamped = max(clamped, status)
        moving = (out[0], out[1], out[2])
        spinning = (out[3], out[4], out[5])
        if dot(moving, e_y) > 0.0:
            for axis in range(3):
                out[axis] += wall_velocity[axis]
            return clamped, bounce + 1
    return CASCADE_NOT_ENDED, MAX_BOUNCES


@no_refcount_kernel
def rough_rebound(
    arrays: TableArrays,
    velocity: Vector,
    normal: Vector,
    half_size: float,
    wall_velocity: Vector,
    roughness: float,
    seed: int,
    index: int,
    hit: int,
    out: NDArray[np.float64],
    omega: Vector | None = None,
    grain: Vector | None = None,
) -> int:
    """Rebound of one particle from a rough wall, in the lab frame.

    Callable from the user's own compiled code, in place of `sampler.drawing.frames.rebound`.
    Without `omega`, the particle arrives without spin at every bounce, and the spin after the last
    one counts; with it, a bounce has the spin that the one before has left.

    Parameters
    ----------
    arrays, velocity, normal, half_size, wall_velocity, seed, index, hit
        As for `sampler.drawing.frames.rebound`; the normal is that of the mean wall.
    roughness : float
        Standard deviation of the tilt of facets, rad, in [0, MAX_ROUGHNESS]; 0: a smooth wall.
    out : float64 array, shape (6,), written
        Velocity in m/s, then angular velocity in rad/s, lab frame. Left undefined on an error.
    omega, grain : tuple of three float, optional
        As for `sampler.drawing.frames.rebound`.

    Returns
    -------
    int
        As `sampler.drawing.frames.rebound`; `CLAMPED` if any bounce was; also `TILT_NOT_FOUND` (-6)
        and `CASCADE_NOT_ENDED` (-7), with probabilities below 1e-50 and 1e-30 a hit, and
        `ROUGHNESS_NOT_USABLE` (-8).

    Raises
    ------
    ValueError
        As `sampler.drawing.frames.rebound`.
    """
    check_out(out)
    impact = (arrays, velocity, normal, half_size, wall_velocity, roughness, seed, index, hit, out)
    return rough_bounces(*impact, omega, grain)[0]
