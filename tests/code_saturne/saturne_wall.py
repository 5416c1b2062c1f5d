"""Shoot particles at walls in code_saturne, and compare their rebounds with Python.

    PYTHONPATH=tests python tests/code_saturne/saturne_wall.py FOLDER [COUNT]

FOLDER is a working folder, with corundum-steel.rbt; COUNT the number of particles of each
condition in each run. First hits on floor and lid are compared with Python's draws from the same
table with other random numbers, those with `spin no` with direct simulation; further hits with
particles that fly through the same box in Python. Prints a table, and ends with 1 if a distance is
larger than is allowed.
"""

import shutil
import sys
from pathlib import Path

import box_run
import numpy as np
import saturne_run
from first_hits import CONDITIONS, REFERENCE, compare, direct_states, distances, print_rows

import sampler

#: Particles of each condition.
COUNT = 40_000
#: Of what a run is compared with.
OTHER_SEED = 99
STEP, STEPS = 5e-4, 40
#: Largest difference of a velocity from Python's draw [m/s].
DIFFERENCE = 1e-9
#: Axes whose walls are symmetry planes, so that all first hits are on floor or lid.
SIDES = (0, 2)


def drawn_states(table, count):
    """States of each condition that Python draws for particles without spin, (count, 6) each."""
    states = []
    for k, (alpha, speed) in enumerate(CONDITIONS):
        index = np.arange(count, dtype=np.uint64) * np.uint64(len(CONDITIONS))
        velocity = np.zeros((count, 3))
        velocity[:, 0] = 0.0 if k == len(CONDITIONS) - 1 else speed * np.cos(alpha)
        velocity[:, 1] = -speed * np.sin(alpha)
        none = np.zeros((count, 3))
        normal = np.tile([0.0, 1.0, 0.0], (count, 1))
        hits = box_run.Hits(index + np.uint64(k), 0, velocity, none, normal, velocity, none)
        after = box_run.rebound(table, hits, OTHER_SEED)
        states.append(box_run.states(hits._replace(new_velocity=after[0], new_omega=after[1])))
    return states


def _joined(parts):
    return box_run.Hits(*map(np.concatenate, zip(*parts, strict=True)))


def further_hits(table, started, time):
    """Hits after the first one, of a flight in Python with other random numbers."""
    seen = []
    box_run.replay(table, started, time, seed=OTHER_SEED, seen=seen, symmetry_axes=SIDES)
    return _further(_joined(seen))


def _further(hits):
    return box_run.Hits(*(column[hits.hit > 0] for column in hits))


def difference_from_python(table, hits, spin):
    """Largest difference of a velocity [m/s] from the draw of Python with the same keys."""
    # straight on, the direction along the wall is as the frame of the face has it
    rows = ~(box_run.is_normal(hits.index) & (hits.hit == 0))
    drawn, _ = box_run.rebound(table, hits if spin else hits._replace(omega=None))
    return float(np.abs(drawn - hits.new_velocity)[rows].max())


def _runs(work, count):
    """Name of each run, its folder, and the hits that it has to show."""
    folder = work / "wall"
    shutil.rmtree(folder, ignore_errors=True)
    given = {"step": STEP, "particles": count * len(CONDITIONS), "symmetry": len(SIDES)}
    serial = saturne_run.run(work, folder / "serial", STEPS, **given)
    yield "serial", serial, box_run.read_hits(serial)
    half = saturne_run.run(work, folder / "half", STEPS // 2, **given)
    again = saturne_run.run(work, folder / "again", STEPS, processors=2, restart=half, **given)
    yield "restart on two", half, _joined([box_run.read_hits(half), box_run.read_hits(again)])
    plain = saturne_run.run(
        work, folder / "plain", STEPS, text=saturne_run.settings(spin="no"), **given
    )
    yield "spin no", plain, box_run.read_hits(plain)


def main(work, count=COUNT):
    table = sampler.load("corundum-steel")
    drawn, direct = drawn_states(table, REFERENCE), direct_states(REFERENCE)
    good = True
    for name, folder, hits in _runs(work, count):
        difference = difference_from_python(table, hits, spin=name != "spin no")
        reference = direct if name == "spin no" else drawn
        rows = compare(box_run.states(hits), box_run.conditions(hits), reference)
        if name != "spin no":
            started = box_run.read_particles(folder, "start")
            further = further_hits(table, started, STEP * STEPS)
            states = box_run.states(_further(hits)), box_run.states(further)
            rows.append(distances("further hits", *states))
        good = good and all(row.holds for row in rows) and difference < DIFFERENCE
        print(f"{name}: largest difference from Python's draws {difference:.1e} m/s")
        print_rows(rows)
    return 0 if good else 1


if __name__ == "__main__":
    try:
        sys.exit(main(Path(sys.argv[1]).resolve(), *map(int, sys.argv[2:])))
    except saturne_run.SaturneError as error:
        sys.exit(str(error))
