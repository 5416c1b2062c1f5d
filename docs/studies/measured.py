"""Measured rebounds beside computed ones: the shipped pair, and the four files of measurements.

    python docs/studies/measured.py --picture docs/measured_beside_computed.png

For corundum on steel, the measured mean is that of the source of equation (6) of the paper,
Lashkov 1991. There a_n is the normal restitution of the centre of mass, as a function of the impact
speed V and the impact angle, so the mean normal velocity after the impact is a_n sin(angle) V. The
model takes the same formula as the restitution of one contact point. What it gives for the centre
of mass is a result of the simulation, and was not fitted.

The pairs of the four files are simulated at the measured conditions. For them the program prints
the largest deviation of each measured quantity, and whether it was fitted.
"""

import argparse

import matplotlib.pyplot as plt
import numpy as np

import sampler
import tablegen
from tablegen.presentation import TextTable

PAIR, SPEED = "corundum-steel", 200.0  # m/s
ANGLES = np.array([10, 15, 20, 30, 40, 50, 60, 70, 80, 90])  # degrees from the wall

#: Quantities to which the laws of a shipped pair were fitted; all others are predictions.
FITTED = {
    "forder-1998": ("e_n", "e_t"),
    "wakeman-tabakoff-1981": ("e_n", "e_t"),
    "grant-tabakoff-1975": ("e_n", "e_t"),
    "kharaz-2001": ("e_t",),
}


def measured_mean(alpha, speed):
    """Mean normal velocity after the impact, over V, of the source of equation (6)."""
    a_n = 1.0 - (1.0 - np.exp(-0.1 * speed**0.61)) * np.sin(alpha)
    return a_n * np.sin(alpha)


def corundum(count, seed):
    """Mean v/V by angle: measured, of the table, of direct simulation, and its standard error."""
    alpha = np.radians(ANGLES)
    config = tablegen.load_config(PAIR)
    table = sampler.load(PAIR).mean(alpha, SPEED)[:, 1]
    v = [tablegen.simulate(config, a, SPEED, count, seed=seed).state[:, 1] for a in alpha]
    direct, error = np.mean(v, axis=1), np.std(v, axis=1) / np.sqrt(count)
    return measured_mean(alpha, SPEED), table, direct, error


def corundum_text(measured, table, direct):
    rows = [
        [str(a), *(f"{x:.3f}" for x in (m, t, d)), f"{d - m:+.3f}"]
        for a, m, t, d in zip(ANGLES, measured, table, direct, strict=True)
    ]
    title = f"{PAIR} at {SPEED:g} m/s: mean v/V after the impact"
    head = ("angle", "measured", "table", "direct", "direct - measured")
    return str(TextTable(title, head, rows))


def files_text(comparisons):
    """Largest deviation of each measured quantity, and the impact angle at which it is."""
    rows = []
    for name, comparison in comparisons.items():
        for end, agreements in (("", comparison.means), ("_std", comparison.spreads)):
            for quantity, agreement in agreements.items():
                if agreement.largest is not None:
                    column = quantity + end
                    fitted = "fitted" if column in FITTED[name] else "not fitted"
                    worst = int(np.nanargmax(np.abs(agreement.deviation)))
                    angle = f"{comparison.measured.alpha_deg[worst]:.0f}"
                    rows.append([name, column, fitted, f"{agreement.deviation[worst]:+.3f}", angle])
    head = ("file and pair", "column", "laws", "largest deviation", "at angle")
    return str(TextTable("the four files of measurements", head, rows))


def spreads_text(comparison):
    """Computed over measured standard deviations, by impact angle."""
    angles = comparison.measured.alpha_deg
    ratios = {
        f"{name}_std": spread.simulated / spread.measured
        for name, spread in comparison.spreads.items()
    }
    rows = [
        [f"{angle:.0f}", *(f"{x[i]:.2f}" if np.isfinite(x[i]) else "-" for x in ratios.values())]
        for i, angle in enumerate(angles)
    ]
    title = f"{comparison.pair}: computed over measured standard deviation"
    return str(TextTable(title, ("angle", *ratios), rows))


def draw(path, means, comparisons):
    measured, table, direct, error = means
    figure, axes = plt.subplots(2, 3, figsize=(12.0, 7.0), layout="constrained")
    first = axes.flat[0]
    first.plot(ANGLES, measured, "ko", mfc="none", label="measured (formula of the source)")
    first.errorbar(ANGLES, direct, 2.0 * error, color="C0", label="direct simulation")
    first.plot(ANGLES, table, "C1+", label="table")
    first.set_title(f"{PAIR}, {SPEED:g} m/s\nnot fitted", fontsize="medium")
    first.set(ylabel="mean v/V", ylim=(0.0, 0.4))
    panels = [
        ("grant-tabakoff-1975", "e_n"),
        ("grant-tabakoff-1975", "e_t"),
        ("forder-1998", "e_n"),
        ("wakeman-tabakoff-1981", "e_n"),
        ("kharaz-2001", "omega_z"),
    ]
    for panel, (name, quantity) in zip(axes.flat[1:], panels, strict=True):
        comparison = comparisons[name]
        mean, spread = comparison.means[quantity], comparison.spreads.get(quantity)
        angle = comparison.measured.alpha_deg
        known = np.isfinite(mean.measured)
        fitted = "fitted" if quantity in FITTED[name] else "not fitted"
        title = f"{name}\n{quantity} {fitted}"
        if spread is not None and spread.largest is not None:
            title += ", its spread not fitted"
            low, high = mean.simulated - spread.simulated, mean.simulated + spread.simulated
            panel.fill_between(angle[known], low[known], high[known], color="C0", alpha=0.2)
            panel.errorbar(
                angle[known], mean.measured[known], spread.measured[known], fmt="ko", mfc="none"
            )
        else:
            panel.plot(angle[known], mean.measured[known], "ko", mfc="none")
        panel.plot(angle[known], mean.simulated[known], "C0")
        panel.set_title(title, fontsize="medium")
        panel.set_ylabel(quantity)
    for panel in axes.flat:
        panel.set_xlabel("impact angle [degrees]")
        panel.grid(color="0.9")
    first.legend()
    figure.savefig(path, dpi=100)
    plt.close(figure)


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--count", type=int, default=100_000, help="grains at each condition")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--picture", help="draw the comparison to this file")
    given = parser.parse_args(arguments)
    means = corundum(given.count, given.seed)
    comparisons = {
        name: tablegen.compare(tablegen.load_config(name), name, count=given.count, seed=given.seed)
        for name in FITTED
    }
    print(corundum_text(*means[:3]))
    print()
    print(files_text(comparisons))
    print()
    print(spreads_text(comparisons["grant-tabakoff-1975"]))
    if given.picture:
        draw(given.picture, means, comparisons)
    return means, comparisons


if __name__ == "__main__":
    main()
