"""Wear of `docs/examples/bend.py` along its outer wall: laws of erosion, and the works of a table.

    python docs/studies/wear.py --figure docs/bend_wear.png

Oka (Wear 259 (2005) 95) and Finnie (Wear 3 (1960) 87) know speed and angle of an impact. The works
are what the wall takes, at every hit, from particles that spin; by Bitter (Wear 6 (1963) 5) each
removes a volume in proportion. The constants are the user's: those here, for sand on steel, were
not checked against these papers.
"""

import argparse
import math
import sys
import warnings
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import sampler

sys.path.append(str(Path(__file__).resolve().parents[1] / "examples"))
import bend

HARDNESS, E90 = 1.8, 6.154e-4 / 7850.0  # Oka: GPa; m^3 of wall for a kg of sand at 104 m/s, 90 deg
N1, N2, K2, K3, FAST, LARGE = 0.8, 1.3, 2.35, 0.19, 104.0, 326e-6  # exponents; m/s, m
FLOW_STRESS, PSI, K = 1.5e9, 2.0, 2.0  # Finnie: Pa, and two ratios of depths and of forces
DEFORMATION, CUTTING = 2e10, 2e10  # Bitter: J of normal and of tangential work for a m^3 of wall


def oka(speed, angle, diameter):
    """Volume of wall for each kg of particles, m^3/kg."""
    sine = np.sin(angle)
    share = sine**N1 * (1.0 + HARDNESS * (1.0 - sine)) ** N2
    return E90 * share * (speed / FAST) ** K2 * (diameter / LARGE) ** K3


def finnie(speed, angle):
    """Volume of wall for each kg of particles, m^3/kg."""
    sine = np.sin(angle)
    shallow = np.sin(2.0 * angle) - 6.0 / K * sine**2
    share = np.where(np.tan(angle) < K / 6.0, shallow, K * np.cos(angle) ** 2 / 6.0)
    return speed**2 / (PSI * K * FLOW_STRESS) * share


def with_works(table, works):
    """Make a law for `bend.follow`; it adds works on the outer wall, (n, 2) J/kg, to a list."""

    def rebound(velocity, normal, half_size, **spins_and_keys):
        taken = np.empty((len(velocity), 2))
        after = table.rebound(velocity, normal, half_size, works=taken, **spins_and_keys)
        works.append(taken[normal.sum(axis=1) < 0.0])
        return after

    return rebound


def by_face(impacts, amounts, particles, edges):
    """Sum amounts (n,) of impacts by face of the wall: a particle's share, and standard errors."""
    bins = (np.arange(bend.GROUPS + 1) - 0.5, edges)
    sums = np.histogram2d(impacts.group, impacts.place, bins, weights=amounts)[0]
    sums *= bend.GROUPS / particles
    return np.array([sums.mean(axis=0), sums.std(axis=0, ddof=1) / np.sqrt(bend.GROUPS)])


def print_faces(faces, edges):
    """Print sums and standard errors by face."""
    print("\n| face, m | " + " | ".join(faces) + " |\n" + "|---" * (1 + len(faces)) + "|")
    for k in range(len(edges) - 1):
        cells = (f"{values[k]:.3g} ± {errors[k]:.1g}" for values, errors in faces.values())
        print(f"| {edges[k]:.3f} to {edges[k + 1]:.3f} | " + " | ".join(cells) + " |")


def draw(figure, panels, edges):
    """Draw values and standard errors by panel and name; grey is the bend."""
    middles = 0.5 * (edges[1:] + edges[:-1])
    for axes, (title, lines) in zip(figure.subplots(1, 2), panels.items(), strict=True):
        axes.axvspan(0.0, bend.TURN, color="#eeeeee", linewidth=0)
        for name, (values, errors) in lines.items():
            axes.errorbar(middles, values, errors, label=name, marker="o", markersize=3)
        axes.set(ylim=(0.0, None), xlim=edges[[0, -1]], title=title, xlabel="along the duct [m]")
        axes.legend()


def main(arguments=None):
    """Follow particles through the bend; print and draw what its outer wall loses."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--table", default="corundum-steel-wear", help="a table with works")
    parser.add_argument("--diameter", type=float, default=30e-6, help="of the particles, m")
    parser.add_argument("--count", type=int, default=20_000, help="number of particles")
    parser.add_argument("--figure", help="picture to write")
    args = parser.parse_args(arguments)
    if args.count < bend.GROUPS or not 0.0 < args.diameter < math.inf:
        parser.error(f"give --count {bend.GROUPS} or more, and a --diameter above 0")
    try:
        table = sampler.load(args.table)
    except sampler.InputError as error:
        parser.error(str(error))
    if not table.has_spin or not {"work_normal", "work_shear"} <= set(table.columns):
        parser.error("argument --table: it needs works and a spin law, as corundum-steel-wear has")
    warnings.simplefilter("ignore", sampler.OutsideTableWarning)
    works, half_size = [], table.mean_half_size(args.diameter)
    law = with_works(table, works)
    impacts = bend.follow(law, half_size, (bend.SPEED, args.diameter), args.count, seed=1)
    normal, shear = np.concatenate(works).T
    taken = {"normal work, kJ/kg": 1e-3 * normal, "tangential work, kJ/kg": 1e-3 * shear}
    wear = {
        "Oka, mm³/kg": 1e9 * oka(impacts.speed, impacts.angle, args.diameter),
        "Finnie, mm³/kg": 1e9 * finnie(impacts.speed, impacts.angle),
        "works (Bitter), mm³/kg": 1e9 * (normal / DEFORMATION + shear / CUTTING),
    }
    print("| of the whole wall | sum | at later hits |\n|---|---|---|")
    for name, amounts in (taken | wear).items():
        later = amounts[impacts.hit > 0].sum() / amounts.sum()
        print(f"| {name} | {amounts.sum() / args.count:.4g} | {later:.0%} |")
    edges = bend.TURN / 12 * np.arange(23)
    faces = {n: by_face(impacts, x, args.count, edges) for n, x in (taken | wear).items()}
    print_faces(faces, edges)
    if args.figure:
        metres = {name: face / np.diff(edges) for name, face in faces.items()}
        shares = {n.split(",")[0]: metres[n] * args.count / x.sum() for n, x in wear.items()}
        panels = {"works, per metre": {name: metres[name] for name in taken}}
        panels["loss of wall over its sum, per metre"] = shares
        figure = plt.figure(figsize=(10.0, 4.0), layout="constrained")
        draw(figure, panels, edges)
        figure.savefig(args.figure, dpi=110)


if __name__ == "__main__":
    main()
