"""Does the law of the wall matter? One dusty flow, nine laws.

    python docs/studies/wall_laws.py --output docs

Air of 120 m/s carries corundum grains of 30 to 100 um past three staggered columns of cylinders of
10 mm, 20 mm apart along and across the stream (`cylinders.py`). Under every law a grain has the
same drag and torque, and stays on a cylinder if its next hop would be lower than a hundredth of its
diameter. Sizes, edges of classes, are diameters of spheres of equal volume.
"""

import argparse
import itertools
import math
import warnings
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from cylinders import AHEAD, CELL, COLUMNS, ENERGY, PITCH, RADIUS, SPEED, figures_of, follow_each
from matplotlib.colors import LogNorm
from scipy.interpolate import RegularGridInterpolator

import sampler
import tablegen

#: Means of e_n and e_t, polynomials in the angle [rad]: J. Aircraft 12 (1975) 471; Wear 216 (1998)
#: 184. OpenFOAM's standard wall has e and mu: the share of the tangential velocity that is lost.
MEANS = {
    "Grant & Tabakoff": ([0.993, -1.76, 1.56, -0.49], [0.988, -1.66, 2.11, -0.67]),
    "Forder": ([0.988, -0.78, 0.19, -0.024, 0.027], [1.0, -0.78, 0.84, -0.21, 0.028, -0.022]),
    "e = 0.3, μ = 0.3": ([0.3], [0.7]),
}
#: Name of each law: colour, marker and line of its curve.
PLOT_STYLES = {
    "direct simulation": ("#000000", "o", "-"),
    "table": ("#e08a00", "s", "--"),
    "compact table": ("#c44e00", "D", ":"),
    "table without spin": ("#0072b2", "^", "--"),
    "Grant & Tabakoff": ("#009e73", "v", "-."),
    "Forder": ("#56b4e9", ">", "-."),
    "e = 0.3, μ = 0.3": ("#cc79a7", "<", "-."),
    "sphere": ("#777777", "x", "-."),
    "means of the table": ("#d62728", "P", "-."),
}


def grains_of(model, diameter, seed, index, **_):
    """Grains that a table or direct model keeps, and their largest half-sizes."""
    grain = model.grains(seed, index)
    return grain, sampler.half_size(model, diameter, grain)


def direct_law(model):
    """Make a law of the wall by direct simulation.

    A law is a function of arrays of hits. It takes and returns velocities, spins, and the moment of
    inertia about each spin over the mass, m^2, which is k a^2; keys are seed, index and hit.
    """

    def law(velocity, normal, diameter, omega, moment, **keys):
        _, half = grains_of(model, diameter, **keys)
        spin = {"omega": omega, "inertia": moment / half**2}
        velocity, omega, inertia = model.rebound(velocity, normal, half, **spin, **keys)
        return velocity, omega, inertia * half**2

    return law


def table_law(table, spins=True):
    """Make a law of draws from a table; without ``spins`` every grain arrives at rest."""

    def law(velocity, normal, diameter, omega, moment, **keys):
        _, half = grains_of(table, diameter, **keys)
        spin = {"omega": omega, "inertia": moment / half**2} if spins else {}
        velocity, omega, inertia = table.rebound(velocity, normal, half, **spin, **keys)
        return velocity, omega, inertia * half**2

    return law


def mean_law(e_n, e_t):
    """Make a law of means, polynomials in the angle; spins stay as they are."""

    def law(velocity, normal, diameter, omega, moment, **keys):
        into = -(velocity * normal).sum(axis=1)[:, None]
        angle = np.arcsin(np.minimum(into / np.linalg.norm(velocity, axis=1)[:, None], 1.0))
        n, t = (np.clip(np.polynomial.Polynomial(c)(angle), 0.0, 1.0) for c in (e_n, e_t))
        return t * (velocity + into * normal) + n * into * normal, omega, moment

    return law


def table_mean_law(table):
    """Make a law of the means of a table at first impacts, without scatter; spins stay.

    It is the control of the laws of means: these grains and this wall, but no scatter.
    """
    (low, high), speeds = np.radians(table.covered.alpha_deg), table.speed_nodes
    angles = np.linspace(low, high, 180)
    means = table.mean(*np.meshgrid(angles, speeds, indexing="ij"))[..., :2]  # u and v over V
    at = RegularGridInterpolator((angles, np.log(speeds)), means)

    def law(velocity, normal, diameter, omega, moment, **keys):
        into = -(velocity * normal).sum(axis=1)[:, None]
        along = velocity + into * normal
        speed = np.linalg.norm(velocity, axis=1)
        sliding = np.linalg.norm(along, axis=1)
        alpha = np.clip(np.arctan2(into[:, 0], sliding), low, high)
        u, v = at((alpha, np.log(np.clip(speed, speeds[0], speeds[-1])))).T * speed
        tangent = along / np.maximum(sliding, 1e-30)[:, None]
        return u[:, None] * tangent + v[:, None] * normal, omega, moment

    return law


def model_laws(table, config):
    """Return laws by name: direct simulation, the table, the table without spin, spheres."""
    spheres = tablegen.DirectModel(config, config.population.restricted_to("sphere"))
    laws = direct_law(tablegen.DirectModel(config)), table_law(table), table_law(table, spins=False)
    names = ("direct simulation", "table", "table without spin", "sphere")
    return dict(zip(names, (*laws, direct_law(spheres)), strict=True))


def print_results(results, low, high):
    """Print the table of results, and the largest difference from those of the first law."""
    rows = {name: figures_of(result, low, high) for name, result in results.items()}
    direct = next(iter(rows.values()))
    print(f"\n| {1e6 * low:.0f} to {1e6 * high:.0f} µm | " + " | ".join(direct), end="")
    print(" | most errors off |\n" + "|---" * 7 + "|")
    for name, row in rows.items():
        cells = " | ".join(f"{x:.4g} ± {error:.2g}" for x, error in row.values())
        print(f"| {name} | {cells} | {errors_off(row, direct):.1f} |")


def errors_off(row, direct):
    """Compute the largest difference of two rows of figures, in its standard errors."""
    pairs = zip(row.values(), direct.values(), strict=True)
    return max(abs(x - y) / (math.hypot(e, d) or math.inf) for (x, e), (y, d) in pairs)


def draw_map(axes, field):
    """Draw the density of bounced grains over that of the stream; return the image."""
    end, look = 1e3 * COLUMNS * PITCH, {"cmap": "cividis", "origin": "lower"}
    extent = 1e3 * AHEAD, end, 0.0, 2e3 * PITCH
    image = axes.imshow(np.tile(field, (2, 1)), extent=extent, norm=LogNorm(0.3, 20.0), **look)
    for column, row in itertools.product(range(COLUMNS), range(4)):
        axis = 1e3 * PITCH * column, 1e3 * PITCH * (row - 0.5 * (column % 2))
        axes.add_patch(plt.Circle(axis, 1e3 * RADIUS, color="white"))
    axes.set(xlabel="mm", xlim=extent[:2], ylim=extent[2:])
    return image


def draw_results(results, count, sizes):
    """Draw where bounced grains go under four laws, and who is thrown back, by size."""
    maps = ["direct simulation", "table", "Grant & Tabakoff", "sphere"]
    rows = [maps, ["thrown back"] * 2 + [ENERGY] * 2]
    look = {"figsize": (11.0, 6.2), "layout": "constrained", "height_ratios": (1.0, 2.0)}
    figure, panels = plt.subplot_mosaic(rows, **look)
    edges, flux = np.linspace(sizes[0], sizes[-1], 8), count * CELL**2 / (SPEED * PITCH)
    for name in maps:
        image = draw_map(panels[name], np.maximum(results[name].field / flux, 0.3))
        panels[name].set_title(name)
    figure.colorbar(image, ax=[panels[name] for name in maps], label="bounced / stream")
    for column in rows[1][::2]:
        axes = panels[column]
        axes.set(title=column, xlabel="diameter, µm")
        for name, result in results.items():
            figures = [figures_of(result, *pair)[column] for pair in itertools.pairwise(edges)]
            shape = dict(zip(("color", "marker", "linestyle"), PLOT_STYLES[name], strict=True))
            axes.errorbar(
                0.5e6 * (edges[1:] + edges[:-1]), *np.transpose(figures), label=name, **shape
            )
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure


def draw_hits(results, count):
    """Draw histograms of the angles and speeds of hits by column of cylinders."""
    figure, panels = plt.subplots(2, COLUMNS, figsize=(11.0, 6.0), layout="constrained")
    for (name, result), k in itertools.product(results.items(), range(COLUMNS)):
        look = {"color": PLOT_STYLES[name][0], "linestyle": PLOT_STYLES[name][2], "label": name}
        rows = ("angle, degrees", result.angle, 90.0), ("speed, m/s", result.speed, 140.0)
        for axes, (title, values, most) in zip(panels[:, k], rows, strict=True):
            edges = np.linspace(0.0, most, 19)
            axes.stairs(np.histogram(values[result.column == k], edges)[0] / count, edges, **look)
            axes.set(xlabel=title, title=f"column {k + 1}: hits a grain")
    handles = panels[0, 0].get_legend_handles_labels()
    figure.legend(*handles, loc="outside lower center", ncols=4)
    return figure


def main(arguments=None):
    """Follow the grains under each law; print and draw where they go."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--table", default="corundum-steel", help="name, or path of a .h5 file")
    parser.add_argument("--grains", type=int, default=20_000, help="grains under each law")
    parser.add_argument(
        "--sizes",
        type=float,
        nargs="+",
        default=[30, 50, 70, 100],
        metavar="UM",
        help="limits of the classes of diameters, micrometres",
    )
    parser.add_argument("--seed", type=int, default=1, help="seed of the random numbers")
    parser.add_argument("--output", type=Path, help="folder to write two pictures to")
    args = parser.parse_args(arguments)
    if args.grains < 1 or args.seed < 0:
        parser.error("give --grains 1 or more, and --seed 0 or more")
    if len(args.sizes) < 2 or sorted(set(args.sizes)) != args.sizes or not args.sizes[0] > 0.0:
        parser.error("argument --sizes: give two or more increasing diameters")
    try:
        table = sampler.load(args.table)
    except sampler.InputError as error:
        parser.error(str(error))
    warnings.simplefilter("ignore", sampler.OutsideTableWarning)  # slow hits are near its end
    config = tablegen.parse_config(table.config, "--table")
    laws = model_laws(table, config)
    laws["compact table"] = table_law(sampler.load("corundum-steel-compact"))
    laws["means of the table"] = table_mean_law(table)
    laws |= {name: mean_law(*polynomials) for name, polynomials in MEANS.items()}
    sizes = 1e-6 * np.array(args.sizes)
    laws = {name: laws[name] for name in PLOT_STYLES}
    results = follow_each(laws, table, args.grains, sizes[[0, -1]], args.seed)
    # all sizes, and then each class, unless there is only one
    for low, high in dict.fromkeys([(sizes[0], sizes[-1]), *itertools.pairwise(sizes)]):
        print_results(results, low, high)
    if args.output:
        draw_results(results, args.grains, sizes).savefig(args.output / "wall_laws.png", dpi=110)
        draw_hits(results, args.grains).savefig(args.output / "wall_laws_hits.png", dpi=110)


if __name__ == "__main__":
    main()
