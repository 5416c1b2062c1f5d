"""Four models of what a hit does to a particle.

All take the velocity and the spin before the hit, the wall normal and the keys (seed, particle,
hit) of the random numbers, and hold the law at the ends of the table's range of angle and speed,
beyond which the restitution was not measured.

``spheres`` bounce regularly, without a spin. ``direct`` simulates each hit with the spin that the
particle has and with its own grain, the same at every hit. ``memoryless`` simulates each hit of
another grain of the population, without spin. ``table`` draws from the table: with spin and grain,
as direct, if the table has the law of particles that arrive spinning, else without, as memoryless.
So it should agree with the one of the two that is its law (`tabulated`), and these differ by what a
table without spin leaves out.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from sampler.compilation.jit import inline_kernel, no_refcount_kernel
from sampler.drawing.frames import NORMAL_IMPACT, along_wall, impact_angle, perpendicular
from sampler.drawing.frames import rebound as table_rebound
from sampler.drawing.philox import philox_block, uniform
from sampler.drawing.vectors import cross, dot

import tablegen
from sampler.errors import CLAMPED, NOT_APPROACHING, OK
from sampler.table import Table
from tablegen.config.config import Config
from tablegen.model.rebound import MOTION_SIZE, U, V, W, collide, wall_spin
from tablegen.model.rotation import ORDER

SPHERES, MEMORYLESS, DIRECT, TABLE = 0, 1, 2, 3

#: Names of the models, in the order of their codes.
MODELS = ("spheres", "memoryless", "direct", "table")

#: Block of the keys' random words for the azimuth at normal impact.
_AZIMUTH_BLOCK = 2

#: An excess over the range of the law below this, relative, is none.
_ROUNDING = 1e-12


class Wall(NamedTuple):
    """What the models need, whichever is used.

    ``model``: a code of `MODELS`. ``direct``: arrays of the direct model, ``work_size``: numbers
    that it works in. ``arrays``: of the table, ``spins``: whether it takes the spin before a hit.
    ``limits``: least and largest impact angle (rad) and speed (m/s).
    """

    model: int
    direct: Any
    work_size: int
    arrays: Any
    spins: bool
    limits: tuple[float, float, float, float]


class Store(NamedTuple):
    """Arrays that one thread's rebounds work in."""

    motion: np.ndarray
    point: np.ndarray
    series: np.ndarray
    work: np.ndarray


def make_wall(model, config: Config, table: Table) -> Wall:
    """Wall of one of the `MODELS`; the laws are those from which the table was made."""
    direct = tablegen.DirectModel(config)
    limits = (*table.alpha_range, *table.speed_range)
    return Wall(
        MODELS.index(model), direct.arrays, direct.work_size, table.arrays, table.has_spin, limits
    )


def tabulated(table: Table) -> str:
    """Name of the model whose law a table holds."""
    return "direct" if table.has_spin else "memoryless"


def make_store(wall: Wall) -> Store:
    """Arrays for one thread."""
    point, series = np.array([0.0, -1.0, 0.0]), np.empty((9, ORDER + 1))
    return Store(np.empty(MOTION_SIZE), point, series, np.empty(wall.work_size))


@no_refcount_kernel
def sphere_state(wall, alpha1, speed, store, out):
    """State of a sphere after its only collision, in the frame of the impact."""
    motion = store.motion
    for i in range(MOTION_SIZE):
        motion[i] = 1.0 if i in (4, 6) else 0.0
    motion[U], motion[V] = math.cos(alpha1), -math.sin(alpha1)
    law, resolution = wall.direct.law, wall.direct.numerics[0]
    collide(law, speed, resolution, (0.4, 0.4, 0.4), store.point, motion, store.series)
    out[0], out[1], out[2] = motion[U], motion[V], motion[W]
    out[3], out[4], out[5] = wall_spin(motion)
    return OK


@no_refcount_kernel
def direct_state(wall, alpha1, speed, spin, keys, store, out):
    """State of a particle of the population after its rebound, simulated.

    Parameters
    ----------
    wall : Wall
    alpha1, speed : float
        rad and m/s.
    spin : tuple of three float
        Before the impact, times a/V, in the frame of the impact.
    keys : tuple of three int
        Seed, particle and hit.
    store : Store
    out : (6,) float64, written
    """
    seed, index, hit = keys
    direct = wall.direct
    if wall.model == MEMORYLESS:
        grain, spin = tablegen.grain(direct, seed, index, hit), (0.0, 0.0, 0.0)
    else:
        grain = tablegen.grain(direct, seed, index, 0)
    return tablegen.draw(direct, alpha1, speed, spin, grain, seed, index, hit, store.work, out)


@inline_kernel
def _along(vector, e_x, e_y, scale):
    """Components of a vector along e_x, e_y and e_x cross e_y, times a scale."""
    e_z = cross(e_x, e_y)
    return scale * dot(vector, e_x), scale * dot(vector, e_y), scale * dot(vector, e_z)


@inline_kernel
def _to_lab(e_x, e_y, u, v, w):
    """Components along e_x, e_y and e_x cross e_y, as a vector in the lab frame."""
    e_z = cross(e_x, e_y)
    return (
        u * e_x[0] + v * e_y[0] + w * e_z[0],
        u * e_x[1] + v * e_y[1] + w * e_z[1],
        u * e_x[2] + v * e_y[2] + w * e_z[2],
    )


@no_refcount_kernel
def _simulated_rebound(wall, velocity, normal, half_size, omega, keys, store, out):
    """Rebound by one of the models that do not draw from the table."""
    speed = math.sqrt(velocity[0] ** 2 + velocity[1] ** 2 + velocity[2] ** 2)
    alpha1, tangential = impact_angle(velocity, normal)
    if not alpha1 > 0.0:
        return NOT_APPROACHING
    low_alpha, high_alpha, low_speed, high_speed = wall.limits
    alpha_in, speed_in = (
        min(max(alpha1, low_alpha), high_alpha),
        min(max(speed, low_speed), high_speed),
    )
    if tangential <= NORMAL_IMPACT * speed:
        word = philox_block(keys[0], keys[1], keys[2], _AZIMUTH_BLOCK)[0]
        e_x = perpendicular(normal, 2.0 * math.pi * uniform(word))
    else:
        e_x = along_wall(velocity, normal)
    if wall.model == SPHERES:
        status = sphere_state(wall, alpha_in, speed_in, store, out)
    else:
        spin = _along(omega, e_x, normal, half_size / speed)
        status = direct_state(wall, alpha_in, speed_in, spin, keys, store, out)
    if status < OK:
        return status
    after = _to_lab(e_x, normal, speed * out[0], speed * out[1], speed * out[2])
    scale = speed / half_size
    turned = _to_lab(e_x, normal, scale * out[3], scale * out[4], scale * out[5])
    for k in range(3):
        out[k], out[3 + k] = after[k], turned[k]
    moved = abs(alpha_in - alpha1) > _ROUNDING * alpha1 or abs(speed_in - speed) > _ROUNDING * speed
    return CLAMPED if moved else OK


@no_refcount_kernel
def rebound_at_wall(wall, velocity, normal, half_size, omega, keys, store, out):
    """Rebound of one particle from a wall at rest, in the lab frame.

    Parameters
    ----------
    wall : Wall
    velocity : tuple of three float
        m/s.
    normal : tuple of three float
        Into the gas, of length one.
    half_size : float
        m.
    omega : tuple of three float
        Angular velocity before the hit, rad/s.
    keys : tuple of three int
        Seed, particle, and how many walls it has met before.
    store : Store
    out : (6,) float64, written
        Velocity in m/s, then angular velocity in rad/s.

    Returns
    -------
    int
        `OK`, `CLAMPED` (the law was held at the end of its range), or negative on an error.
    """
    if wall.model == TABLE:
        at_rest = (0.0, 0.0, 0.0)
        seed, index, hit = keys
        if wall.spins:
            return table_rebound(
                wall.arrays, velocity, normal, half_size, at_rest, seed, index, hit, out, omega
            )
        return table_rebound(
            wall.arrays, velocity, normal, half_size, at_rest, seed, index, hit, out
        )
    return _simulated_rebound(wall, velocity, normal, half_size, omega, keys, store, out)
