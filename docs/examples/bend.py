"""Particles in a bend of a duct: impacts and energy along its outer wall, with four wall models.

    python docs/examples/bend.py --figure docs/bend_impacts.png

A plane duct of 0.1 m turns by 90 degrees; its gas is a free vortex in the bend. Drag is that of
Schiller and Naumann; the torque of the gas, which slows spins down, is that on a sphere. Laws of
erosion start from these numbers.
"""

import argparse
import math
import warnings
from collections import namedtuple

import matplotlib.pyplot as plt
import numpy as np
from tqdm import tqdm

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

#: Name of each law of the wall: colour, marker and line of its curve.
PLOT_STYLES = {
    "direct simulation": ("#000000", "o", "-"),
    "table": ("#e08a00", "s", "--"),
    "table without spin": ("#0072b2", "^", "--"),
    "sphere": ("#777777", "x", "-."),
}

#: What a particle keeps: place, m; velocity, m/s; mean angular velocity, rad/s, and the inertia
#: about it, over m a^2; its half-size a, m; time since its last wall, s; its number; walls met.
PARTICLE = [("x", "f8", 2), ("v", "f8", 3), ("omega", "f8", 3), ("inertia", "f8")]
PARTICLE += [("half_size", "f8"), ("since", "f8"), ("index", "i8"), ("hits", "i8")]

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


def slow_down_spins(particles, mass, diameter):
    """Let the torque of the gas act on spins. One call since the last wall is exact."""
    spins = particles.inertia > 0.0  # before its first wall a particle does not spin
    moment = particles.inertia * mass * particles.half_size**2
    particles.omega[spins] = sampler.spin_after(
        particles.omega[spins],
        particles.since[spins],
        moment[spins],
        diameter,
        GAS_DENSITY,
        VISCOSITY,
    )


def follow(rebound, half_size, gas, count, seed):
    """Follow particles through the bend; return `Impacts` on the outer wall.

    ``rebound`` has the arguments and results of `sampler.Table.rebound`. The half-size is one for
    all particles, or one for each.
    """
    h = STEP * (OUTER - INNER) / gas[0]
    mass = math.pi / 6.0 * PARTICLE_DENSITY * gas[1] ** 3
    impacts, rng = [], np.random.default_rng(seed)
    particles = np.zeros(count, PARTICLE).view(np.recarray)
    particles.x[:, 0] = -BEFORE
    particles.x[:, 1] = INNER + (OUTER - INNER) * rng.random(count)
    particles.v[:, 0] = gas[0]
    particles.half_size = half_size
    particles.index = np.arange(count)
    with tqdm(total=count, unit="particle", leave=False) as progress:
        while len(particles):
            end, end_v = step(gas, particles.x.T, particles.v.T, h)
            behind = np.flatnonzero(~is_inside(end))
            met = particles[behind]  # a copy, which flies to the wall and rebounds
            times = hit_times(gas, met.x.T, met.v.T, h)
            x, v = step(gas, met.x.T, met.v.T, times)
            met.x, met.v = x.T, v.T
            met.since += times
            particles.x, particles.v = end.T, end_v.T
            particles.since += h

            r, normal = across(x), np.zeros((len(met), 3))
            outer = r > MIDDLE
            normal[:, :2] = (np.where(outer, -1.0, 1.0) * np.maximum(x, 0.0) / r).T
            speed = np.linalg.norm(met.v, axis=1)
            into = -(met.v * normal).sum(axis=1)
            slides = into < SLIDES * gas[0]  # and loses this velocity
            met.v[slides] += ((into + SLIDES * gas[0])[:, None] * normal)[slides]

            angle = np.arcsin(np.minimum(into / speed, 1.0))
            columns = met.index * GROUPS // count, met.hits, along(x), speed, angle
            impacts.append([column[outer & ~slides] for column in columns])
            hit = met[~slides]
            slow_down_spins(hit, mass, gas[1])
            hit.v, hit.omega, hit.inertia = rebound(
                hit.v,
                normal[~slides],
                hit.half_size,
                omega=hit.omega,
                inertia=hit.inertia,
                seed=seed,
                index=hit.index,
                hit=hit.hits,
            )
            hit.hits += 1
            hit.since = 0.0
            met[~slides] = hit
            particles[behind] = met
            inside = (particles.x[:, 0] >= -BEFORE) & (particles.x[:, 1] > -BEHIND)
            progress.update(len(particles) - inside.sum())
            particles = particles[inside]
    return Impacts(*map(np.concatenate, zip(*impacts, strict=True)))


def without_spin(table):
    """Make a law of the wall by which every particle arrives without spin."""

    def rebound(velocity, normal, half_size, *, omega, inertia, **keys):
        return table.rebound(velocity, normal, half_size, **keys)

    return rebound


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
            look = dict(zip(("color", "marker", "linestyle"), PLOT_STYLES[model], strict=True))
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
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--table", default="corundum-steel", help="name, or path of a .h5 file")
    parser.add_argument("--diameter", type=float, default=30e-6, help="of the particles, m")
    parser.add_argument("--count", type=int, default=10_000, help="particles under each model")
    parser.add_argument("--figure", help="picture to write")
    args = parser.parse_args(arguments)
    if args.count < GROUPS or not 0.0 < args.diameter < math.inf:
        parser.error(f"give --count {GROUPS} or more, and a --diameter above 0")
    try:
        table = sampler.load(args.table)
    except sampler.InputError as error:
        parser.error(str(error))
    warnings.simplefilter("ignore", sampler.OutsideTableWarning)
    config = tablegen.parse_config(table.config, "--table")
    model = tablegen.DirectModel(config)
    spheres = tablegen.DirectModel(config, config.population.restricted_to("sphere"))
    laws = {
        "direct simulation": (model, model.rebound),
        "table": (table, table.rebound),
        "table without spin": (table, without_spin(table)),
        "sphere": (spheres, spheres.rebound),
    }
    whole, cells, edges = {}, {}, TURN / 12 * np.arange(23)  # 12 cells in the bend, 10 behind it
    for seed, (name, (grains_of, rebound)) in enumerate(laws.items(), 1000):
        grains = grains_of.grains(seed, np.arange(args.count))
        half_size = sampler.half_size(grains_of, args.diameter, grains)
        impacts = follow(rebound, half_size, (SPEED, args.diameter), args.count, seed)
        whole[name] = by_place(impacts, args.count, edges[[0, -1]], SPEED)
        cells[name] = by_place(impacts, args.count, edges, SPEED)
    print_wall(whole)
    if args.figure:
        figure = plt.figure(figsize=(13.0, 7.0), layout="constrained")
        draw_wall(figure, cells, edges)
        figure.savefig(args.figure, dpi=110)


if __name__ == "__main__":
    main()
