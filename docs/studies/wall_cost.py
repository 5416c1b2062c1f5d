"""What do walls cost, and how far off are they? The flow of `wall_laws.py`, timed.

    python docs/studies/wall_cost.py --figure docs/wall_cost.png

Flights are compiled by numba. Draws are calls of the C library: one for all grains that have met a
wall, or one for each, from a loop in numba, as from a tracker in C.
"""

import argparse
import warnings

import matplotlib.pyplot as plt
import numba
import numpy as np
from cylinders import figures_of, follow_each
from wall_laws import MEANS, PLOT_STYLES, direct_law, grains_of, mean_law, model_laws, table_law

import sampler
import tablegen
from sampler.numba import rebound

SIZES = 30e-6, 100e-6


@numba.njit(cache=True)
def rebound_each(table, v, n, half, omega, inertia, seed, index, hit):
    """Draw rebounds of grains one by one; return velocities, spins and inertias about them."""
    after = np.empty((len(v), 7))
    for k in range(len(v)):
        rebound(
            table,
            (v[k, 0], v[k, 1], v[k, 2]),
            (n[k, 0], n[k, 1], n[k, 2]),
            half[k],
            omega=(omega[k, 0], omega[k, 1], omega[k, 2]),
            inertia=inertia[k],
            index=index[k],
            hit=hit[k],
            seed=seed,
            out=after[k],
        )
    return after[:, :3], after[:, 3:6], after[:, 6]


def numba_law(table):
    """Make a law of draws from a table, one grain at a time."""

    def law(velocity, normal, diameter, omega, moment, **keys):
        _, half = grains_of(table, diameter, **keys)
        spin = omega, moment / half**2
        velocity, omega, inertia = rebound_each(table.handle, velocity, normal, half, *spin, **keys)
        return velocity, omega, inertia * half**2

    return law


def distance(result, direct):
    """Compute the largest share by which a column but the spin is off, and its standard error."""
    rows = [list(figures_of(each, *SIZES).values())[:-1] for each in (result, direct)]
    pairs = [(x / y, np.hypot(e, x / y * d) / y) for (x, e), (y, d) in zip(*rows, strict=True)]
    return max((abs(ratio - 1.0), error) for ratio, error in pairs)


def main(arguments=None):
    """Follow the grains under each law; print and draw errors and what the walls cost."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--grains", type=int, default=50_000, help="grains under each law")
    parser.add_argument("--figure", help="picture to write")
    args = parser.parse_args(arguments)
    if args.grains < 1:
        parser.error("argument --grains: give 1 or more")
    warnings.simplefilter("ignore", sampler.OutsideTableWarning)
    table, config = sampler.load("corundum-steel"), tablegen.load_config("corundum-steel")
    model, single = tablegen.DirectModel(config), "table, one by one"
    laws = {"again": direct_law(model)} | model_laws(table, config) | {single: numba_law(table)}
    laws["compact table"] = table_law(sampler.load("corundum-steel-compact"))
    laws |= {name: mean_law(*polynomials) for name, polynomials in MEANS.items()}
    follow_each(laws, model, 100, SIZES, 1)  # compiles
    results = follow_each(laws, model, args.grains, SIZES, 1)
    direct = results.pop("again")
    figure, axes = plt.subplots(figsize=(7.0, 4.5), layout="constrained")
    print("\n| wall | walls, % of the run time | error, % |\n|---|---|---|")
    for name, result in results.items():
        share, off, error = 100.0 * np.array([result.share, *distance(result, direct)])
        print(f"| {name} | {share:.2g} | {off:.1f} ± {error:.1f} |")
        colour, marker, _ = PLOT_STYLES.get(name, (PLOT_STYLES["table"][0], "o", ""))
        axes.errorbar(share, off, error, color=colour, marker=marker, linestyle="", label=name)
    axes.set(xscale="log", xlabel="walls, % of the run time", ylabel="error, %", ylim=(0.0, None))
    ticks = [0.1, 0.2, 0.5, 1.0, 2.0, 5.0]
    axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.minorticks_off()
    axes.legend()
    if args.figure:
        figure.savefig(args.figure, dpi=110)


if __name__ == "__main__":
    main()
