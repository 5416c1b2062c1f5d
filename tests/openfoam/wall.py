"""Shoot parcels at a wall in OpenFOAM, and compare their rebounds with direct simulation.

    PYTHONPATH=tests python tests/openfoam/wall.py FOLDER [COUNT]

FOLDER is where install.sh and build.sh of sampler/openfoam worked, with corundum-steel.rbt; COUNT
the number of parcels of each condition at each of two walls. Prints a table, leaves wall.json in
FOLDER, and ends with 1 if a distance is larger than is allowed.

All impacts are first ones, whose law `spin no` takes; draws of both `spin no` and `spin yes` are
compared with those of Python for the same keys.
"""

import itertools
import json
import sys
from pathlib import Path

import foam_run
import numpy as np
import shots

import sampler
from tablegen import load_config, simulate
from tablegen.accuracy.metrics import correlation_error, ks_distances

#: Allowed Kolmogorov-Smirnov distance of any component and error of any correlation.
KS, CORRELATION = 0.02, 0.03
CLOUD = "constant/kinematicCloudProperties"
SPIN_NO = (CLOUD, "outOfRange      clamp;", "outOfRange clamp; spin no;")
#: Largest difference from Python's draws [m/s]: six digits behind the point of a velocity of up to
#: 300 m/s, and rounding.
DIFFERENCE = 1e-6
#: Parcels of each condition at each wall, and directly simulated ones of each condition. With
#: 40,000 against 200,000 a distance above 0.0122 is noise less than once in 10,000 components.
COUNT, DIRECT = 20_000, 200_000


def direct_states(count, seed=11):
    """States of each of `shots.CONDITIONS` from direct simulation, (count, 6) each."""
    config = load_config("corundum-steel")
    return [
        simulate(config, *condition, count, seed=seed, stream=k).state
        for k, condition in enumerate(shots.CONDITIONS)
    ]


def compare(started, states, direct):
    """Distances of OpenFOAM's states from direct simulation, a dictionary a condition."""
    rows = []
    for k, (alpha, speed) in enumerate(shots.CONDITIONS):
        sample = states[started.condition == k]
        reference = direct[k][:, : sample.shape[1]]
        rows.append(
            {
                "alpha_deg": float(np.degrees(alpha)),
                "speed": float(speed),
                "hits": len(sample),
                "ks": ks_distances(sample, reference).tolist(),
                "correlation_error": correlation_error(sample, reference),
            }
        )
    return rows


def passes(rows):
    """Whether every condition is within what is allowed."""
    return all(max(row["ks"]) <= KS and row["correlation_error"] <= CORRELATION for row in rows)


def _print_table(rows):
    print("  angle  speed    hits      KS  error of a correlation")
    for row in rows:
        print(
            f"  {row['alpha_deg']:4.0f}°  {row['speed']:5.0f}  {row['hits']:6d}  "
            f"{max(row['ks']):.4f}  {row['correlation_error']:.4f}"
        )


def main(work, count=COUNT):
    """Run the kinematic and the colliding cloud on one and on two processors."""
    started = shots.make_shots(count)
    direct = direct_states(DIRECT)
    table = sampler.load("corundum-steel")
    drawn = {"spin no": shots.first_rebound(table, started, with_spin=False)[0]}
    drawn["spin yes"], _ = shots.first_rebound(table, started)
    results = {}
    for cloud, processors in itertools.product(("kinematic", "colliding"), (1, 2)):
        name = f"{cloud}-{processors}"
        differences = {}
        for kept, edits in (("spin yes", ()), ("spin no", (SPIN_NO,))):
            folder = work / "wall" / f"{name}-{kept.replace(' ', '-')}"
            fields, _ = shots.run_shots(work, folder, started, cloud, processors, edits=edits)
            differences[kept] = float(np.abs(fields["U"] - drawn[kept]).max())
        rows = compare(started, shots.states(started, fields), direct)
        results[name] = {"conditions": rows, "difference_from_python": differences}
        print(f"{cloud} cloud on {processors} processor{'s' * (processors > 1)}:")
        _print_table(rows)
        for kept, difference in differences.items():
            print(f"  {kept}: largest difference from Python's draws {difference:.1e} m/s")
    (work / "wall.json").write_text(json.dumps(results, indent=1), encoding="utf-8")
    return 0 if all(map(_holds, results.values())) else 1


def _holds(result):
    """Whether one cloud's law is that of direct simulation, and its draws are Python's."""
    nearly = max(result["difference_from_python"].values()) < DIFFERENCE
    return nearly and passes(result["conditions"])


if __name__ == "__main__":
    try:
        sys.exit(main(Path(sys.argv[1]).resolve(), *map(int, sys.argv[2:])))
    except foam_run.FoamError as error:
        sys.exit(str(error))
