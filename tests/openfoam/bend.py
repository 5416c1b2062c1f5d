"""Sand in a bend of a duct, with OpenFOAM's standardWallInteraction and with tabulatedRebound.

    python tests/openfoam/bend.py FOLDER [ROUNDS]

FOLDER is where install.sh and build.sh of sampler/openfoam worked, with corundum-steel.rbt. Runs
each wall model ROUNDS times in turn, prints what it costs and how the parcels differ, and leaves
bend.json and bend.png in FOLDER.
"""

import json
import re
import shutil
import sys
from pathlib import Path

import foam_files
import foam_run
import numpy as np
from bend_picture import BEHIND, draw_picture

from sampler.files.atomic import atomic_output

MODELS = ("standardWallInteraction", "tabulatedRebound")
SOLVER = "icoUncoupledKinematicParcelFoam"
GAS_FIELDS = ("U", "k", "epsilon", "nut")
#: Times [s] at which the duct is full; parcels of all of them are counted together.
TIMES = tuple(f"{0.001 * k:g}" for k in range(12, 21))


def solve_gas(work):
    """Steady gas flow in the bend; returns the folder of its fields."""
    case = foam_run.copy_case("bend", work / "bend" / "gas", work)
    (case / "system" / "controlDict.gas").replace(case / "system" / "controlDict")
    foam_run.run(work, case, "blockMesh")
    foam_run.run(work, case, "simpleFoam")
    return max((p for p in case.iterdir() if p.name.isdigit()), key=lambda p: int(p.name))


def fly(work, gas, model):
    """Run parcels through the bend; returns the case and what the solver printed."""
    case = foam_run.copy_case("bend", work / "bend" / model, work)
    foam_run.edit(case, "system/fvSchemes", "default steadyState", "default Euler")
    foam_run.edit(
        case, "constant/kinematicCloudProperties", "wallModel       tabulatedRebound",
        f"wallModel       {model}",
    )  # fmt: skip
    for name in GAS_FIELDS:
        shutil.copyfile(gas / name, case / "0" / name)
    foam_run.run(work, case, "blockMesh")
    return case, foam_run.run(work, case, SOLVER)


def _last(pattern, log):
    return re.findall(pattern, log)[-1]


def cost(log):
    """What a run cost: processor seconds, and parcel-steps to which that comes."""
    parcels = [int(n) for n in re.findall(r"Current number of parcels\s+= (\d+)", log)]
    return float(_last(r"ExecutionTime = ([\d.]+) s", log)), sum(parcels)


def snapshot(case):
    """Positions [m] and velocities [m/s] of the parcels at all of `TIMES`."""
    return tuple(
        np.vstack([read(case, time) for time in TIMES])
        for read in (foam_files.read_positions, foam_files.read_velocities)
    )


def summary(position, velocity):
    """Numbers in which the models differ, of the parcels behind the bend."""
    behind = position[:, 1] > BEHIND
    u, v, w = velocity[behind].T
    return {
        "parcels": len(position),
        "parcels_behind": int(behind.sum()),
        "mean_speed_along": float(v.mean()),
        "spread_along": float(v.std()),
        "spread_across": float(u.std()),
        "spread_spanwise": float(w.std()),
        "share_slower_than_50": float((v < 50.0).mean()),
    }


def main(work, rounds=3):
    """Run both models, compare them and draw the picture."""
    gas = solve_gas(work)
    seconds = {model: [] for model in MODELS}
    results, snapshots = {}, {}
    for _ in range(rounds):
        for model in MODELS:
            case, log = fly(work, gas, model)
            spent, steps = cost(log)
            seconds[model].append(spent)
            position, velocity = snapshots[model] = snapshot(case)
            results[model] = {"parcel_steps": steps, **summary(position, velocity)}
    counts = map(int, _last(r"spin lost\) = (\d+), (\d+), (\d+), (\d+)", log))
    names = ("hits", "clamped", "extrapolated", "spin_lost")
    results["tabulatedRebound"] |= dict(zip(names, counts, strict=True))
    for model in MODELS:
        best = min(seconds[model])
        results[model]["seconds"] = seconds[model]
        results[model]["nanoseconds_per_parcel_step"] = 1e9 * best / results[model]["parcel_steps"]
        print(model)
        for name, value in results[model].items():
            print(f"  {name:28s} {value if not isinstance(value, float) else f'{value:.4g}'}")
    with atomic_output(work / "bend.json") as temporary:
        Path(temporary).write_text(json.dumps(results, indent=1), encoding="utf-8")
    draw_picture(snapshots, work / "bend.png")
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main(Path(sys.argv[1]).resolve(), *map(int, sys.argv[2:])))
    except foam_run.FoamError as error:
        sys.exit(str(error))
