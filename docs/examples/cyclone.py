"""Grains in a reverse-flow cyclone, which meet its walls tens to hundreds of times.

    python docs/examples/cyclone.py --picture docs/cyclone.png

Air enters at 40 m/s along the wall of a cyclone of 0.2 m, and brings corundum grains of 5 to 100
um. The script follows the grains under four laws of the wall: direct simulation, the table, the
compact table, and the law of first impacts of the table, which knows no spin. It prints for each
shape and size how many grains are collected, their hits and residence time, the energy that they
bring to the wall, and how much they wear it.

Gas. The swirl is that of Barth (Brennst.-Waerme-Kraft 8 (1956) 1; Hoffmann & Stein, "Gas Cyclones
and Swirl Tubes", 2008, chapters 4 and 6): friction at the wall takes angular momentum on the way
inwards. In the core, below the mouth of the vortex finder, the gas turns like a solid body. The
axial velocity is uniform over the outer annulus (down) and over the core (up). Half of the gas goes
round through the dust bin, and half flows into the core evenly over its height; the radial velocity
follows from continuity. There is no turbulence.

Grains. Drag is that of Haider & Levenspiel (Powder Technol. 58 (1989) 63) by the sphericity of each
grain. The torque of the gas on the spin is Stokes's on a sphere of equal volume, with the grain's
own inertia about its spin, and the rotation of the gas, a hundredth of the spins that walls make,
is left out. All other forces but gravity are neglected, and grains do not meet each other.

A grain is collected when it leaves through the dust outlet, or when its next hop from the wall
would be lower than a hundredth of its diameter: then gas, gravity and its own path round the wall
press it to the wall, along which dust slides down. It escapes when it enters the vortex finder. It
counts as not collected if it is still inside after two seconds, because discs can roll round the
cone for long. Sizes are diameters of spheres of equal volume. Each grain stands for the same mass,
with as much mass in each class of log(diameter), so that means over grains are means over mass.
"""

import argparse
import itertools
import json
import math
import warnings
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import matplotlib.pyplot as plt
import numba
import numpy as np
from tqdm import tqdm

import sampler
import tablegen
from sampler.formats.shape_codes import SHAPE_CODES

GAS_DENSITY, VISCOSITY, DENSITY, GRAVITY = 1.16, 1.85e-5, 3950.0, 9.81  # air, corundum; SI

# The cyclone, m. Heights are counted downwards from the lid.
RADIUS, CORE, OUTLET = 0.1, 0.05, 0.09  # of the body, of the vortex finder, of the dust outlet
FINDER, CYLINDER, HEIGHT = 0.12, 0.2, 0.4  # where the vortex finder, the cylinder, the cone end
INLET_HEIGHT, INLET_WIDTH, INLET_SPEED = 0.12, 0.05, 40.0  # m, m, m/s
FLOW = INLET_HEIGHT * INLET_WIDTH * INLET_SPEED  # m^3/s
CORE_HEIGHT = HEIGHT - FINDER
SLOPE = (OUTLET - RADIUS) / (HEIGHT - CYLINDER)  # of the radius of the cone
FRICTION = 0.007  # of the gas at the walls
THROUGH_BIN = 0.5  # share of the gas that goes round through the dust bin, under the wide outlet
#: Angular momentum that friction takes from the wall to the core, over what is left (Barth).
LOSS = CORE_HEIGHT * RADIUS * math.pi * FRICTION * INLET_SPEED / FLOW

STEP, TIME_LIMIT = 1e-3, 2.0  # of path, m; of a flight, s
HOP = 0.01  # height of the lowest hop that is followed, in diameters
SIZES = 5e-6, 100e-6  # diameters, m
CLASSES = np.geomspace(*SIZES, 4)  # edges of the classes of size, m
BINS = np.linspace(0.0, HEIGHT, 17)  # edges of the bins of height, m

#: Walls that a flight ends at, and fates of grains, which end it for ever.
BODY, CONE, LID, TUBE = range(4)
COLLECTED, STAYED, ESCAPED, LOST = -1, -2, -3, -4
FATES = {
    "dust outlet": COLLECTED,
    "at rest on a wall": STAYED,
    "vortex finder": ESCAPED,
    "time limit": LOST,
}
#: Name of each law of the wall: colour, marker and line of its curve.
PLOT_STYLES = {
    "direct simulation": ("#000000", "o", "-"),
    "table": ("#e08a00", "s", "--"),
    "compact table": ("#c44e00", "D", ":"),
    "table without spin": ("#0072b2", "^", "--"),
}
DIRECT, TABLE, COMPACT, WITHOUT_SPIN = PLOT_STYLES

#: What a grain keeps on its way, and what became of it.
GRAIN = [
    ("state", "f8", 6),  # place, m, and velocity, m/s
    ("omega", "f8", 3),  # mean angular velocity, rad/s
    ("inertia", "f8"),  # about it, over m a^2
    ("diameter", "f8"),  # m
    ("half_size", "f8"),  # a, m
    ("grain", "f8", 3),  # shape code, b/a and c/b
    ("fate", "i8"),  # how it ended, one of `FATES`
    ("hits", "i8"),  # walls met
    ("time", "f8"),  # in the cyclone, s
    ("brought", "f8"),  # kinetic energy (translational) with which walls were met, J/kg
    ("taken", "f8"),  # energy (with that of rotation) that walls took, J/kg
    ("wear", "f8", len(BINS) - 1),  # of the wall by Oka's law, m^3/kg, by `BINS` of height
]


@numba.njit(cache=True)
def wall_radius(z):
    """Radius of the cylinder or cone."""
    return RADIUS + SLOPE * max(z - CYLINDER, 0.0)


@numba.njit(cache=True)
def gas_velocity(x, y, z):
    """Velocity of the gas."""
    r = math.sqrt(x * x + y * y) + 1e-12
    if r > CORE:
        around = INLET_SPEED * RADIUS / r / (1.0 + LOSS * (RADIUS - r) / (RADIUS - CORE))
    else:
        around = INLET_SPEED * RADIUS * r / CORE**2 / (1.0 + LOSS)
    if z < FINDER:  # between the vortex finder and the wall, through which the inlet blows
        share = (r * r - CORE**2) / (RADIUS**2 - CORE**2)
        axial = FLOW * z / FINDER / (math.pi * (RADIUS**2 - CORE**2))
        radial = -FLOW / FINDER * share / (2.0 * math.pi * r)
    else:
        sink = FLOW * (1.0 - THROUGH_BIN) / CORE_HEIGHT
        down = FLOW - sink * (z - FINDER)
        if r > CORE:
            wall = wall_radius(z)
            area = wall * wall - CORE**2
            slope = SLOPE if z > CYLINDER else 0.0
            axial = down / (math.pi * area)
            narrowing = 2.0 * wall * slope * (r * r - CORE**2) / area**2
            radial = -sink * (wall * wall - r * r) / area + down * narrowing
        else:
            axial, radial = -down / (math.pi * CORE**2), -sink * (r / CORE) ** 2
        radial /= 2.0 * math.pi * r
    c, s = x / r, y / r
    return radial * c - around * s, radial * s + around * c, axial


def drag_of(diameter, sphericity):
    """Coefficients of the drag of Haider & Levenspiel, (n, 6).

    Rate of Stokes's drag on a sphere, 1/s; Reynolds number over slip, s/m; A, B, C and D of
    C_D = 24/Re (1 + A Re^B) + C / (1 + D/Re).
    """
    s = np.minimum(sphericity, 1.0)
    return np.stack(
        (
            18.0 * VISCOSITY / (DENSITY * diameter**2),
            GAS_DENSITY * diameter / VISCOSITY,
            np.exp(2.3288 - 6.4581 * s + 2.4486 * s**2),
            0.0964 + 0.5565 * s,
            np.exp(4.905 - 13.8944 * s + 18.4222 * s**2 - 10.2599 * s**3),
            np.exp(1.4681 + 12.2584 * s - 20.7322 * s**2 + 15.8855 * s**3),
        ),
        axis=1,
    )


@numba.njit(cache=True)
def drag_rate(drag, u, v, w):
    """Rate at which drag takes a slip, 1/s."""
    reynolds = drag[1] * math.sqrt(u * u + v * v + w * w)
    correction = 1.0 + drag[2] * reynolds ** drag[3]
    correction += drag[4] / 24.0 * reynolds * reynolds / (reynolds + drag[5])
    return drag[0] * correction


@numba.njit(cache=True)
def part_of_step(p, at, drag, h):
    """State after a time h in the gas of a place, with the drag there; exact if neither changes."""
    u, v, w = gas_velocity(at[0], at[1], at[2])
    rate = drag_rate(drag, u - at[3], v - at[4], w - at[5])
    left = math.exp(-rate * h)
    moved = -math.expm1(-rate * h) / rate if rate * h > 1e-12 else h
    fallen = (h - moved) / rate if rate * h > 1e-4 else 0.5 * h * h
    return (
        p[0] + h * u + moved * (p[3] - u),
        p[1] + h * v + moved * (p[4] - v),
        p[2] + h * w + moved * (p[5] - w) + GRAVITY * fallen,
        u + left * (p[3] - u),
        v + left * (p[4] - v),
        w + left * (p[5] - w) + GRAVITY * moved,
    )


@numba.njit(cache=True)
def step(p, drag, h):
    """State (place and velocity) after a time h, by the midpoint rule."""
    return part_of_step(p, part_of_step(p, p, drag, 0.5 * h), drag, h)


@numba.njit(cache=True)
def is_inside(p):
    """Whether a place is between the walls, and has not entered the vortex finder."""
    r2 = p[0] * p[0] + p[1] * p[1]
    wall = wall_radius(p[2])
    return p[2] >= 0.0 and r2 < wall * wall and (p[2] > FINDER or r2 > CORE**2)


@numba.njit(cache=True)
def end_of_flight(inside, outside):
    """Wall or fate that lies between two neighbouring states."""
    if outside[2] < 0.0:
        return LID
    if outside[2] <= FINDER and math.hypot(outside[0], outside[1]) <= CORE:
        return ESCAPED if inside[2] > FINDER else TUBE
    return CONE if outside[2] > CYLINDER else BODY


@numba.njit(cache=True)
def fly(p, drag, time_left):
    """Fly a grain to its next wall or its end; return the state there, which, and the time."""
    time = 0.0
    while True:
        if p[2] >= HEIGHT:
            return p, COLLECTED, time
        if time >= time_left:
            return p, LOST, time
        h = STEP / (math.sqrt(p[3] ** 2 + p[4] ** 2 + p[5] ** 2) + 1.0)
        end = step(p, drag, h)
        if is_inside(end):
            p, time = end, time + h
            continue
        low, high, inside = 0.0, h, p
        for _ in range(40):
            middle = 0.5 * (low + high)
            state = step(p, drag, middle)
            if is_inside(state):
                low, inside = middle, state
            else:
                high, end = middle, state
        return inside, end_of_flight(inside, end), time + low


@numba.njit(cache=True)
def towards_wall(p, drag, normal, curvature):
    """Acceleration that presses a grain to a wall, m/s^2, with that of its path round the wall."""
    u, v, w = gas_velocity(p[0], p[1], p[2])
    slip = u - p[3], v - p[4], w - p[5]
    rate = drag_rate(drag, slip[0], slip[1], slip[2])
    around = (p[0] * p[4] - p[1] * p[3]) / math.hypot(p[0], p[1])
    away = rate * (slip[0] * normal[0] + slip[1] * normal[1] + slip[2] * normal[2])
    return around * around * curvature - away - GRAVITY * normal[2]


@numba.njit(cache=True, nogil=True)
def fly_all(states, drags, time_left):
    """Fly grains to a wall or their end; their states (n, 6) are replaced.

    Return walls or fates, normals, times, and the accelerations towards the walls.
    """
    n = len(states)
    ends, normals, times = np.empty(n, np.int64), np.zeros((n, 3)), np.empty(n)
    pressing = np.zeros(n)
    for k in range(n):
        q = states[k]
        p, drag = (q[0], q[1], q[2], q[3], q[4], q[5]), drags[k]
        p, ends[k], times[k] = fly(p, drag, time_left[k])
        q[0], q[1], q[2], q[3], q[4], q[5] = p
        r = math.hypot(p[0], p[1])
        outwards = p[0] / r, p[1] / r
        curvature = 0.0  # across the axis, 1/m; above 0 inside of a cylinder
        if ends[k] == BODY or ends[k] == CONE:
            slope = SLOPE if ends[k] == CONE else 0.0
            size = math.sqrt(1.0 + slope * slope)
            normals[k, 0], normals[k, 1] = -outwards[0] / size, -outwards[1] / size
            normals[k, 2] = slope / size
            curvature = 1.0 / (r * size)
        elif ends[k] == TUBE:
            normals[k, 0], normals[k, 1] = outwards
            curvature = -1.0 / r
        elif ends[k] == LID:
            normals[k, 2] = 1.0
        if ends[k] >= 0:
            pressing[k] = towards_wall(p, drag, normals[k], curvature)
    return ends, normals, times, pressing


def oka(speed, angle, diameter):
    """Volume of wall that each kg of sand wears off steel, m^3/kg (Oka, Wear 259 (2005) 95).

    The constants were not checked against the paper: they are for comparisons of laws of the wall.
    """
    sine = np.sin(angle)
    share = sine**0.8 * (1.0 + 1.8 * (1.0 - sine)) ** 1.3
    at_104_m_s = 6.154e-4 / 7850.0
    return at_104_m_s * share * (speed / 104.0) ** 2.35 * (diameter / 326e-6) ** 0.19


def inlet_states(count, rng):
    """Places and velocities of grains that enter, (n, 6)."""
    states = np.zeros((count, 6))
    states[:, 0] = RADIUS - INLET_WIDTH * rng.random(count)
    states[:, 2] = INLET_HEIGHT * rng.random(count)
    states[:, 4] = INLET_SPEED
    return states


def spin_energy(omega, inertia, half_size):
    """Rotational energy, J/kg."""
    return 0.5 * inertia * half_size**2 * (omega**2).sum(axis=1)


def follow(rebound, model, count, seed, progress):
    """Follow grains under a law of the wall to their ends; return them, a record of `GRAIN`.

    ``rebound`` has the arguments and results of `sampler.Table.rebound`; ``model`` is the
    table or direct model whose grains they are.
    """
    rng, index = np.random.default_rng(seed), np.arange(count)
    grains = np.zeros(count, GRAIN).view(np.recarray)
    grains.diameter = SIZES[0] * (SIZES[1] / SIZES[0]) ** rng.random(count)
    grains.state = inlet_states(count, rng)
    grains.grain = model.grains(seed, index)
    grains.half_size = sampler.half_size(model, grains.diameter, grains.grain)
    drags = drag_of(grains.diameter, sampler.sphericity(model, grains.grain))
    while len(index):
        met = grains[index]  # a copy, which flies to the next wall and rebounds
        flown = np.ascontiguousarray(met.state)
        ends, normal, flight, pressing = fly_all(flown, drags[index], TIME_LIMIT - met.time)
        met.state = flown
        met.time += flight
        slow_down_spins(met, flight)
        into = -(met.state[:, 3:] * normal).sum(axis=1)
        slowest = np.sqrt(2.0 * np.maximum(pressing, 0.0) * HOP * met.diameter)
        ends[(ends >= 0) & (into < slowest)] = STAYED
        meets = ends >= 0
        met.fate[~meets] = ends[~meets]
        grains[index] = met
        progress.update(int(len(index) - meets.sum()))
        index, met = index[meets], met[meets]
        if not len(index):
            break
        velocity = met.state[:, 3:]
        speed = np.linalg.norm(velocity, axis=1)
        angle = np.arcsin(np.minimum(into[meets] / speed, 1.0))
        bins = np.clip(np.digitize(met.state[:, 2], BINS) - 1, 0, len(BINS) - 2)
        met.wear[np.arange(len(met)), bins] += oka(speed, angle, met.diameter)
        before = 0.5 * speed**2
        met.brought += before
        before += spin_energy(met.omega, met.inertia, met.half_size)
        after, met.omega, met.inertia = rebound(
            velocity,
            normal[meets],
            met.half_size,
            omega=met.omega,
            inertia=met.inertia,
            seed=seed,
            index=index,
            hit=met.hits,
        )
        met.state[:, 3:] = after
        energy = 0.5 * (after**2).sum(axis=1)
        energy += spin_energy(met.omega, met.inertia, met.half_size)
        met.taken += before - energy
        met.hits += 1
        grains[index] = met
    return grains


def slow_down_spins(grains, flight):
    """Let the torque of the gas act on spins. One call since the last wall is exact."""
    spins = grains.inertia > 0.0  # before its first wall a grain does not spin
    mass = math.pi / 6.0 * DENSITY * grains.diameter[spins] ** 3
    grains.omega[spins] = sampler.spin_after(
        grains.omega[spins],
        flight[spins],
        grains.inertia[spins] * mass * grains.half_size[spins] ** 2,
        grains.diameter[spins],
        GAS_DENSITY,
        VISCOSITY,
    )


def without_spin(table):
    """Make a law of the wall from the law of first impacts of a table, for every hit."""

    def rebound(velocity, normal, half_size, *, omega, inertia, **keys):
        return table.rebound(velocity, normal, half_size, grain="fresh", **keys)

    return rebound


def columns_of(result, rows):
    """Compute means and standard errors of the columns of some grains, by name."""
    samples = {
        "collected": np.isin(result.fate, (COLLECTED, STAYED)),
        "hits": result.hits,
        "residence, ms": 1e3 * result.time,
        "energy brought, kJ/kg": 1e-3 * result.brought,
        "energy taken, kJ/kg": 1e-3 * result.taken,
        "Oka, mm³/kg": 1e9 * result.wear.sum(axis=1),
    }
    return {name: mean_and_error(values[rows]) for name, values in samples.items()}


def mean_and_error(values):
    """Mean over grains and its standard error; NaN of none."""
    if len(values) == 0:
        return math.nan, math.nan
    return float(values.mean()), float(values.std() / math.sqrt(len(values)))


def groups_of(result):
    """Rows of the groups of grains that are printed, by name: shapes and sizes."""
    codes, every = result.grain[:, 0], np.full(len(result.hits), True)
    shapes = {"all shapes": every}
    shapes |= {name: codes == code for name, code in SHAPE_CODES.items() if (codes == code).any()}
    groups = {}
    for shape, of_shape in shapes.items():
        groups[f"{shape}, 5 to 100 µm"] = of_shape
        for low, high in itertools.pairwise(CLASSES):
            of_size = (result.diameter >= low) & (result.diameter < high)
            groups[f"{shape}, {1e6 * low:.0f} to {1e6 * high:.0f} µm"] = of_shape & of_size
    return groups


def differences(row, direct):
    """Compare two rows: largest difference in standard errors, and names of columns that are off.

    A column is off that differs by more than three standard errors and by more than 3 %.
    """
    errors, off = [0.0], []
    for name, (mean, error) in row.items():
        expected, other = direct[name]
        errors.append(abs(mean - expected) / (math.hypot(error, other) or math.inf))
        if errors[-1] > 3.0 and abs(mean - expected) > 0.03 * expected:
            off.append(name.split(",")[0])
    return max(errors), off


def tables_of(results):
    """Compute the columns by group, law and name."""
    tables = {}
    for law, result in results.items():
        for group, rows in groups_of(result).items():
            if rows.any():
                tables.setdefault(group, {})[law] = columns_of(result, rows)
    return tables


def print_tables(tables):
    """Print a table for each group of grains; the last columns compare with the first law.

    They are the largest difference of a column, and which columns are off (`differences`).
    """
    for group, rows in tables.items():
        direct = next(iter(rows.values()))
        heads = [group, *direct, "standard errors", "off"]
        print(f"\n| {' | '.join(heads)} |\n{'|---' * len(heads)}|")
        for law, row in rows.items():
            cells = [f"{mean:.4g} ± {error:.2g}" for mean, error in row.values()]
            errors, off = differences(row, direct)
            print(f"| {law} | {' | '.join(cells)} | {errors:.1f} | {', '.join(off)} |")


def print_fates(results):
    """Print how many grains ended how."""
    print(f"| grains that end | {' | '.join(FATES)} |\n{'|---' * (1 + len(FATES))}|")
    for law, result in results.items():
        cells = (str(int((result.fate == fate).sum())) for fate in FATES.values())
        print(f"| {law} | {' | '.join(cells)} |")


def wear_by_height(result):
    """Wear for each metre of height, mm^3/(kg m), and standard errors, (2, bins)."""
    per_metre = 1e9 * result.wear / np.diff(BINS)
    return np.array([per_metre.mean(axis=0), per_metre.std(axis=0) / math.sqrt(len(per_metre))])


def column_by_size(result, name, rows, edges):
    """Means and standard errors of a column in classes of size, (2, classes)."""
    points = []
    for low, high in itertools.pairwise(edges):
        of_size = (result.diameter >= low) & (result.diameter < high)
        points.append(columns_of(result, rows & of_size)[name])
    return np.transpose(points)


def draw_outline(axes):
    """Draw the walls of the cyclone."""
    look = {"color": "black"}
    for side in (-1.0, 1.0):
        body = [RADIUS, RADIUS, OUTLET], [0.0, CYLINDER, HEIGHT]
        axes.plot(side * np.array(body[0]), body[1], **look)
        axes.plot([side * CORE, side * RADIUS], [0.0, 0.0], **look)
        axes.plot([side * CORE, side * CORE], [-0.1 * HEIGHT, FINDER], **look)
    axes.set(aspect="equal", xlabel="m", ylabel="m below the lid")
    axes.set_ylim(1.05 * HEIGHT, -0.1 * HEIGHT)


def draw(results):
    """Draw the cyclone, its wear by height, and columns by size of ellipsoids and others."""
    panels = {
        "hits a grain, ellipsoids": "hits",
        "hits a grain, other shapes": "hits",
        "wear by ellipsoids, mm³/kg": "Oka, mm³/kg",
        "residence of ellipsoids, ms": "residence, ms",
    }
    titles = list(panels)
    figure, axes = plt.subplot_mosaic(
        [["outline", "wear", *titles[:2]], ["outline", "wear", *titles[2:]]],
        figsize=(12.0, 6.5),
        layout="constrained",
        width_ratios=(0.7, 1.0, 1.3, 1.3),
    )
    draw_outline(axes["outline"])
    edges, heights = np.geomspace(*SIZES, 8), 0.5 * (BINS[1:] + BINS[:-1])
    for law, result in results.items():
        look = dict(zip(("color", "marker", "linestyle"), PLOT_STYLES[law], strict=True))
        look |= {"label": law, "markersize": 4}
        values, errors = wear_by_height(result)
        axes["wear"].errorbar(values, heights, xerr=errors, **look)
        ellipsoids = result.grain[:, 0] == SHAPE_CODES["ellipsoid"]
        for title, name in panels.items():
            rows = ~ellipsoids if "other" in title else ellipsoids
            points = column_by_size(result, name, rows, edges)
            axes[title].errorbar(1e6 * np.sqrt(edges[1:] * edges[:-1]), *points, **look)
    for title in titles:
        axes[title].set(xscale="log", xlabel="diameter, µm", title=title)
        axes[title].set_xticks([5, 10, 20, 50, 100], ["5", "10", "20", "50", "100"])
        axes[title].minorticks_off()
    axes["wear"].set(xlim=(0.0, None), title="wear by height, mm³/(kg m)")
    axes["wear"].sharey(axes["outline"])
    figure.legend(*axes["wear"].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure


def main(arguments=None):
    """Follow the grains under each law; print, draw and write what becomes of them."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--table", default="corundum-steel", help="name, or path of a .h5 file")
    parser.add_argument("--compact", default="corundum-steel-compact", help="another table")
    parser.add_argument("--grains", type=int, default=10_000, help="grains under each law")
    parser.add_argument("--seed", type=int, default=1, help="seed of the random numbers")
    parser.add_argument(
        "--laws", nargs="+", choices=PLOT_STYLES, metavar="LAW", help="default: all"
    )
    parser.add_argument("--picture", help="picture to write")
    parser.add_argument("--json", type=Path, help="file to write every number to")
    args = parser.parse_args(arguments)
    if args.grains < 1 or args.seed < 0:
        parser.error("give --grains 1 or more, and --seed 0 or more")
    try:
        table, compact = sampler.load(args.table), sampler.load(args.compact)
    except sampler.InputError as error:
        parser.error(str(error))
    warnings.simplefilter("ignore", sampler.OutsideTableWarning)
    model = tablegen.DirectModel(tablegen.parse_config(table.config, "--table"))
    laws = {
        DIRECT: model.rebound,
        TABLE: table.rebound,
        COMPACT: compact.rebound,
        WITHOUT_SPIN: without_spin(table),
    }
    laws = {name: law for name, law in laws.items() if not args.laws or name in args.laws}
    # independent grains under each law, so that standard errors of differences are right
    seeds = [100 * args.seed + number for number in range(len(laws))]
    with (
        tqdm(total=args.grains * len(laws), unit="grain") as progress,
        ThreadPoolExecutor() as pool,
    ):
        runs = [
            pool.submit(follow, law, model, args.grains, seed, progress)
            for law, seed in zip(laws.values(), seeds, strict=True)
        ]
        results = {name: run.result() for name, run in zip(laws, runs, strict=True)}
    tables = tables_of(results)
    print_fates(results)
    print_tables(tables)
    if args.json:
        heights = {name: wear_by_height(result).tolist() for name, result in results.items()}
        numbers = {"columns": tables, "height, m": BINS.tolist(), "wear, mm3/(kg m)": heights}
        args.json.write_text(json.dumps(numbers, indent=1, ensure_ascii=False), encoding="utf-8")
    if args.picture:
        draw(results).savefig(args.picture, dpi=110)


if __name__ == "__main__":
    main()
