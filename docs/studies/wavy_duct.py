"""Grains in a duct with wavy walls: tables beside direct simulation.

    python docs/studies/wavy_duct.py

Gas of 45 m/s blows through a square duct that is 10 mm wide and 3.5 m long. Its half-width varies
by 0.84 mm with a wave length of 30 mm, so that walls are inclined by up to ten degrees. Corundum
grains of 20 to 200 micrometres enter at 30 m/s along the duct, and across it at a standard
deviation of 15 m/s, and hit the walls about 120 times. The program prints means of direct
simulation and their standard errors. For each table it prints how far its means are from these, in
% and, in brackets, in standard errors of the difference. Energies are those of translation.

The velocity of the gas is the same everywhere. Drag is that of a sphere (Schiller & Naumann, Z. VDI
77 (1933) 318), up to Reynolds numbers of 800, and the gas slows down spins as in
`sampler.spin_after`. Between hits grains are points, and they do not meet each other. Sizes are
diameters of spheres of equal volume, evenly distributed over their logarithm. Most hits are slower
than the measured ones, so that the tables and the model are extrapolated alike.
"""

import argparse
import itertools
import math
import warnings
from pathlib import Path
from types import SimpleNamespace

import numpy as np
from tqdm import tqdm

import sampler
import tablegen

GAS_DENSITY, VISCOSITY, DENSITY = 1.16, 1.85e-5, 3950.0  # air, corundum; SI
GAS = np.array([[45.0], [0.0], [0.0]])  # velocity, m/s
ENTRY_SPEED, ENTRY_SPREAD = 30.0, 15.0  # m/s, along the duct; standard deviation across
WIDTH, LENGTH, WAVE_LENGTH, AMPLITUDE = 10e-3, 3.5, 30e-3, 0.84e-3  # of the duct, m
WAVE_NUMBER = 2.0 * np.pi / WAVE_LENGTH
PHASES = np.array([0.0, 0.5 * np.pi])  # of the walls across y, and across z
CLASSES = np.geomspace(20e-6, 200e-6, 4)  # edges of the classes of size, m
TABLES = ["corundum-steel", "corundum-steel-compact"]
SHAPES = ("ellipsoid", "prism", "truncated-prism", "tetrahedron")
MOST_HITS = 1000
LONGEST_PATH, LEAST_SPEED = WAVE_LENGTH / 20.0, 10.0  # of a step, m; m/s, added to the speed
SHORTEST_STEP = 1e-10  # s, after a rebound; rounding would hide a hop that is much shorter
BISECTIONS = 36  # 1.5 mm become 2e-14 m
SLOWEST_APPROACH = 1e-6  # m/s
EXIT, ENTRY, TOO_MANY_HITS = range(3)  # where a grain ended


def wall_distances(place):
    """Distance across the duct to the nearer wall across y, and across z, (2, n); < 0 outside."""
    half_width = 0.5 * WIDTH + AMPLITUDE * np.sin(WAVE_NUMBER * place[0] + PHASES[:, np.newaxis])
    return half_width - np.abs(place[1:])


def is_inside(place):
    """Whether places (3, n) are between the walls."""
    return (wall_distances(place) >= 0.0).all(axis=0)


def wall_normals(place):
    """Normals, into the gas, of the walls that are nearest to places (3, n)."""
    across = np.argmin(wall_distances(place), axis=0)
    row = 1 + across, np.arange(place.shape[1])
    normal = np.zeros_like(place)
    # the gradient of the distance across the duct
    normal[0] = AMPLITUDE * WAVE_NUMBER * np.cos(WAVE_NUMBER * place[0] + PHASES[across])
    normal[row] = -np.sign(place[row])
    return normal / np.sqrt((normal**2).sum(axis=0))


def drag_rate(velocity, diameter):
    """Rate at which drag takes the slip, 1/s."""
    reynolds = GAS_DENSITY * diameter / VISCOSITY * np.sqrt(((velocity - GAS) ** 2).sum(axis=0))
    return 18.0 * VISCOSITY / (DENSITY * diameter**2) * (1.0 + 0.15 * reynolds**0.687)


def fly(place, velocity, rate, time):
    """Place and velocity after a time; exact while the rate of the drag does not change."""
    slip = velocity - GAS
    lost = -np.expm1(-rate * time)
    return place + GAS * time + slip * (lost / rate), velocity - slip * lost


def time_to_wall(place, velocity, rate, time):
    """Last time before ``time`` at which grains are inside that are outside after ``time``."""
    inside_until, outside_from = np.zeros_like(time), time
    for _ in range(BISECTIONS):
        middle = 0.5 * (inside_until + outside_from)
        inside = is_inside(fly(place, velocity, rate, middle)[0])
        inside_until = np.where(inside, middle, inside_until)
        outside_from = np.where(inside, outside_from, middle)
    return inside_until


def longest_step(velocity):
    """Time in which a grain flies a short part of a wave."""
    return LONGEST_PATH / (LEAST_SPEED + np.sqrt((velocity**2).sum(axis=0)))


def first_step(velocity, normal, rate):
    """Time in which a hop is at its highest over the most concave part of a wall.

    Steps that begin with this one and double do not pass over the part of a path that lies behind
    the wall, which is short where a low hop ends between trough and crest.
    """
    curvature = AMPLITUDE * WAVE_NUMBER**2
    speed, slip = (np.sqrt((v**2).sum(axis=0)) for v in (velocity, velocity - GAS))
    time = (velocity * normal).sum(axis=0) / (curvature * speed**2 + rate * slip)
    return np.clip(time, SHORTEST_STEP, longest_step(velocity))


def enter(count, seed):
    """Draw grains that enter: places and velocities (3, n), and diameters."""
    rng = np.random.default_rng(seed)
    place, velocity = np.zeros((3, count)), np.full((3, count), ENTRY_SPEED)
    place[1:] = (0.5 * WIDTH - AMPLITUDE) * rng.uniform(-1.0, 1.0, (2, count))
    velocity[1:] = ENTRY_SPREAD * rng.standard_normal((2, count))
    return place, velocity, CLASSES[0] * (CLASSES[-1] / CLASSES[0]) ** rng.random(count)


def follow(law, place, velocity, diameter, half_size, seed, progress):
    """Follow grains to their ends.

    ``place`` and ``velocity`` (3, n) are those at the entry, in m and m/s; ``diameter`` and
    ``half_size`` are in m. Return arrays by name: ``end`` (`EXIT`, `ENTRY` or `TOO_MANY_HITS`),
    ``hits``, energy ``brought`` to walls, J/kg, and ``place`` and ``velocity`` at the end.
    """
    place, velocity, n = place.copy(), velocity.copy(), len(diameter)
    omega, (inertia, flight, brought) = np.zeros((n, 3)), np.zeros((3, n))
    (hits, end), step = np.zeros((2, n), dtype=int), longest_step(velocity)
    mass = np.pi / 6.0 * DENSITY * diameter**3
    moving = np.arange(n)
    while moving.size:
        start, departure, time = place[:, moving], velocity[:, moving], step[moving]
        rate = drag_rate(departure, diameter[moving])
        behind = np.flatnonzero(~is_inside(fly(start, departure, rate, time)[0]))
        crossing = start[:, behind], departure[:, behind], rate[behind], time[behind]
        time[behind] = time_to_wall(*crossing)
        place[:, moving], velocity[:, moving] = fly(start, departure, rate, time)
        flight[moving] += time
        step[moving] = np.minimum(2.0 * time, longest_step(departure))
        x = place[0, moving]
        hit = behind[(x[behind] >= 0.0) & (x[behind] <= LENGTH)]
        hitting = moving[hit]
        spinning = hitting[inertia[hitting] > 0.0]  # the others did not hit a wall yet
        moment = inertia[spinning] * mass[spinning] * half_size[spinning] ** 2
        flown = flight[spinning], moment, diameter[spinning]
        omega[spinning] = sampler.spin_after(omega[spinning], *flown, GAS_DENSITY, VISCOSITY)
        normal, before = wall_normals(place[:, hitting]), velocity[:, hitting]
        # of the lowest hops, rounding may turn round the direction at the end
        before -= np.maximum(SLOWEST_APPROACH + (before * normal).sum(axis=0), 0.0) * normal
        brought[hitting] += 0.5 * (before**2).sum(axis=0)
        spin = {"omega": omega[hitting], "inertia": inertia[hitting]}
        keys = {"seed": seed, "index": hitting, "hit": hits[hitting]}
        after, omega[hitting], inertia[hitting] = law.rebound(
            before.T, normal.T, half_size[hitting], **spin, **keys
        )
        velocity[:, hitting] = after.T
        step[hitting] = first_step(after.T, normal, rate[hit])
        flight[hitting] = 0.0
        hits[hitting] += 1
        ends = [x > LENGTH, x < 0.0, hits[moving] >= MOST_HITS]
        end[moving] = np.select(ends, [EXIT, ENTRY, TOO_MANY_HITS], -1)
        ended = end[moving] >= 0
        progress.update(int(ended.sum()))
        moving = moving[~ended]
    return SimpleNamespace(end=end, hits=hits, brought=brought, place=place, velocity=velocity)


def columns_of(result, rows):
    """Means over some grains and their standard errors, by the name of the column."""
    leaving = rows & (result.end == EXIT)
    samples = {
        "hits a grain": result.hits[rows],
        "brought, kJ/kg": 1e-3 * result.brought[rows],
        "at the exit, J/kg": 0.5 * (result.velocity[:, leaving] ** 2).sum(axis=0),
        "thrown back, %": 100.0 * (result.end[rows] == ENTRY),
    }
    return {
        name: (x.mean(), x.std() / math.sqrt(x.size)) if x.size else (math.nan, math.nan)
        for name, x in samples.items()
    }


def difference(mean, error, expected, expected_error):
    """Write how far a mean is from that of direct simulation."""
    if not expected > 0.0:
        return "-"
    errors = (mean - expected) / (math.hypot(error, expected_error) or math.inf)
    return f"{100.0 * (mean / expected - 1.0):+.2f} % ({errors:+.1f})"


def print_columns(results):
    """Print the columns of all laws, of all grains and by shape and size."""
    shapes = [(None, "all shapes"), *enumerate(SHAPES)]
    sizes = [(CLASSES[0], CLASSES[-1]), *itertools.pairwise(CLASSES)]
    for (code, shape), (low, high) in itertools.product(shapes, sizes):
        columns = {}
        for law, result in results.items():
            rows = (result.diameter >= low) & (result.diameter <= high)
            columns[law] = columns_of(result, rows & ((code is None) | (result.shape == code)))
        expected = next(iter(columns.values()))
        group = f"{shape}, {1e6 * low:.0f} to {1e6 * high:.0f} µm"
        print(f"{group:32}" + "".join(f"{name:>18}" for name in expected))
        for law, row in columns.items():
            cells = [f"{mean:.2f} ± {error:.2f}" for mean, error in row.values()]
            if row is not expected:
                cells = [difference(*row[name], *expected[name]) for name in row]
            print(f"  {Path(law).stem:30}" + "".join(f"{cell:>18}" for cell in cells))


def main(words=None):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--grains", type=int, default=20_000, help="number of grains (20000)")
    parser.add_argument("--tables", nargs="+", default=TABLES, help="names, or paths of .h5 files")
    arguments = parser.parse_args(words)
    if arguments.grains < 1:
        parser.error("argument --grains: give 1 or more")
    try:
        compare(arguments.grains, arguments.tables)
    except sampler.InputError as error:  # for one, a table without a spin law
        parser.error(str(error))


def compare(count, names):
    """Follow grains by direct simulation and by tables, and print how they differ."""
    tables = {name: sampler.load(name) for name in names}
    model = tablegen.DirectModel(tablegen.load_config("corundum-steel"))
    results = {}
    progress = tqdm(total=count * (1 + len(tables)), unit="grain", leave=False)
    with progress, warnings.catch_warnings(category=sampler.OutsideTableWarning, action="ignore"):
        # independent grains under each law, so that standard errors of differences are right
        for seed, (name, law) in enumerate(({"direct simulation": model} | tables).items(), 1):
            place, velocity, diameter = enter(count, seed)
            grains = model.grains(seed, np.arange(count))
            half_size = sampler.half_size(model, diameter, grains)
            result = follow(law, place, velocity, diameter, half_size, seed, progress)
            result.diameter, result.shape = diameter, grains[:, 0]
            results[name] = result
    for name, result in results.items():
        many = (result.end == TOO_MANY_HITS).sum()
        print(f"{Path(name).stem}: {many} of {count} grains end after {MOST_HITS} hits")
    print_columns(results)


if __name__ == "__main__":
    main()
