"""Known-answer vectors: small tables, and what they must give for keys and conditions.

    python tests/vectors/make_vectors.py

writes, beside itself, for each table of `TABLES` the file NAME.h5, its image NAME.rbt, and NAME.txt
with one case a line, numbers as hexadecimal floating point:

    draw ALPHA1 SPEED SEED INDEX HIT CODE VALUE*8 [WORK*2]
    rebound VELOCITY*3 NORMAL*3 HALF_SIZE WALL_VELOCITY*3 SEED INDEX HIT CODE VELOCITY*3 OMEGA*3
    rough-rebound VELOCITY*3 NORMAL*3 HALF_SIZE WALL_VELOCITY*3 ROUGHNESS SEED INDEX HIT CODE ...

Lines of a table without the work of the impulses, which is 0 then, do not have it. The file
spin.txt, of a table with a spin law, has other lines: `tests/embedding/spin_vectors.py`.

With an error code nothing may be written, and the values are 0. The tests of Python, C, C++ and
Fortran read these files. The draw in Python, which makes them, is compared with an independent one
in tests/sampler; run this script again only when the draw is meant to change.
"""

import itertools
import math
import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
TESTS = HERE.parent
sys.path[:0] = map(str, (HERE.parents[1], TESTS, TESTS / "sampler", TESTS / "embedding"))

from sampler.drawing.frames import rebound  # noqa: E402
from sampler.drawing.kernel import draw  # noqa: E402
from small_tables import SMALL_TABLES, plane  # noqa: E402  (folders of the tests)
from spin_tables import with_spin_law  # noqa: E402
from spin_vectors import spin_lines  # noqa: E402

from sampler.formats.channels import VARIABLES  # noqa: E402
from sampler.formats.hdf5 import write_table  # noqa: E402
from sampler.formats.image import write_binary_table  # noqa: E402
from sampler.table import Table  # noqa: E402
from tablegen.model.roughness import rough_rebound  # noqa: E402

MOST = 2**64 - 1
NAN, INFINITE = math.nan, math.inf
KEYS = ((0, 0, 0), (7, 123, 4), (MOST, MOST, 2**32 - 1), (1, 2**32, 1), (2**32, 5, 0))


def draw_conditions(table):
    """Inside, at nodes, at both ends, outside by rounding and by more, and all that is refused."""
    (a0, a1), (v0, v1) = table.alpha_range, table.speed_range
    inside = [
        (a0 + f * (a1 - a0), v0 + g * (v1 - v0)) for f, g in ((0.1, 0.7), (0.5, 0.5), (0.83, 0.2))
    ]
    ends = [(a, v) for a in (a0, a1) for v in (v0, v1)]
    rounded = [(a0 * (1 - 5e-13), v0), (a1, v1 * (1 + 5e-13)), (a1 + 5e-13, v0)]
    outside = [
        (0.9 * a0, v0),
        (a1, 1.1 * v1),
        (a0, 0.9 * v0),
        (5e-324, 1e300),
        (0.5 * math.pi, 5e-324),
    ]
    refused = [
        (NAN, v0), (a0, NAN), (INFINITE, v0), (a0, -INFINITE), (NAN, -1.0),
        (0.0, v0), (-0.1, v0), (-0.1, 0.0), (1.6, v0), (a0, 0.0), (a0, -1.0),
    ]  # fmt: skip
    return inside + ends + rounded + outside + refused


def rebound_conditions(table):
    """Oblique, normal, moving walls, scaled normals, and all that is refused."""
    low, high = table.speed_range
    v = 0.5 * (low + high)
    rest, tilted = (0.0, 0.0, 0.0), (0.3, -2.0, 0.7)
    moving = (3.0, -4.0, 5.0)
    return [
        ((0.8 * v, -0.6 * v, 0.0), (0.0, 1.0, 0.0), 2e-5, rest),
        ((0.1 * v, 0.9 * v, -0.2 * v), tilted, 1e-3, moving),
        ((0.0, -v, 0.0), (0.0, 1.0, 0.0), 1.0, rest),  # normal impact: uniform azimuth
        ((1e-14 * v, 0.0, v), (0.0, 0.0, -1e-300), 1.0, rest),
        ((v, 0.0, 0.0), (-3.0, 0.0, 0.0), 1e-5, rest),
        ((-3.0, 0.0, 0.0), (1.0, 1e-9, 0.0), 1e-5, (v, 2.0, 0.0)),  # the wall comes to the particle
        ((1e-3, -1e-3, 0.0), (0.0, 1e300, 0.0), 1.0, rest),  # clamped
        ((NAN, -v, 0.0), (0.0, 1.0, 0.0), 1.0, rest),
        ((0.0, -v, 0.0), (0.0, INFINITE, 0.0), 1.0, rest),
        ((0.0, -v, 0.0), (0.0, 0.0, 0.0), -1.0, (0.0, NAN, 0.0)),
        ((0.0, -v, 0.0), (0.0, 0.0, 0.0), -1.0, rest),
        ((0.0, -v, 0.0), (0.0, 1.0, 0.0), 0.0, rest),
        ((1.0, 2.0, 3.0), (0.0, 1.0, 0.0), 1.0, (1.0, 2.0, 3.0)),
        ((0.0, v, 0.0), (0.0, 1.0, 0.0), 1.0, rest),
        ((v, 0.0, 0.0), (0.0, 1.0, 0.0), 1.0, rest),
        ((0.0, -1e200, 0.0), (0.0, 1.0, 0.0), 1.0, rest),
    ]


def rough_conditions(table):
    """Steep, grazing and normal impacts with their roughness, and all that is refused."""
    v = 0.5 * sum(table.speed_range)
    rest, up, tilted, moving = (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.3, -2.0, 0.7), (3.0, -4.0, 5.0)
    oblique = (0.8 * v, -0.6 * v, 0.0)
    return [
        (oblique, up, 2e-5, rest, 0.0),
        (oblique, up, 2e-5, rest, 0.1),
        ((0.9 * v, -0.01 * v, 0.4 * v), up, 1e-3, rest, 0.05),  # grazing: most facets are in shadow
        ((0.1 * v, 0.9 * v, -0.2 * v), tilted, 1e-3, moving, 0.5),  # several bounces
        ((0.0, -v, 0.0), up, 1.0, rest, 0.3),  # normal impact: any plane
        (oblique, up, 2e-5, rest, -0.1),
        (oblique, up, 2e-5, rest, 0.51),
        (oblique, up, 2e-5, rest, NAN),
        ((v, 0.0, 0.0), up, 1.0, rest, 0.1),
        ((NAN, -v, 0.0), up, 1.0, rest, 0.1),
        (oblique, rest, 1.0, rest, 0.1),
        (oblique, up, 0.0, rest, 0.1),
        ((1.0, 2.0, 3.0), up, 1.0, (1.0, 2.0, 3.0), 0.1),
    ]


def hexadecimal(numbers):
    """Numbers that every language reads back to the same bits."""
    return " ".join(float(x).hex() for x in numbers)


def cases(table):
    """Lines of the file of vectors."""
    for (alpha1, speed), keys in itertools.product(draw_conditions(table), KEYS):
        values = np.zeros(len(VARIABLES) if "work_shear" in table.columns else 8)
        code = draw(table.arrays, alpha1, speed, *keys_of(keys), values)
        yield f"draw {hexadecimal((alpha1, speed))} {text_of(keys)} {code} {hexadecimal(values)}"
    for condition, keys in itertools.product(rebound_conditions(table), KEYS):
        velocity, normal, half_size, wall = condition
        out = np.zeros(6)
        code = rebound(table.arrays, velocity, normal, half_size, wall, *keys_of(keys), out)
        given = hexadecimal((*velocity, *normal, half_size, *wall))
        out = out if code >= 0 else np.zeros(6)
        yield f"rebound {given} {text_of(keys)} {code} {hexadecimal(out)}"
    for condition, keys in itertools.product(rough_conditions(table), KEYS):
        velocity, normal, half_size, wall, _ = condition
        out = np.zeros(6)
        code = rough_rebound(table.arrays, *condition, *keys_of(keys), out)
        given = hexadecimal((*velocity, *normal, half_size, *wall, condition[-1]))
        out = out if code >= 0 else np.zeros(6)
        yield f"rough-rebound {given} {text_of(keys)} {code} {hexadecimal(out)}"


def keys_of(keys):
    """Keys as the kernels take them."""
    return np.uint64(keys[0]), np.uint64(keys[1]), np.uint32(keys[2])


def text_of(keys):
    """Keys as decimal numbers."""
    return " ".join(str(key) for key in keys)


def write(name, contents, lines):
    """Write the three files of a table."""
    write_table(HERE / f"{name}.h5", contents)
    write_binary_table(HERE / f"{name}.rbt", contents)
    (HERE / f"{name}.txt").write_text("".join(lines), encoding="ascii")


def main():
    """Write all files."""
    for name, make in SMALL_TABLES.items():
        contents = make()
        write(name, contents, [f"{line}\n" for line in cases(Table(contents))])
    spin = with_spin_law(plane(), codes=(0, 4), depth=0)
    write("spin", spin, spin_lines(spin))


if __name__ == "__main__":
    main()
