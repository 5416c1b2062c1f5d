"""Three models of what a hit does to a particle.

All three take the velocity before the hit, the wall normal and the keys (seed, particle, hit) of
the random numbers, and hold the law at the ends of the table's range of angle and speed, beyond
which the restitution was not measured. A particle arrives without spin, and at every hit it is
another one of the population, in the direct simulation as in the table.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from sampler.compilation.jit import inline_kernel, no_refcount_kernel
from sampler.drawing.frames import NORMAL_IMPACT, along_wall, impact_angle, perpendicular
from sampler.drawing.frames import rebound as table_rebound
from sampler.drawing.philox import philox_block, uniform
from sampler.errors import CLAMPED, NOT_APPROACHING, OK
from sampler.table import Table
from tablegen.config import Config
from tablegen.model.conditions import impact_condition
from tablegen.model.random_particles import draw_particle
from tablegen.model.rebound import (
    LEFT,
    MOTION_SIZE,
    U,
    V,
    W,
    approach,
    collide,
    rebound,
    wall_spin,
    workspace,
)
from tablegen.model.shapes import MAX_VERTICES, shaped_body
from tablegen.model.support_map import empty_map

SPHERES, DIRECT, TABLE = 0, 1, 2

#: Names of the models, in the order of their codes.
MODELS = ("spheres", "direct", "table")

#: Block of the keys' random words for the azimuth at normal impact.
_AZIMUTH_BLOCK = 2

#: An excess over the range of the law below this, relative, is none.
_ROUNDING = 1e-12

#: Status of a direct rebound that met the collision alarm.
UNFINISHED = -100


class Wall(NamedTuple):
    """What the models need, whichever is used.

    ``model``: `SPHERES`, `DIRECT` or `TABLE`. ``law``, ``population``: arguments of the kernels
    of `tablegen.model`. ``arrays``: of the table. ``limits``: least and largest impact angle
    (rad) and speed (m/s). ``resolution``, ``tolerance``: of the direct model.
    """

    model: int
    law: Any
    population: Any
    arrays: Any
    limits: tuple[float, float, float, float]
    resolution: float
    tolerance: float


class Store(NamedTuple):
    """Arrays that one thread's rebounds work in."""

    motion: np.ndarray
    candidates: np.ndarray
    counts: np.ndarray
    no_map: Any
    work: Any
    point: np.ndarray
    audit: np.ndarray


def make_wall(model, config: Config, table: Table) -> Wall:
    """Wall of one of the `MODELS`; the laws are those from which the table was made."""
    return Wall(
        MODELS.index(model),
        config.pair.kernel_arguments(),
        config.population.kernel_arguments(),
        table.arrays,
        (*table.alpha_range, *table.speed_range),
        config.model.contact_resolution,
        config.model.tolerance,
    )


def make_store() -> Store:
    """Arrays for one thread."""
    return Store(
        np.empty(MOTION_SIZE),
        np.zeros((MAX_VERTICES, 3)),
        np.zeros(1, dtype=np.int64),
        empty_map(),
        workspace(),
        np.array([0.0, -1.0, 0.0]),
        np.empty(0),
    )


@no_refcount_kernel
def sphere_state(wall, alpha1, speed, store, out):
    """State of a sphere after its only collision, in the frame of the impact."""
    motion = store.motion
    for i in range(MOTION_SIZE):
        motion[i] = 1.0 if i in (4, 6) else 0.0
    motion[U], motion[V] = math.cos(alpha1), -math.sin(alpha1)
    collide(wall.law, speed, wall.resolution, (0.4, 0.4, 0.4), store.point, motion)
    out[0], out[1], out[2] = motion[U], motion[V], motion[W]
    out[3], out[4], out[5] = wall_spin(motion)
    return OK


@no_refcount_kernel
def direct_state(wall, alpha1, speed, keys, store, out):
    """State of a random particle of the population after its rebound, simulated.

    Parameters
    ----------
    wall : Wall
    alpha1, speed : float
        rad and m/s.
    keys : tuple of three int
        Seed, particle and hit; `tablegen.simulate` gives the same particle for this seed, with
        the hit for a stream.
    store : Store
    out : (6,) float64, written
    """
    motion = store.motion
    seed, index, hit = keys
    shape, ba, cb = draw_particle(wall.population, seed, index, hit, hit, motion)
    body = shaped_body(
        shape, ba, ba * cb, wall.population.truncation, store.candidates, store.counts, store.no_map
    )
    cosine, sine = math.cos(alpha1), math.sin(alpha1)
    numerics = wall.resolution, wall.tolerance
    condition = impact_condition(cosine, sine, speed, (0.0, 0.0, 0.0), numerics)
    approach(condition, body, motion)
    status, _ = rebound(wall.law, condition, body, motion, store.work, store.audit)
    out[0], out[1], out[2] = motion[U], motion[V], motion[W]
    out[3], out[4], out[5] = wall_spin(motion)
    return OK if status == LEFT else UNFINISHED


@inline_kernel
def _to_lab(e_x, e_y, u, v, w):
    """Components along e_x, e_y and e_x cross e_y, as a vector in the lab frame."""
    e_z = (
        e_x[1] * e_y[2] - e_x[2] * e_y[1],
        e_x[2] * e_y[0] - e_x[0] * e_y[2],
        e_x[0] * e_y[1] - e_x[1] * e_y[0],
    )
    return (
        u * e_x[0] + v * e_y[0] + w * e_z[0],
        u * e_x[1] + v * e_y[1] + w * e_z[1],
        u * e_x[2] + v * e_y[2] + w * e_z[2],
    )


@no_refcount_kernel
def _simulated_rebound(wall, velocity, normal, half_size, keys, store, out):
    """Rebound by one of the two models that do not draw from the table."""
    speed = math.sqrt(velocity[0] ** 2 + velocity[1] ** 2 + velocity[2] ** 2)
    alpha1, tangential = impact_angle(velocity, normal)
    if not alpha1 > 0.0:
        return NOT_APPROACHING
    low_alpha, high_alpha, low_speed, high_speed = wall.limits
    alpha_in, speed_in = (
        min(max(alpha1, low_alpha), high_alpha),
        min(max(speed, low_speed), high_speed),
    )
    if wall.model == SPHERES:
        status = sphere_state(wall, alpha_in, speed_in, store, out)
    else:
        status = direct_state(wall, alpha_in, speed_in, keys, store, out)
    if status < OK:
        return status
    if tangential <= NORMAL_IMPACT * speed:
        word = philox_block(keys[0], keys[1], keys[2], _AZIMUTH_BLOCK)[0]
        e_x = perpendicular(normal, 2.0 * math.pi * uniform(word))
    else:
        e_x = along_wall(velocity, normal)
    after = _to_lab(e_x, normal, speed * out[0], speed * out[1], speed * out[2])
    spin = speed / half_size
    turned = _to_lab(e_x, normal, spin * out[3], spin * out[4], spin * out[5])
    for k in range(3):
        out[k], out[3 + k] = after[k], turned[k]
    moved = abs(alpha_in - alpha1) > _ROUNDING * alpha1 or abs(speed_in - speed) > _ROUNDING * speed
    return CLAMPED if moved else OK


@no_refcount_kernel
def rebound_at_wall(wall, velocity, normal, half_size, keys, store, out):
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
        return table_rebound(
            wall.arrays, velocity, normal, half_size, at_rest, seed, index, hit, out
        )
    return _simulated_rebound(wall, velocity, normal, half_size, keys, store, out)
