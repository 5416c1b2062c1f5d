"""Shoot particles at walls in code_saturne, and compare their rebounds with Python.

    PYTHONPATH=tests python tests/code_saturne/saturne_wall.py FOLDER [COUNT]

FOLDER is a working folder, with corundum-steel.rbt; COUNT the number of particles of each
condition in each run. All hits are compared with Python's draws with the same keys, and first hits
on floor and lid, those with `spin no`, with direct simulation. Prints a table, and ends with 1 if a
distance is larger than is allowed.
"""

import shutil
import sys
from pathlib import Path

import box_run
import numpy as np
import saturne_run
from first_hits import CONDITIONS, REFERENCE, compare, direct_states, print_rows

import sampler

#: Particles of each condition.
COUNT = 40_000
STEP, STEPS = 5e-4, 40
#: Largest difference of a velocity from Python's draw [m/s].
DIFFERENCE = 1e-9


def difference_from_python(table, hits, spin):
    """Largest difference of a velocity [m/s] from the draw of Python with the same keys."""
    # straight on, the direction along the wall is as the frame of the face has it
    rows = ~(box_run.is_normal(hits.index) & (hits.hit == 0))
    given = hits if spin else hits._replace(omega=None, inertia=None)
    drawn = box_run.rebound(table, given).velocity
    return float(np.abs(drawn - hits.new_velocity)[rows].max())


def _runs(work, count):
    """Name of each run, and the hits that it has to show."""
    folder = work / "wall"
    shutil.rmtree(folder, ignore_errors=True)
    given = {"step": STEP, "particles": count * len(CONDITIONS), "symmetry": 2}
    serial = saturne_run.run(work, folder / "serial", STEPS, **given)
    yield "serial", box_run.read_hits(serial)
    half = saturne_run.run(work, folder / "half", STEPS // 2, **given)
    again = saturne_run.run(work, folder / "again", STEPS, processors=2, restart=half, **given)
    yield "restart on two", box_run.read_hits(half, again)
    plain = saturne_run.run(
        work, folder / "plain", STEPS, text=saturne_run.settings(spin="no"), **given
    )
    yield "spin no", box_run.read_hits(plain)


def main(work, count=COUNT):
    table, good = sampler.load("corundum-steel"), True
    for name, hits in _runs(work, count):
        difference = difference_from_python(table, hits, spin=name != "spin no")
        print(f"{name}: largest difference from Python's draws {difference:.1e} m/s")
        good = good and difference < DIFFERENCE
    # hits of the last run
    rows = compare(box_run.states(hits), box_run.conditions(hits), direct_states(REFERENCE))
    print_rows(rows)
    good = good and all(row.holds for row in rows)
    return 0 if good else 1


if __name__ == "__main__":
    try:
        sys.exit(main(Path(sys.argv[1]).resolve(), *map(int, sys.argv[2:])))
    except saturne_run.SaturneError as error:
        sys.exit(str(error))
