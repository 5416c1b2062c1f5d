"""Particles in a bend of a duct: impacts and energy along its outer wall, with four wall models.

    python docs/examples/bend.py --figure docs/bend_impacts.png

A plane duct of 0.1 m turns by 90 degrees; its gas is a free vortex in the bend. Drag is that of
Schiller and Naumann; the torque of the gas, which slows spins down, is that on a sphere. Laws of
erosion start from these numbers.
"""

import math
import warnings
from collections import namedtuple

import matplotlib.pyplot as plt
import numpy as np
from cylinders import spin_after
from example_arguments import Parser, length
from tqdm import tqdm
from wall_laws import LOOKS, model_laws

import sampler
import tablegen

GAS_DENSITY, VISCOSITY, PARTICLE_DENSITY = 1.16, 1.85e-5, 3950.0  # air and corundum, SI
INNER, OUTER, BEFORE, BEHIND = 0.1, 0.2, 0.1, 0.2  # radii of the walls, straight parts, m
MIDDLE = 0.5 * (INNER + OUTER)
TURN = 0.5 * math.pi * MIDDLE  # length of the bend along its middle line
GROUPS, SPEED, STEP = 20, 150.0, 0.02  # of particles; of the gas, m/s; time, width / SPEED
SLIDES = 1e-3  # speed into the wall, over that of the gas, below which a particle slides
QUANTITIES = (
    "impacts a particle, per metre",
    "mean impact speed [m/s]",
    "mean impact angle [°]",
    "impact energy, per metre",
    "normal impact energy, per metre",
    "energy of all but first impacts, per metre",
)

#: Impacts on one wall, arrays (n,): group of the particle, its hits before, m, m/s, radians.
Impacts = namedtuple("Impacts", "group hit place speed angle")


def across(x):
    """Distances from the axis of the bend, of the nearest points in the bend's quadrant, (n,)."""
    return np.hypot(*np.maximum(x, 0.0))


def along(x):
    """Places along the middle line from the start of the bend, m."""
    turned = MIDDLE * np.arctan2(*np.maximum(x, 0.0))
    return np.minimum(x[0], 0.0) + turned - np.minimum(x[1], 0.0)


def gas_velocity(speed, x):
    """Velocity of the gas at places (2, n)."""
    foot, r = np.maximum(x, 0.0), across(x)
    vortex = (OUTER - INNER) / math.log(OUTER / INNER) / r
    size = speed * np.where((x > 0.0).all(axis=0), vortex, 1.0) / r
    return np.stack((size * foot[1], -size * foot[0], np.zeros_like(r)))


def acceleration(gas, x, v):
    """Acceleration of particles by drag, (3, n); gas: speed (m/s) and particle diameter (m)."""
    speed, diameter = gas
    slip = gas_velocity(speed, x) - v
    reynolds = GAS_DENSITY * diameter / VISCOSITY * np.linalg.norm(slip, axis=0)
    response = PARTICLE_DENSITY * diameter**2 / (18.0 * VISCOSITY)
    return slip * (1.0 + 0.15 * reynolds**0.687) / response


def step(gas, x, v, h):
    """Places (2, n) and velocities (3, n) after times h, by the midpoint rule."""
    middle = v + 0.5 * h * acceleration(gas, x, v)
    return x + h * middle[:2], v + h * acceleration(gas, x + 0.5 * h * v[:2], middle)


def is_inside(x):
    """Whether places lie within the duct."""
    r = across(x)
    return (r > INNER) & (r < OUTER)


def hit_times(gas, x, v, h):
    """Times up to h after which particles that end behind a wall are still just before it."""
    low, high = np.zeros(x.shape[1]), np.full(x.shape[1], h)
    for _ in range(40):
        middle = 0.5 * (low + high)
        inside = is_inside(step(gas, x, v, middle)[0])
        low, high = np.where(inside, middle, low), np.where(inside, high, middle)
    return low


def follow(law, gas, count, seed):
    """Follow particles with a law of `wall_laws.py`; return `Impacts` on the outer wall."""
    h = STEP * (OUTER - INNER) / gas[0]
    records, rng = [], np.random.default_rng(seed)
    x = np.stack((np.full(count, -BEFORE), INNER + (OUTER - INNER) * rng.random(count)))
    v = np.tile([[gas[0]], [0.0], [0.0]], count)
    index, hits = np.arange(count), np.zeros(count, int)
    omega, moment = np.zeros((3, count)), np.zeros(count)  # and of inertia about it, over the mass
    since = np.zeros(count)  # the last wall, s
    with tqdm(total=count, unit="particle", leave=False) as progress:
        while len(index):
            end, end_v = step(gas, x, v, h)
            flown, behind = np.full(len(index), h), np.flatnonzero(~is_inside(end))
            flown[behind] = hit_times(gas, x[:, behind], v[:, behind], h)
            end[:, behind], end_v[:, behind] = step(gas, x[:, behind], v[:, behind], flown[behind])
            since = since + flown
            r, normal = across(end[:, behind]), np.zeros((3, len(behind)))
            outer = r > MIDDLE
            normal[:2] = np.where(outer, -1.0, 1.0) * np.maximum(end[:, behind], 0.0) / r
            speed = np.linalg.norm(end_v[:, behind], axis=0)
            into = -(end_v[:, behind] * normal).sum(axis=0)
            slides = into < SLIDES * gas[0]  # and loses this velocity
            end_v[:, behind[slides]] += ((into + SLIDES * gas[0]) * normal)[:, slides]
            rows, met = behind[~slides], outer & ~slides
            angle = np.arcsin(np.minimum(into / speed, 1.0))
            who = index[behind[met]] * GROUPS // count, hits[behind[met]]
            records.append((*who, along(end[:, behind[met]]), speed[met], angle[met]))
            spin = spin_after(omega[:, rows].T, since[rows], moment[rows], gas[1])
            given = end_v[:, rows].T, normal[:, ~slides].T, gas[1], spin, moment[rows]
            after = law(*given, seed=seed, index=index[rows], hit=hits[rows])
            end_v[:, rows], omega[:, rows], moment[rows] = (part.T for part in after)
            hits[rows], since[rows] = hits[rows] + 1, 0.0
            inside = (end[0] >= -BEFORE) & (end[1] > -BEHIND)
            progress.update(len(index) - inside.sum())
            kept = (end, end_v, omega, moment, since, index, hits)
            x, v, omega, moment, since, index, hits = (a[..., inside] for a in kept)
    return Impacts(*map(np.concatenate, zip(*records, strict=True)))


def by_place(impacts, particles, edges, speed):
    """Compute `QUANTITIES` in the cells of a wall.

    Of impacts of `particles` that enter with a speed; energies are over theirs. Returns values and
    standard errors (jackknife), shape (6, cells); sums are per metre, but not for a single cell.
    """
    square = impacts.speed**2
    energies = (square, square * np.sin(impacts.angle) ** 2, square * (impacts.hit > 0))
    columns = (np.ones_like(square), impacts.speed, np.degrees(impacts.angle), *energies)
    bins = (np.arange(GROUPS + 1) - 0.5, edges)
    sums = [np.histogram2d(impacts.group, impacts.place, bins, weights=c)[0] for c in columns]
    total = np.sum(sums, axis=1)
    rest = total - np.moveaxis(sums, 1, 0)  # without each of the groups

    def quantities(total, share):
        number = np.where(total[0] > 0, total[0], np.nan)
        scale = share * particles * (np.diff(edges) if len(edges) > 2 else 1.0)
        return np.array([total[0] / scale, *(total[1:3] / number), *(total[3:] / scale / speed**2)])

    each = np.array([quantities(part, 1.0 - 1.0 / GROUPS) for part in rest])
    return quantities(total, 1.0), np.sqrt((GROUPS - 1) * each.var(axis=0))


def draw_wall(figure, walls, edges):
    """Draw values and standard errors along a wall by model; grey is the bend."""
    panels, middles = figure.subplots(2, 3), 0.5 * (edges[1:] + edges[:-1])
    for k, (axes, title) in enumerate(zip(panels.ravel(), QUANTITIES, strict=True)):
        axes.axvspan(0.0, TURN, color="#eeeeee", linewidth=0)
        for model, (values, errors) in walls.items():
            look = dict(zip(("color", "marker", "linestyle"), LOOKS[model], strict=True))
            axes.errorbar(middles, values[k], errors[k], label=model, markersize=3, **look)
        axes.set(ylim=(0.0, None), xlim=edges[[0, -1]], title=title, xlabel="along the duct [m]")
    lines = panels[0, 0].get_legend_handles_labels()
    figure.legend(*lines, loc="outside lower center", ncols=len(walls))


def print_wall(walls):
    """Print values and standard errors of a whole wall by model."""
    print("| whole wall | " + " | ".join(walls) + " |\n" + "|---" * (1 + len(walls)) + "|")
    for k, title in enumerate(QUANTITIES):
        cells = (f"{values[k, 0]:.4g} ± {errors[k, 0]:.2g}" for values, errors in walls.values())
        print(f"| {title.removesuffix(', per metre')} | " + " | ".join(cells) + " |")


def main(arguments=None):
    """Run the bend with each model, and print and draw what hits its outer wall."""
    parser = Parser(__file__, __doc__)
    parser.add_table("--table", "corundum-steel")
    parser.add_argument(
        "--diameter", type=length, default=30e-6, metavar="M", help="diameter of the particles, m"
    )
    parser.add_number("--count", 10_000, "number of particles under each model", least=GROUPS)
    parser.add_figure("--figure")
    args = parser.parse_args(arguments)
    warnings.simplefilter("ignore", sampler.OutsideTableWarning)
    models = model_laws(args.table, tablegen.parse_config(args.table.config, "--table"))
    whole, cells, edges = {}, {}, TURN / 12 * np.arange(23)  # 12 cells in the bend, 10 behind it
    for number, (name, law) in enumerate(models.items()):
        impacts = follow(law, (SPEED, args.diameter), args.count, seed=1000 + number)
        whole[name] = by_place(impacts, args.count, edges[[0, -1]], SPEED)
        cells[name] = by_place(impacts, args.count, edges, SPEED)
    print_wall(whole)
    if args.figure:
        figure = plt.figure(figsize=(13.0, 7.0), layout="constrained")
        draw_wall(figure, cells, edges)
        figure.savefig(args.figure, dpi=110)


if __name__ == "__main__":
    main()
