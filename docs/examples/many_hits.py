"""Chains of wall hits without gas, with four models of the wall.

    python docs/examples/many_hits.py --figure docs/many_hits.png

Direct simulation is the reference: its particles keep grain, spin and orientation, and tumble from
wall to wall. The table is drawn from with the spin before each hit and without it; spheres rebound
regularly. Particles meet the same wall again at the angle at which they left it, as on the outside
of a bend; the opposite wall; walls of any direction; or the wall ahead, as in a corner. Printed
after each hit: mean speed, translational energy over that of direct simulation, and
Kolmogorov-Smirnov distances to direct simulation, with the effect of chance.
"""

import argparse
import math
import sys
import warnings

import matplotlib.pyplot as plt
import numpy as np
from scipy.stats import ks_2samp, kstwobign
from tqdm import tqdm

import sampler
import tablegen

#: Name of each model: colour, marker and line of its curve.
LOOKS = {
    "direct simulation": ("#000000", "o", "-"),
    "table": ("#e08a00", "s", "--"),
    "table without spin": ("#0072b2", "^", "--"),
    "spheres": ("#777777", "x", "-."),
}
WALLS = ("one wall", "opposite walls", "any direction", "corner")
#: Observed after each hit; spins times a/V, of the speed V after the hit, z across its plane.
QUANTITIES = ("speed", "angle", "spin", "spin z")
#: Largest half-size, m. It cancels: spins are compared times a/V.
HALF_SIZE = 2e-5


def make_models(table, config):
    """Return by name the four models of a wall.

    They are functions (velocity, normal, omega, orientation, time, **keys) -> velocity, omega,
    orientation, where ``time`` [s] has passed since the particle left the wall before.
    """

    def simulated(direct):
        def rebound(velocity, normal, omega, orientation, time, **keys):
            grain = direct.grains(keys["seed"], keys["index"])
            turned, omega = direct.tumble(orientation, omega, grain, HALF_SIZE, time)
            given = {"omega": omega, "orientation": turned, **keys}
            return direct.rebound(velocity, normal, HALF_SIZE, **given)

        return rebound

    def with_spin(velocity, normal, omega, orientation, time, **keys):
        return *table.rebound(velocity, normal, HALF_SIZE, omega=omega, **keys), orientation

    def without_spin(velocity, normal, omega, orientation, time, **keys):
        # as if every impact were the first
        return *table.rebound(velocity, normal, HALF_SIZE, grain="fresh", **keys), orientation

    spheres = tablegen.DirectModel(config, config.population.restricted_to("sphere"))
    made = (simulated(tablegen.DirectModel(config)), with_spin, without_spin, simulated(spheres))
    models = dict(zip(LOOKS, made, strict=True))
    if not table.has_spin:
        del models["table"]
    return models


def next_wall(walls, velocity, normal, rng):
    """Velocities before the next hit, and normals of the walls, all (n, 3)."""
    into = (velocity * normal).sum(axis=1)[:, None]
    if walls == "one wall":
        return velocity - 2.0 * into * normal, normal
    if walls == "opposite walls":
        return velocity, -normal
    if walls == "corner":
        along = velocity - into * normal
        return velocity, -along / np.linalg.norm(along, axis=1)[:, None]
    ahead = velocity / np.linalg.norm(velocity, axis=1)[:, None]
    side = np.cross(ahead, rng.normal(size=velocity.shape))  # in a random plane
    side /= np.linalg.norm(side, axis=1)[:, None]
    angle = np.radians(rng.uniform(5.0, 85.0, (len(velocity), 1)))
    return velocity, np.cos(angle) * side - np.sin(angle) * ahead


def follow(rebound, walls, alpha_deg, speed, count, hits, seed):
    """Follow particles, with one of `make_models`, through a chain of hits of one of `WALLS`.

    The first impact, at an angle in degrees and a speed in m/s, is without spin. Returns
    `QUANTITIES` after each hit, in m/s, degrees, V/a, V/a, (hits, 4, count).
    """
    alpha, rng = math.radians(alpha_deg), np.random.default_rng(seed)
    velocity = np.tile(speed * np.array([math.cos(alpha), -math.sin(alpha), 0.0]), (count, 1))
    normal = np.tile([0.0, 1.0, 0.0], (count, 1))
    # quaternions of four normal numbers, of any length, are uniform orientations
    omega, turned, time = np.zeros((count, 3)), rng.normal(size=(count, 4)), 0.0
    found = np.empty((hits, len(QUANTITIES), count))
    for hit in range(hits):
        keys = {"seed": seed, "index": np.arange(count), "hit": hit}
        across = np.cross(velocity, normal)
        across /= np.linalg.norm(across, axis=1)[:, None] + 1e-300
        velocity, omega, turned = rebound(velocity, normal, omega, turned, time, **keys)
        speeds = np.linalg.norm(velocity, axis=1)
        angle = np.arcsin(np.minimum((velocity * normal).sum(axis=1) / speeds, 1.0))
        spin = HALF_SIZE / speeds[:, None] * omega
        sizes = np.linalg.norm(spin, axis=1), (spin * across).sum(axis=1)
        found[hit] = speeds, np.degrees(angle), *sizes
        # any path of more than 1.5 half-sizes gives the same law
        time = HALF_SIZE * rng.uniform(5.0, 15.0, count) / speeds
        velocity, normal = next_wall(walls, velocity, normal, rng)
    return found


def compare(found, direct):
    """Compare one hit of a model with direct simulation, both (4, count).

    Returns the ratio of mean energies, its standard error, and KS distances of `QUANTITIES`.
    """
    energies = found[0] ** 2, direct[0] ** 2
    ratio = energies[0].mean() / energies[1].mean()
    spread = [x.std(ddof=1) / (x.mean() * math.sqrt(len(x))) for x in energies]
    ks = [ks_2samp(*pair, method="asymp").statistic for pair in zip(found, direct, strict=True)]
    return ratio, ratio * math.hypot(*spread), ks


def print_chain(name, found):
    """Print the rows of one chain as a Markdown table."""
    direct = found["direct simulation"]
    print(f"\n## {name}\n\n| hit | model | mean speed [m/s] | energy / direct |", end="")
    print("".join(f" KS {quantity} |" for quantity in QUANTITIES) + "\n" + "|---" * 8 + "|")
    for hit in range(len(direct)):
        for model, of_model in found.items():
            ratio, error, ks = compare(of_model[hit], direct[hit])
            row = f"| {hit + 1} | {model} | {of_model[hit, 0].mean():.2f} | "
            row += f"{ratio:.3f} ± {error:.3f} | " if model != "direct simulation" else "1 | "
            print(row + " | ".join(f"{distance:.4f}" for distance in ks) + " |")


def draw(chains, speed, path):
    """Draw the mean speed after each hit; the band holds 80 % of direct simulation."""
    columns = len(chains) // 2
    look = {"figsize": (3.4 * columns + 0.4, 6.8), "sharey": True, "squeeze": False}
    figure, panels = plt.subplots(2, columns, layout="constrained", **look)
    for axes, (name, (means, band)) in zip(panels.ravel(), chains.items(), strict=True):
        hits = np.arange(len(band[0]) + 1)
        axes.fill_between(hits[1:], *band, color="#dddddd", linewidth=0)
        for model, of_model in means.items():
            colour, marker, line = LOOKS[model]
            axes.plot(hits, [speed, *of_model], line, color=colour, marker=marker, label=model)
        axes.set(yscale="log", xlabel="after hit", xticks=hits)
        axes.set_title(name, loc="left")
        axes.yaxis.set_major_formatter("{x:g}")
    figure.supylabel("mean speed [m/s]")
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    figure.savefig(path, dpi=110)


def main(arguments=None):
    """Run the chains; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--table", default="corundum-steel", help="name, or path of a .h5 file")
    parser.add_argument("--alpha", nargs="+", type=float, default=[15.0, 45.0], metavar="DEG")
    parser.add_argument("--speed", type=float, default=250.0, metavar="M_S", help="at first")
    parser.add_argument("--hits", type=int, default=6)
    parser.add_argument("--count", type=int, default=400_000, help="particles of each model")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--figure", metavar="F.png")
    args = parser.parse_args(arguments)
    warnings.simplefilter("ignore", sampler.OutsideTableWarning)  # counted and printed below
    table = sampler.load(args.table)
    models = make_models(table, tablegen.parse_config(table.config, args.table))
    scale = math.sqrt(2.0 / args.count)
    mean, rare = scale * kstwobign.mean(), scale * kstwobign.isf(1e-3)
    print(f"{args.count:,} particles a model; two samples of one law have a KS of {mean:.4f} on")
    print(f"average, and one in a thousand above {rare:.4f}.")
    cases = [(walls, alpha) for walls in WALLS for alpha in args.alpha]
    chains, runs = {}, tqdm(total=len(cases) * len(models), unit="chain")
    for walls, alpha in cases:
        found = {}
        for model, rebound in models.items():
            # a seed for each run: independent samples, so that distances contain chance
            seed = args.seed * 1000 + runs.n
            found[model] = follow(rebound, walls, alpha, args.speed, args.count, args.hits, seed)
            runs.update()
        name = f"{walls}, {alpha:g}°, {args.speed:g} m/s"
        print_chain(name, found)
        means = {model: of_model[:, 0].mean(axis=1) for model, of_model in found.items()}
        chains[name] = means, np.quantile(found["direct simulation"][:, 0], [0.1, 0.9], axis=1)
    runs.close()
    print(f"\nRebounds by flag: {table.counts}.")
    if args.figure:
        draw(chains, args.speed, args.figure)
    return 0


if __name__ == "__main__":
    sys.exit(main())
