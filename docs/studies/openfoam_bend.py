"""Impacts on the walls of a bend in OpenFOAM, with three models of the wall.

    sampler/openfoam/bend.sh FOLDER
    python docs/studies/openfoam_bend.py FOLDER --figure docs/openfoam_bend.png

The first runs `sampler/openfoam/cases/bend` with OpenFOAM's own wall model for spheres, and with
the table without and with the spin of each parcel; the second reads the impacts that OpenFOAM wrote
to FOLDER/bend. `docs/examples/bend.py` is the same bend in Python, plane, in a gas that is known by
formula.
"""

import argparse
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import LogNorm

sys.path.append(str(Path(__file__).resolve().parents[1] / "examples"))
from bend import GROUPS, INNER, OUTER, SPEED, TURN, Impacts, by_place, draw_wall, print_wall

MODELS, WALLS = ("sphere", "table without spin", "table"), ("outer", "inner", "sides")
CENTRE = 0.2  # the bend turns about (0, CENTRE), from x to y, m
FACES = 20  # of the mesh along the bend
BEGIN, END = 0.008, 0.014  # times of counted impacts, when the duct is full, s
PARCELS = round(3e6 * (END - BEGIN))  # injected meanwhile


def places(x, y):
    """Places along the middle line, from the start of the bend, m."""
    turned = np.arctan2(np.maximum(x, 0.0), np.maximum(CENTRE - y, 0.0))
    return np.minimum(x, 0.0) + TURN * turned / (0.5 * np.pi) + np.maximum(y - CENTRE, 0.0)


def outward(wall, place, depth):
    """Normals of the mesh from the gas into walls (index into `WALLS`), (n, 3)."""
    face = (np.floor(np.clip(place / TURN, 0.0, 1.0 - 1e-12) * FACES) + 0.5) / FACES
    turned = 0.5 * np.pi * np.where(place > TURN, 1.0, np.where(place < 0.0, 0.0, face))
    sign = np.array([1.0, -1.0, 0.0])[wall]
    side = np.where(depth > 0.5 * (OUTER - INNER), 1.0, -1.0)
    return np.stack(
        (sign * np.sin(turned), -sign * np.cos(turned), np.where(wall == 2, side, 0)), 1
    )


def read_impacts(case):
    """Read the impacts of a run, in the order of time.

    Returns
    -------
    Impacts
        On all walls; without contacts of parcels that already leave the wall.
    time, depth, wall : arrays, shape (n,)
        s, distance from one side wall in m, index into `WALLS`.
    """
    rows = []
    for number, wall in enumerate(WALLS):
        for path in case.glob(f"postProcessing/lagrangian/kinematicCloud/impacts/*/{wall}.post"):
            text = path.read_text(encoding="ascii").partition("\n")[2]
            values = np.array(text.translate(str.maketrans("()", "  ")).split(), float)
            values = values.reshape(-1, 9)  # time, processor, position, origId, velocity
            rows.append(np.column_stack((values, np.full(len(values), number))))
    rows = np.vstack(rows)
    rows = rows[np.argsort(rows[:, 0], kind="stable")]
    x, y, depth, wall = *rows[:, 2:5].T, rows[:, 9].astype(int)
    speed = np.linalg.norm(rows[:, 6:9], axis=1)
    into = (rows[:, 6:9] * outward(wall, places(x, y), depth)).sum(axis=1)
    met = into > 0.0
    parcel = rows[met, 5].astype(int)
    order = np.argsort(parcel, kind="stable")
    hit = np.empty_like(parcel)
    hit[order] = np.arange(len(parcel)) - np.searchsorted(parcel[order], parcel[order])
    angle = np.arcsin(np.minimum(into / speed, 1.0))
    impacts = Impacts(parcel % GROUPS, hit, places(x, y)[met], speed[met], angle[met])
    return impacts, rows[met, 0], depth[met], wall[met]


def main(arguments=None):
    """Print what hits each wall, and draw the outer one."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", type=Path, help="working folder of sampler/openfoam/bend.sh")
    parser.add_argument("--figure", help="picture to write")
    args = parser.parse_args(arguments)
    if not args.folder.is_dir():
        parser.error(f"argument folder: there is no folder {args.folder}")
    edges = TURN / 12 * np.arange(23)
    across, outer = (np.linspace(-0.05, 0.45, 101), np.linspace(0.0, OUTER - INNER, 21)), {}
    runs = {model: read_impacts(args.folder / "bend" / model.replace(" ", "-")) for model in MODELS}
    figure = plt.figure(figsize=(13.0, 9.5), layout="constrained")
    above, below = figure.subfigures(2, 1, height_ratios=(1.0, 2.4))
    maps = above.subplots(1, len(MODELS), sharey=True)
    for number, wall in enumerate(WALLS):
        whole = {}
        for axes, (model, (impacts, time, depth, on)) in zip(maps, runs.items(), strict=True):
            counted = (on == number) & (time > BEGIN) & (time <= END)
            here = Impacts(*(column[counted] for column in impacts))
            whole[model] = by_place(here, PARCELS, edges[[0, -1]], SPEED)
            if wall == "outer":
                outer[model] = by_place(here, PARCELS, edges, SPEED)
                counts = np.histogram2d(here.place, depth[counted], bins=across)[0]
                shown = counts / PARCELS / np.outer(*map(np.diff, across))
                image = axes.pcolormesh(*across, shown.T, norm=LogNorm(1.0, 1000.0))
                axes.set(title=model, xlabel="place along the duct [m]")
        print(f"\n## Wall: {wall}\n")
        print_wall(whole)
    maps[0].set_ylabel("across the duct [m]")
    above.colorbar(image, ax=list(maps), label="impacts a parcel\nand square metre")
    draw_wall(below, outer, edges)
    if args.figure:
        figure.savefig(args.figure, dpi=110)


if __name__ == "__main__":
    main()
