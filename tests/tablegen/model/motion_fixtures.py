"""Bodies, motions and rebounds for tests of the kernels."""

from dataclasses import dataclass

import numpy as np
from audit import (
    ANGULAR,
    AUDIT_SIZE,
    ENERGY,
    FLIGHT_ENERGY,
    FLIGHT_MOMENTUM,
    NORMAL,
    PENETRATION,
    TANGENTIAL,
)
from one_particle import LEFT, NO_MAP, kernel_condition, rebound, shaped_body, workspace
from scipy.spatial.transform import Rotation

from tablegen.config.config import load_config
from tablegen.model.jit import kernel
from tablegen.model.rebound import (
    MOTION_SIZE,
    departing_spin,
    place_before_impact,
    rotational_energy,
)
from tablegen.model.rotation import ORDER, advance_motion, expand_motion, series_span
from tablegen.model.shapes import MAX_VERTICES, SHAPE_CODES

# called from Python here
rotational_energy = kernel(rotational_energy)
departing_spin = kernel(departing_spin)
workspace = kernel(workspace)

CONFIG = load_config("corundum-steel")
PAIR, POPULATION = CONFIG.pair, CONFIG.population
LAW = PAIR.kernel_arguments()
TRUNCATION = POPULATION.truncation

SHAPES = SHAPE_CODES
NON_SPHERICAL = tuple(name for name in SHAPES if name != "sphere")
#: Violations of the laws that rounding and the flights may give.
ALLOWED = np.zeros(AUDIT_SIZE)
ALLOWED[[ENERGY, ANGULAR, NORMAL, TANGENTIAL]] = 1e-12
ALLOWED[PENETRATION] = 1e-11
ALLOWED[[FLIGHT_ENERGY, FLIGHT_MOMENTUM]] = 1e-9


def body_of(name, b=1.0, c=1.0, truncation=TRUNCATION):
    """Body of a named shape with half-sizes (1, b, c)."""
    storage = np.empty((MAX_VERTICES, 3)), np.zeros(1, dtype=np.int64), NO_MAP
    return shaped_body(SHAPES[name], b, c, truncation, *storage)


def with_vertices(body, vertices):
    """Body with the same moments and half-sizes and other vertices."""
    counts = np.array([len(vertices)])
    return body._replace(
        candidates=np.ascontiguousarray(vertices), counts=counts, support_map=NO_MAP
    )


def random_rotations(rng, count):
    """Uniform rotation matrices, wall axes from body axes."""
    return Rotation.random(count, rng=rng).as_matrix()


def random_aspect(rng, least=0.5):
    """Half-sizes b and c of a random body, each ratio log-uniform from ``least`` to one."""
    ba, cb = np.exp(rng.uniform(np.log(least), 0.0, 2))
    return float(ba), float(ba * cb)


def motion_of(rotation, spin=(0.0, 0.0, 0.0), velocity=(0.0, 0.0, 0.0), height=0.0):
    """Motion array of a body with orientation ``rotation`` (wall from body); wall axes."""
    motion = np.empty(MOTION_SIZE)
    motion[0:3] = rotation.T @ np.asarray(spin)
    motion[3:6] = rotation[1]
    motion[6:9] = rotation[0]
    motion[9:12] = velocity
    motion[12] = height
    return motion


def rotation_of(motion):
    """Orientation of a motion: the matrix that takes body axes to wall axes."""
    normal, axis = motion[3:6], motion[6:9]
    return np.array([axis, normal, np.cross(axis, normal)])


def energy_of(moments, motion):
    """Rotational energy per unit mass."""
    return 0.5 * np.sum(np.asarray(moments) * motion[0:3] ** 2)


def angular_momentum_of(moments, motion):
    """Angular momentum per unit mass in wall axes."""
    return rotation_of(motion) @ (np.asarray(moments) * motion[0:3])


def fly(moments, motion, duration, tolerance=1e-10, longest=np.inf):
    """Turn ``motion`` freely for ``duration``, in place, in steps of at most ``longest``."""
    series = np.empty((9, ORDER + 1))
    left = duration
    while left > 0.0:
        expand_motion(moments, motion, series)
        step = min(left, series_span(series, tolerance), longest)
        advance_motion(moments, series, step, motion)
        left -= step


@dataclass(frozen=True)
class Rebound:
    """Outcome of one rebound."""

    state: np.ndarray
    collisions: int
    energy: float
    audit: np.ndarray


def run_rebound(condition, body, rotation, law=LAW):
    """Follow one particle with a given orientation; audited."""
    condition, motion = kernel_condition(condition), motion_of(rotation)
    audit = np.zeros(AUDIT_SIZE)
    place_before_impact(condition, body, motion)
    status, collisions, _ = rebound(law, condition, body, motion, workspace(), audit)
    assert status == LEFT
    energy = 0.5 * np.sum(motion[9:12] ** 2) + rotational_energy(body.moments, motion)
    spin, _ = departing_spin(body.moments, condition.instant, motion)
    state = np.concatenate([motion[9:12], spin])
    return Rebound(state, collisions, float(energy), audit)
