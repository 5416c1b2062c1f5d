"""Known-answer vectors: small tables, and what they must give for keys and conditions.

    python tests/vectors/make_vectors.py

writes, beside itself, for each table of `TABLES` the file NAME.h5, its image NAME.rbt, and NAME.txt
with one case a line, numbers as hexadecimal floating point:

    draw ALPHA1 SPEED SEED INDEX HIT CODE VALUE*8 [WORK*2]
    rebound VELOCITY*3 NORMAL*3 HALF_SIZE WALL_VELOCITY*3 SEED INDEX HIT CODE VELOCITY*3 OMEGA*3
    rough-rebound VELOCITY*3 NORMAL*3 HALF_SIZE WALL_VELOCITY*3 ROUGHNESS SEED INDEX HIT CODE ...

VALUE are variables, 0 where they are no column of the table; lines of a table without the work of
the impulses do not have it. The table spin, with a spin law, also has other lines, in which SPIN,
OMEGA and the first INERTIA are those before the impact:

    spin-draw ALPHA1 SPEED SPIN*3 INERTIA SEED INDEX HIT CODE STATE*6 [0 0 WORK*2] INERTIA
    spin-rebound VELOCITY*3 NORMAL*3 HALF_SIZE WALL_VELOCITY*3 OMEGA*3 INERTIA SEED INDEX HIT CODE
        VELOCITY*3 OMEGA*3 INERTIA
    spin-rough VELOCITY*3 NORMAL*3 HALF_SIZE WALL_VELOCITY*3 ROUGHNESS OMEGA*3 INERTIA SEED ...

With an error code results are NaN, but those of a rebound with code -3, which are what was before;
the values are 0. The tests of Python, C, C++ and
Fortran read these files. The draw that makes them is compared with an independent one in
tests/sampler; run this script again only when the draw is meant to change.
"""

import itertools
import math
import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
TESTS = HERE.parent
sys.path[:0] = map(str, (HERE.parents[1], TESTS, TESTS / "sampler", TESTS / "embedding"))

from known_vectors import answer  # noqa: E402  (folders of the tests)
from small_tables import SMALL_TABLES, plane, works  # noqa: E402
from spin_tables import LAWS, with_spin_law  # noqa: E402

from sampler.formats.hdf5 import write_table  # noqa: E402
from sampler.formats.image import write_binary_table  # noqa: E402
from sampler.table import Table  # noqa: E402

MOST = 2**64 - 1
NAN, INFINITE = math.nan, math.inf
REST, UP = (0.0, 0.0, 0.0), (0.0, 1.0, 0.0)
KEYS = ((0, 0, 0), (7, 123, 4), (MOST, MOST, 2**32 - 1), (1, 2**32, 1), (2**32, 5, 0))


def draw_conditions(table):
    """Inside, at nodes, at both ends, outside by rounding and by more, and all that is refused."""
    (a0, a1), (v0, v1) = np.radians(table.alpha_nodes_deg[[0, -1]]), table.speed_nodes[[0, -1]]
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
    low, high = table.speed_nodes[[0, -1]]
    v = 0.5 * (low + high)
    rest, tilted = (0.0, 0.0, 0.0), (0.3, -2.0, 0.7)
    moving = (3.0, -4.0, 5.0)
    return [
        ((0.8 * v, -0.6 * v, 0.0), (0.0, 1.0, 0.0), 2e-5, rest),
        ((0.1 * v, 0.9 * v, -0.2 * v), tilted, 1e-3, moving),
        ((0.0, -v, 0.0), (0.0, 1.0, 0.0), 0.1, rest),  # normal impact: uniform azimuth
        ((1e-14 * v, 0.0, v), (0.0, 0.0, -1e-300), 1e-9, rest),
        ((v, 0.0, 0.0), (-3.0, 0.0, 0.0), 1e-5, rest),
        ((-3.0, 0.0, 0.0), (1.0, 1e-9, 0.0), 1e-5, (v, 2.0, 0.0)),  # the wall comes to the particle
        ((1e-3, -1e-3, 0.0), (0.0, 1e300, 0.0), 0.01, rest),  # too slow
        ((NAN, -v, 0.0), (0.0, 1.0, 0.0), 0.01, rest),
        ((0.0, -v, 0.0), (0.0, INFINITE, 0.0), 0.01, rest),
        ((0.0, -v, 0.0), (0.0, 0.0, 0.0), -1.0, (0.0, NAN, 0.0)),
        ((0.0, -v, 0.0), (0.0, 0.0, 0.0), -1.0, rest),
        ((0.0, -v, 0.0), (0.0, 1.0, 0.0), 0.0, rest),
        ((1.0, 2.0, 3.0), (0.0, 1.0, 0.0), 0.01, (1.0, 2.0, 3.0)),
        ((0.0, v, 0.0), (0.0, 1.0, 0.0), 0.01, rest),
        ((v, 0.0, 0.0), (0.0, 1.0, 0.0), 0.01, rest),
        ((0.0, -1e200, 0.0), (0.0, 1.0, 0.0), 0.01, rest),
    ]


def rough_conditions(table):
    """Steep, grazing and normal impacts with their roughness, and all that is refused."""
    v = 0.5 * sum(table.speed_nodes[[0, -1]])
    rest, up, tilted, moving = (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.3, -2.0, 0.7), (3.0, -4.0, 5.0)
    oblique = (0.8 * v, -0.6 * v, 0.0)
    return [
        (oblique, up, 2e-5, rest, 0.0),
        (oblique, up, 2e-5, rest, 0.1),
        ((0.9 * v, -0.01 * v, 0.4 * v), up, 1e-3, rest, 0.05),  # grazing: most facets are in shadow
        ((0.1 * v, 0.9 * v, -0.2 * v), tilted, 1e-3, moving, 0.5),  # several bounces
        ((0.0, -v, 0.0), up, 0.1, rest, 0.3),  # normal impact: any plane
        (oblique, up, 2e-5, rest, -0.1),
        (oblique, up, 2e-5, rest, 0.51),
        (oblique, up, 2e-5, rest, NAN),
        ((v, 0.0, 0.0), up, 0.01, rest, 0.1),
        ((NAN, -v, 0.0), up, 0.01, rest, 0.1),
        (oblique, rest, 0.01, rest, 0.1),
        (oblique, up, 0.0, rest, 0.1),
        ((1.0, 2.0, 3.0), up, 0.01, (1.0, 2.0, 3.0), 0.1),
    ]


#: Angle, speed, spin and inertia: at zero spin, on both sides of the plane, at the fold, where
#: chance takes the side, inertias that are not known or beyond, outside, and what is refused.
SPIN_DRAWS = (
    (0.5, 100.0, (0.0, 0.0, 0.0), 0.0), (0.5, 100.0, (0.0, 0.0, 0.0), 9.0),
    (0.5, 100.0, (-0.0, 1e-9, 0.0), 0.3), (0.1, 60.0, (0.3, -1.0, -0.8), 0.25),
    (0.1, 60.0, (-0.3, 1.0, -0.8), 0.25), (0.1, 60.0, (0.3, -1.0, -0.8), 0.0),
    (1.2, 250.0, (4.0, 3.0, 2.0), 0.3), (0.5 * math.pi, 20.0, (0, 0, 9), 0.0),
    *((0.5, 100.0, (0.02 * k, 1.5, 0.2), 0.3) for k in (-4, -1, 0, 0, 0, 1, 4)),
    (0.7, 80.0, (0.3, 0.2, 0.1), 1e-3), (0.7, 80.0, (0.3, 0.2, 0.1), 0.9),
    (1.0, 1e-3, (1e4, -2e4, 1e4), 0.0), (1.0, 1e-3, (1.0, 1.0, 1.0), 0.3),
    (1e-3, 900.0, (0.1, 0.2, 0.3), 0.3),
    # faster than the table, but not than the pair was measured
    (0.7, 130.0, REST, 0.0), (1e-3, 130.0, REST, 0.0),
    (0.7, 130.0, (0.3, 0.2, 0.1), 0.9), (1e-3, 130.0, (0.3, 0.2, 0.1), 0.9),
    *((0.5, 100.0, (1.0, 0.0, 0.0), k) for k in (-1e-300, NAN, INFINITE)),
    *((*condition, 0.3) for condition in (
        (NAN, 100.0, REST), (0.5, 100.0, (NAN, 0, 0)), (0.5, 100.0, (0, INFINITE, 0)),
        (0.5, 100.0, (0, 0, 1e160)), (0.0, 100.0, REST), (0.0, 100.0, (NAN, 0, 0)),
        (0.5, 0.0, REST),
    )),
)  # fmt: skip

#: Velocity, normal, half-size, velocity of the wall, angular velocity; inertias are 0.3, 0, 0.3 ...
_SPIN_IMPACTS = (
    ((80.0, -60.0, 0.0), UP, 2e-5, REST, (0.0, 0.0, -4e6)),
    ((80.0, -60.0, 0.0), UP, 2e-5, REST, REST),
    ((10.0, 90.0, -20.0), (0.3, -2.0, 0.7), 1e-3, (3.0, -4.0, 5.0), (1e5, -2e5, 3e4)),
    ((0.0, -100.0, 0.0), UP, 0.1, REST, (50.0, 60.0, -70.0)),  # normal impact: uniform azimuth
    ((80.0, -60.0, 0.0), UP, 2e-5, REST, (NAN, 0.0, 0.0)),
    ((80.0, 60.0, 0.0), UP, 2e-5, REST, (NAN, 0.0, 0.0)),
    ((80.0, 60.0, 0.0), UP, 2e-5, REST, (1.0, 0.0, 0.0)),
    ((80.0, -60.0, 0.0), REST, 2e-5, REST, (1.0, 0.0, 0.0)),
)
SPIN_REBOUNDS = tuple((*impact, 0.3 * (k % 2 == 0)) for k, impact in enumerate(_SPIN_IMPACTS))

#: Velocity, normal, half-size, velocity of the wall, roughness, angular velocity, inertia.
SPIN_ROUGH = tuple(
    (*impact[:4], roughness, *impact[4:])
    for impact, roughness in zip(
        SPIN_REBOUNDS, (0.1, 0.3, 0.5, 0.2, 0.1, 0.1, 0.6, 0.1), strict=True
    )
)


def hexadecimal(numbers):
    """Write numbers that every language reads back to the same bits."""
    return " ".join(float(x).hex() for x in numbers)


def flat(condition):
    """Put the numbers of a condition, some of them vectors, in one list."""
    return [float(x) for part in condition for x in (part if isinstance(part, tuple) else (part,))]


def lines(table, kind, conditions):
    for condition, keys in itertools.product(conditions, KEYS):
        given = flat(condition)
        code, values, after = answer(table, kind, given, keys)
        if "work_shear" not in table.columns:
            values = values[: 8 if kind == "draw" else 6]
        values = [*values, *([after] if kind.startswith("spin") else [])]
        text = " ".join(str(key) for key in keys)
        yield f"{kind} {hexadecimal(given)} {text} {code} {hexadecimal(values)}\n"


def cases(table):
    kinds = {
        "draw": draw_conditions(table),
        "rebound": rebound_conditions(table),
        "rough-rebound": rough_conditions(table),
    }
    if table.has_spin and "work_shear" in table.columns:
        kinds = {"spin-draw": SPIN_DRAWS[3:6]}
    elif table.has_spin:
        kinds = {
            "spin-draw": SPIN_DRAWS,
            "spin-rebound": SPIN_REBOUNDS,
            "spin-rough": SPIN_ROUGH,
            # not spinning: as with zeros
            "rebound": rebound_conditions(table)[:4],
            "rough-rebound": rough_conditions(table)[:5],
        }
    for kind, conditions in kinds.items():
        yield from lines(table, kind, conditions)


def main():
    tables = {name: make() for name, make in SMALL_TABLES.items()}
    tables["spin"] = with_spin_law(plane(), codes=(0, 4), depth=0)
    tables["spin-works"] = with_spin_law(works(), codes=(0,), depth=0, laws=LAWS)
    for name, contents in tables.items():
        write_table(HERE / f"{name}.h5", contents)
        write_binary_table(HERE / f"{name}.rbt", contents)
        (HERE / f"{name}.txt").write_text("".join(cases(Table(contents))), encoding="ascii")


if __name__ == "__main__":
    main()
