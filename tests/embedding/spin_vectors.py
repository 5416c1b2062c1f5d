"""Draws and rebounds of particles that arrive spinning, by Python, as lines that programs read.

    spin-draw ALPHA1 SPEED SPIN*3 SEED INDEX HIT CODE STATE*6
    spin-rebound VELOCITY*3 NORMAL*3 HALF_SIZE WALL_VELOCITY*3 OMEGA*3 SEED INDEX HIT CODE \\
        VELOCITY*3 OMEGA*3
    spin-rough VELOCITY*3 NORMAL*3 HALF_SIZE WALL_VELOCITY*3 ROUGHNESS OMEGA*3 SEED INDEX HIT \\
        CODE VELOCITY*3 OMEGA*3

otherwise as the files of `tests/vectors`.
"""

import itertools
import math

import numpy as np
from sampler.drawing.rough_batch import rough_rebound_batch
from sampler.drawing.spin_draw import spin_draw_batch
from sampler.drawing.spin_frames import spin_rebound_batch
from small_tables import plane
from spin_tables import with_spin_law

from sampler.formats.image import table_arrays, write_binary_table
from tablegen.model.random_particles import OWN_GRAIN

MOST = 2**64 - 1
KEYS = ((0, 0, 0), (7, 123, 4), (MOST, MOST, 2**32 - 1), (1, 2**32, 1), (2**32, 5, 0))
NAN, INFINITE = math.nan, math.inf
REST, UP = (0.0, 0.0, 0.0), (0.0, 1.0, 0.0)

#: Angle, speed and spin: at zero spin, on both sides of the plane, outside, and what is refused.
DRAWS = (
    (0.5, 100.0, (0.0, 0.0, 0.0)), (0.5, 100.0, (-0.0, 1e-9, 0.0)), (0.1, 60.0, (0.3, -1.0, -0.8)),
    (0.1, 60.0, (-0.3, 1.0, -0.8)), (1.2, 250.0, (4.0, 3.0, 2.0)), (0.5 * math.pi, 20.0, (0, 0, 9)),
    (1.0, 1e-3, (1e4, -2e4, 1e4)), (1.0, 1e-3, (1.0, 1.0, 1.0)), (1e-3, 900.0, (0.1, 0.2, 0.3)),
    (NAN, 100.0, REST), (0.5, 100.0, (NAN, 0, 0)), (0.5, 100.0, (0, INFINITE, 0)),
    (0.5, 100.0, (0, 0, 1e160)), (0.0, 100.0, REST), (0.0, 100.0, (NAN, 0, 0)), (0.5, 0.0, REST),
)  # fmt: skip

#: Velocity, normal, half-size, velocity of the wall, angular velocity.
REBOUNDS = (
    ((80.0, -60.0, 0.0), UP, 2e-5, REST, (0.0, 0.0, -4e6)),
    ((80.0, -60.0, 0.0), UP, 2e-5, REST, REST),
    ((10.0, 90.0, -20.0), (0.3, -2.0, 0.7), 1e-3, (3.0, -4.0, 5.0), (1e5, -2e5, 3e4)),
    ((0.0, -100.0, 0.0), UP, 1.0, REST, (50.0, 60.0, -70.0)),  # normal impact: uniform azimuth
    ((80.0, -60.0, 0.0), UP, 2e-5, REST, (NAN, 0.0, 0.0)),
    ((80.0, 60.0, 0.0), UP, 2e-5, REST, (NAN, 0.0, 0.0)),
    ((80.0, 60.0, 0.0), UP, 2e-5, REST, (1.0, 0.0, 0.0)),
    ((80.0, -60.0, 0.0), REST, 2e-5, REST, (1.0, 0.0, 0.0)),
)


#: Velocity, normal, half-size, velocity of the wall, roughness, angular velocity.
ROUGH_REBOUNDS = tuple(
    (*impact[:4], roughness, impact[4])
    for impact, roughness in zip(REBOUNDS, (0.1, 0.3, 0.5, 0.2, 0.1, 0.1, 0.6, 0.1), strict=True)
)


def hexadecimal(numbers):
    """Numbers that every language reads back to the same bits."""
    return " ".join(float(x).hex() for x in numbers)


def line(kind, given, keys, batch):
    """Case of a function from keys and results to what a batch returns."""
    results, own, none = np.zeros((1, 6)), np.array([OWN_GRAIN]), np.zeros((0, 3))
    index, hit = np.array([keys[1]], np.uint64), np.array([keys[2]], np.uint32)
    row, code, _, clamped, _ = batch(none, own, np.uint64(keys[0]), index, hit, results, 0, 1)
    code = code if row >= 0 else clamped
    results = results if code >= 0 else np.zeros((1, 6))
    text = " ".join(str(key) for key in keys)
    return f"{kind} {hexadecimal(given)} {text} {code} {hexadecimal(results[0])}\n"


def draw_line(arrays, condition, keys):
    """Line of a draw, all of whose columns the table gives or leaves 0."""
    alpha1, speed, spin = condition
    given = np.array([alpha1]), np.array([speed]), np.array([spin], dtype=float)

    def batch(none, own, seed, index, hit, results, start, stop):
        columns = np.zeros((1, len(arrays.columns)))
        found = spin_draw_batch(arrays, *given, none, own, seed, index, hit, columns, start, stop)
        results[:, arrays.columns] = columns
        return found

    return line("spin-draw", (alpha1, speed, *spin), keys, batch)


def rebound_line(arrays, impact, keys):
    """Line of a rebound in the lab frame."""
    velocity, normal, half_size, wall, omega = impact
    given = [np.array([v]) for v in (velocity, normal, half_size, wall, omega)]

    def batch(*rest):
        return spin_rebound_batch(arrays, *given, *rest)

    return line("spin-rebound", (*velocity, *normal, half_size, *wall, *omega), keys, batch)


def rough_line(arrays, impact, keys):
    """Line of a rebound from a rough wall."""
    velocity, normal, half_size, wall, roughness, omega = impact
    given = [np.array([v], dtype=float) for v in impact]

    def batch(*rest):
        return rough_rebound_batch(arrays, *given, *rest)

    numbers = (*velocity, *normal, half_size, *wall, roughness, *omega)
    return line("spin-rough", numbers, keys, batch)


def spin_lines(contents):
    """Lines of a table with a spin law."""
    arrays = table_arrays(contents)
    lines = [draw_line(arrays, *case) for case in itertools.product(DRAWS, KEYS)]
    lines += [rebound_line(arrays, *case) for case in itertools.product(REBOUNDS, KEYS)]
    return lines + [rough_line(arrays, *case) for case in itertools.product(ROUGH_REBOUNDS, KEYS)]


def write_spin_vectors(folder, make=plane):
    """Write a small table with a spin law and its lines; their files and the number of lines."""
    contents = with_spin_law(make(), codes=(0, 3, 4, 7), depth=1)
    write_binary_table(folder / "spin.rbt", contents)
    lines = spin_lines(contents)
    (folder / "spin.txt").write_text("".join(lines), encoding="ascii")
    return folder / "spin.rbt", folder / "spin.txt", len(lines)
