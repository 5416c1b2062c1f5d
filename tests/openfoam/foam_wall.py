"""Shoot parcels at a wall in OpenFOAM, and compare their rebounds with direct simulation.

    PYTHONPATH=tests python tests/openfoam/foam_wall.py FOLDER [COUNT]

FOLDER is where install.sh and build.sh of sampler/openfoam worked, with corundum-steel.rbt; COUNT
the number of parcels of each condition at each of two walls. Prints a table, and ends with 1 if a
distance is larger than is allowed.

All impacts are first ones, of particles that do not spin. Draws are compared with those of Python
for the same keys, too.
"""

import itertools
import sys
from pathlib import Path

import foam_run
import numpy as np
import shots
from first_hits import REFERENCE, compare, direct_states, print_rows

import sampler

#: Largest difference from Python's draws [m/s]: six digits behind the point of a velocity of up to
#: 300 m/s, and rounding.
DIFFERENCE = 1e-6
#: Parcels of each condition at each wall.
COUNT = 20_000


def main(work, count=COUNT):
    """Run the kinematic and the colliding cloud on one and on two processors."""
    started = shots.make_shots(count)
    direct = direct_states(REFERENCE)
    drawn, *_ = shots.first_rebound(sampler.load("corundum-steel"), started)
    good = True
    for cloud, processors in itertools.product(("kinematic", "colliding"), (1, 2)):
        print(f"{cloud} cloud on {processors} processor{'s' * (processors > 1)}:")
        folder = work / "wall" / f"{cloud}-{processors}"
        fields, _ = shots.run_shots(work, folder, started, cloud, processors)
        difference = float(np.abs(fields["U"] - drawn).max())
        print(f"  largest difference from Python's draws {difference:.1e} m/s")
        rows = compare(shots.states(started, fields), started.condition, direct)
        print_rows(rows)
        good = good and difference < DIFFERENCE and all(row.holds for row in rows)
    return 0 if good else 1


if __name__ == "__main__":
    try:
        sys.exit(main(Path(sys.argv[1]).resolve(), *map(int, sys.argv[2:])))
    except foam_run.FoamError as error:
        sys.exit(str(error))
