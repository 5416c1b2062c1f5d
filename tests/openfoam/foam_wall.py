"""Shoot parcels at a wall in OpenFOAM, and compare their rebounds with direct simulation.

    PYTHONPATH=tests python tests/openfoam/foam_wall.py FOLDER [COUNT]

FOLDER is where install.sh and build.sh of sampler/openfoam worked, with corundum-steel.rbt; COUNT
the number of parcels of each condition at each of two walls. Prints a table, and ends with 1 if a
distance is larger than is allowed.

All impacts are first ones, whose law `spin no` takes; draws of both `spin no` and `spin yes` are
compared with those of Python for the same keys.
"""

import itertools
import sys
from pathlib import Path

import foam_run
import numpy as np
import shots
from first_hits import REFERENCE, compare, direct_states, print_rows

import sampler

CLOUD = "constant/kinematicCloudProperties"
SPIN_NO = (CLOUD, "outOfRange      clamp;", "outOfRange clamp; spin no;")
#: Largest difference from Python's draws [m/s]: six digits behind the point of a velocity of up to
#: 300 m/s, and rounding.
DIFFERENCE = 1e-6
#: Parcels of each condition at each wall.
COUNT = 20_000


def main(work, count=COUNT):
    """Run the kinematic and the colliding cloud on one and on two processors."""
    started = shots.make_shots(count)
    direct = direct_states(REFERENCE)
    table = sampler.load("corundum-steel")
    drawn = {"spin no": shots.first_rebound(table, started, with_spin=False)[0]}
    drawn["spin yes"], _ = shots.first_rebound(table, started)
    good = True
    for cloud, processors in itertools.product(("kinematic", "colliding"), (1, 2)):
        print(f"{cloud} cloud on {processors} processor{'s' * (processors > 1)}:")
        for kept, edits in (("spin yes", ()), ("spin no", (SPIN_NO,))):
            folder = work / "wall" / f"{cloud}-{processors}-{kept.replace(' ', '-')}"
            fields, _ = shots.run_shots(work, folder, started, cloud, processors, edits=edits)
            difference = float(np.abs(fields["U"] - drawn[kept]).max())
            print(f"  {kept}: largest difference from Python's draws {difference:.1e} m/s")
            good = good and difference < DIFFERENCE
        rows = compare(shots.states(started, fields), started.condition, direct)
        print_rows(rows)
        good = good and all(row.holds for row in rows)
    return 0 if good else 1


if __name__ == "__main__":
    try:
        sys.exit(main(Path(sys.argv[1]).resolve(), *map(int, sys.argv[2:])))
    except foam_run.FoamError as error:
        sys.exit(str(error))
