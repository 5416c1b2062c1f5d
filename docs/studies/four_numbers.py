"""Why a particle carries the inertia about its spin: equal spins, other axes, other rebounds.

    python docs/studies/four_numbers.py --figure docs/four_numbers.png

An ellipsoid with b/a = 0.95 and c/b = 0.6 meets a wall at 8 degrees and 50 m/s, with the spin of a
grain that rolls, -1 V/a about z. The inertia k about its spin says which of its axes it turns
about. The figure has three orientations of the grain about the same spin, and by k the energy of
translation that a hit keeps: of draws from a table, and of direct simulation.
"""

import argparse

import matplotlib.pyplot as plt
import numpy as np

import sampler
import tablegen

ANGLE, SPEED = np.radians(8.0), 50.0  # of the impact; m/s
SPIN = (0.0, 0.0, -1.0)  # a omega / V
RATIOS = (0.95, 0.6)  # b/a and c/b
POINTS = 9  # inertias


def moments():
    """Principal moments of inertia of the ellipsoid over m a^2, in rising order."""
    b, c = RATIOS[0], RATIOS[0] * RATIOS[1]
    return np.array([b * b + c * c, 1.0 + c * c, 1.0 + b * b]) / 5.0


def energy_kept(law, inertias, count, seed):
    """Mean translational energy after over that before, and its standard error, by inertia."""
    grain = np.array([0.0, *RATIOS])  # code of an ellipsoid, b/a, c/b
    means, errors = [], []
    for inertia in inertias:
        states = law.sample(
            ANGLE,
            SPEED,
            spin=SPIN,
            inertia=inertia,
            grain=grain,
            seed=seed,
            index=np.arange(count),
            hit=1,
        )
        kept = np.sum(states[:, :3] ** 2, axis=1)
        means.append(kept.mean())
        errors.append(kept.std() / np.sqrt(count))
    return np.array(means), np.array(errors)


def draw_grain(axes, upright, title):
    """Draw the grain seen along its spin, with half-sizes along x and y of the figure."""
    turn = np.linspace(0.0, 2.0 * np.pi, 200)
    axes.fill(upright[0] * np.cos(turn), upright[1] * np.sin(turn), color="0.75", ec="k")
    axes.annotate(
        "",
        (0.0, -1.25),
        (0.55, -1.12),
        arrowprops={"arrowstyle": "->", "connectionstyle": "arc3,rad=-0.3"},
    )
    axes.plot(0.0, 0.0, "k.")
    axes.set(xlim=(-1.4, 1.4), ylim=(-1.4, 1.4), aspect="equal", title=title)
    axes.axis("off")


def draw(figure, inertias, table, direct):
    """Draw the grain about its three axes, and the energy kept by inertia."""
    left, right = figure.subfigures(1, 2, width_ratios=(1.0, 1.3))
    a, b, c = 1.0, RATIOS[0], RATIOS[0] * RATIOS[1]
    rows = left.subplots(1, 3)
    for axes, sizes, axis, moment in zip(
        rows, ((b, c), (a, c), (a, b)), ("long", "middle", "short"), moments(), strict=True
    ):
        draw_grain(axes, sizes, f"{axis} axis\nk = {moment:.2f}")
    left.suptitle("the same spin, about the")
    axes = right.subplots()
    axes.plot(inertias, direct[0], "k-", label="direct simulation")
    axes.errorbar(inertias, table[0], 2.0 * table[1], fmt="o", label="table, two standard errors")
    axes.set(xlabel="inertia k about the spin, over m a²", ylabel="energy that the hit keeps")
    axes.legend()


def main(arguments=None):
    """Sample both laws at inertias between the moments of the grain; print and draw."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--table", default="corundum-steel", help="name, or path of a .h5 file")
    parser.add_argument("--count", type=int, default=40_000, help="rebounds at each inertia")
    parser.add_argument("--figure", help="picture to write")
    args = parser.parse_args(arguments)
    model = tablegen.DirectModel(tablegen.load_config("corundum-steel"))
    inertias = np.linspace(*moments()[[0, 2]], POINTS)
    try:
        drawn = energy_kept(sampler.load(args.table), inertias, args.count, 1)
    except (sampler.InputError, OSError) as error:  # for one, a table without ellipsoids
        parser.error(f"argument --table: {error}")
    direct = energy_kept(model, inertias, args.count, 2)
    print("| inertia k | table | direct | error of each |\n|---|---|---|---|")
    for inertia, table_value, direct_value, error in zip(inertias, drawn[0], *direct, strict=True):
        print(f"| {inertia:.3f} | {table_value:.4f} | {direct_value:.4f} | {error:.4f} |")
    if args.figure:
        figure = plt.figure(figsize=(10.0, 3.6), layout="constrained")
        draw(figure, inertias, drawn, direct)
        figure.savefig(args.figure, dpi=110)


if __name__ == "__main__":
    main()
