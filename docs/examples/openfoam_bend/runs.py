"""Runs of OpenFOAM: the gas once, then parcels with each model of the wall."""

import re
import shutil
from pathlib import Path
from typing import NamedTuple

import foam_files
import foam_run
import numpy as np

#: Models by the names that `many_hits` gives them: entries of the case, kinematicCloudProperties.
MODELS = {
    "spheres": {"wallModel": "standardWallInteraction", "keepsSpin": "no"},
    "table-without-spin": {"wallModel": "tabulatedRebound", "keepsSpin": "no"},
    "table": {"wallModel": "tabulatedRebound", "keepsSpin": "yes"},
}
SOLVER = "icoUncoupledKinematicParcelFoam"
GAS_FIELDS = ("U", "k", "epsilon", "nut")
_CLOUD = "constant/kinematicCloudProperties"
_AS_SHIPPED = {"wallModel": "tabulatedRebound", "keepsSpin": "yes"}

#: Parcels with y [m] above this are behind the bend.
BEHIND = 0.5


class Cost(NamedTuple):
    """Processor seconds of a run, and parcel-steps to which it comes."""

    seconds: float
    parcel_steps: int


def solve_gas(work: Path) -> Path:
    """Steady gas flow in the bend; the folder of its fields."""
    case = foam_run.copy_case("bend", work / "bend" / "gas", work)
    (case / "system" / "controlDict.gas").replace(case / "system" / "controlDict")
    foam_run.run(work, case, "blockMesh")
    foam_run.run(work, case, "simpleFoam")
    return max((p for p in case.iterdir() if p.name.isdigit()), key=lambda p: int(p.name))


def fly(work: Path, gas: Path, model: str) -> tuple[Path, str]:
    """Run parcels through the bend; the case, and what the solver printed."""
    case = foam_run.copy_case("bend", work / "bend" / model, work)
    foam_run.edit(case, "system/fvSchemes", "default steadyState", "default Euler")
    for name, shipped in _AS_SHIPPED.items():
        entry = f"{name:15s} "
        foam_run.edit(case, _CLOUD, f"{entry}{shipped};", f"{entry}{MODELS[model][name]};")
    for name in GAS_FIELDS:
        shutil.copyfile(gas / name, case / "0" / name)
    foam_run.run(work, case, "blockMesh")
    return case, foam_run.run(work, case, SOLVER)


def cost(log: str) -> Cost:
    """What a run cost, from what the solver printed."""
    parcels = [int(n) for n in re.findall(r"Current number of parcels\s+= (\d+)", log)]
    return Cost(float(re.findall(r"ExecutionTime = ([\d.]+) s", log)[-1]), sum(parcels))


def counts(log: str) -> dict[str, int]:
    """Totals that the wall model printed; none of OpenFOAM's own."""
    found = re.findall(r"spin lost\) = (\d+), (\d+), (\d+), (\d+)", log)
    names = ("hits", "clamped", "extrapolated", "spin_lost")
    return dict(zip(names, map(int, found[-1]), strict=True)) if found else {}


def behind(case: Path, times: tuple[str, ...]) -> dict[str, float]:
    """Velocities of the parcels behind the bend, of the snapshots at `times`."""
    position, velocity = (
        np.vstack([read(case, time) for time in times])
        for read in (foam_files.read_positions, foam_files.read_velocities)
    )
    u, v, w = velocity[position[:, 1] > BEHIND].T
    return {
        "parcels_behind": len(v),
        "mean_speed_along": float(v.mean()),
        "spread_across": float(u.std()),
        "spread_spanwise": float(w.std()),
    }
