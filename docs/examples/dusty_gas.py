"""Dusty gas past a cylinder and a sphere, with three models of the wall.

    python docs/examples/dusty_gas.py --figure docs/dusty_gas.png

Compares the density of particles that have bounced: spheres, direct simulation with tumbling from
wall to wall, and draws from the table; all keep their spin. The gas is a potential flow along x.
Lengths are in body radii R, velocities in stream speeds U, times in R/U.
"""

import argparse
import math
from collections import namedtuple
from concurrent.futures import ThreadPoolExecutor

import matplotlib.pyplot as plt
import numba
import numpy as np
from matplotlib.colors import LogNorm
from tqdm import tqdm

import sampler.numba
import tablegen

GAS_DENSITY, VISCOSITY, PARTICLE_DENSITY, BODY_RADIUS, SPEED = 1.16, 1.85e-5, 3950.0, 0.1, 200.0
STEP, LONGEST, BAND = 0.04, 100.0, 2.0  # time step and limit; half-width of the band of particles
LEFT, PITCH, COLUMNS, ROWS = -2.5, 0.025, 160, 80  # cells of the density: x, distance from the axis
BATCHES, SEED = 64, 1  # parts of a run, whose scatter shows the effect of chance
AT_REST = (0.0, 0.0, 0.0)
#: 2 (cylinder) or 3 (sphere), 1 / Stokes number, Reynolds number of a particle that slips at U.
Gas = namedtuple("Gas", "dimension response reynolds")


@numba.njit
def radius(gas, p):
    """Distance from the axis of the cylinder or the centre of the sphere."""
    return math.sqrt(p[0] * p[0] + p[1] * p[1] + (gas.dimension - 2) * p[2] * p[2])


@numba.njit
def acceleration(gas, p):
    """Acceleration by drag; gas velocity: Batchelor (1967), sections 6.6 and 6.8."""
    x, y, z, u, v, w = p
    n, r = gas.dimension, radius(gas, p)
    dipole = 1.0 / ((n - 1) * r**n)
    s = -n * dipole * x / (r * r)
    du, dv, dw = 1.0 + dipole + s * x - u, s * y - v, (n - 2) * s * z - w
    slip = math.sqrt(du * du + dv * dv + dw * dw)
    rate = gas.response * (1.0 + 0.15 * (gas.reynolds * slip) ** 0.687)
    return rate * du, rate * dv, rate * dw


@numba.njit
def step(gas, p, h):
    """Position and velocity after a time h, by the midpoint rule."""
    x, y, z, u, v, w = p
    (ax, ay, az), t = acceleration(gas, p), 0.5 * h
    um, vm, wm = u + t * ax, v + t * ay, w + t * az
    ax, ay, az = acceleration(gas, (x + t * u, y + t * v, z + t * w, um, vm, wm))
    return x + h * um, y + h * vm, z + h * wm, u + h * ax, v + h * ay, w + h * az


@numba.njit
def hit_time(gas, p, h):
    """Time at which a particle that is inside the body after a time h meets its surface."""
    low, high = 0.0, h
    while high - low > 1e-14:
        t = 0.5 * (low + high)
        low, high = (t, high) if radius(gas, step(gas, p, t)) > 1.0 else (low, t)
    return low


@numba.njit
def simulated(arrays, v, normal, half_size, omega, turning, keys, work, out):
    """Tumble from the last wall, if any, then rebound by direct simulation; return the status."""
    grain, (turned, time) = tablegen.grain(arrays, SEED, keys[0], 0), turning
    if keys[1] > 0 and tablegen.tumble(arrays, turned, omega, grain, time, work)[0] < 0:
        return -1
    impact = (v, normal, half_size, AT_REST, omega, grain, turned, SEED)
    return tablegen.rebound(arrays, *impact, *keys, work, out)


@numba.njit
def drawn(arrays, v, normal, half_size, omega, turning, keys, work, out):
    """Rebound drawn from the table: all that a flow code needs; return the status."""
    return sampler.numba.rebound(
        arrays, v, normal, half_size, omega=omega, index=keys[0], hit=keys[1], seed=SEED, out=out
    )


@numba.njit(nogil=True)
def follow(wall, arrays, gas, half_size, first, starts, work, field):
    """Follow particles first, first + 1, ...; return the number of hits of each, -1 on failure."""
    hits, decay = np.zeros(len(starts), np.int64), 10.0 / 3.0 * gas.response
    for k in range(len(starts)):
        p, out = (starts[k, 0], starts[k, 1], starts[k, 2], 1.0, 0.0, 0.0), np.zeros(6)
        turned, since = np.zeros(4), 0.0  # orientation, at first any; time since the last wall
        for _ in range(int(LONGEST / STEP)):
            left, end = STEP, step(gas, p, STEP)
            while hits[k] >= 0 and radius(gas, end) < 1.0:
                flown = hit_time(gas, p, left)
                p, left = step(gas, p, flown), left - flown
                out[3:] *= math.exp(-decay * flown)
                # torque scales omega alone: so long a free flight with this omega turns as far
                time = math.expm1(decay * (since + flown)) / decay * BODY_RADIUS / SPEED
                normal = (p[0], p[1], (gas.dimension - 2) * p[2])
                v = (SPEED * p[3], SPEED * p[4], SPEED * p[5])
                omega, keys, since = (out[3], out[4], out[5]), (first + k, hits[k]), 0.0
                status = wall(arrays, v, normal, half_size, omega, (turned, time), keys, work, out)
                hits[k] = hits[k] + 1 if status >= 0 else -1
                p = (p[0], p[1], p[2], out[0] / SPEED, out[1] / SPEED, out[2] / SPEED)
                end = step(gas, p, left)
            p = end
            out[3:] *= math.exp(-decay * left)
            since += left
            distance = math.hypot(p[1], (gas.dimension - 2) * p[2])
            column, row = math.floor((p[0] - LEFT) / PITCH), math.floor(distance / PITCH)
            if hits[k] > 0 and 0 <= column < COLUMNS and row < ROWS:
                field[int(row), int(column)] += 1
            if hits[k] < 0 or p[0] < -5.0 or p[0] > 2.0 or distance > 4.0:
                break
    return hits


def run(body, wall, arrays, work_size, stokes, count):
    """Run `count` particles; return the counts of each batch by cell, and the hits of each."""
    diameter = math.sqrt(18.0 * VISCOSITY * stokes * BODY_RADIUS / (SPEED * PARTICLE_DENSITY))
    gas = Gas(2 + (body == "sphere"), 1.0 / stokes, GAS_DENSITY * SPEED * diameter / VISCOSITY)
    phase, a, b = np.random.default_rng(SEED).random((3, count))
    y, z = 2.0 * a - 1.0, 0.0 * b
    if body == "sphere":
        y, z = np.sqrt(a) * np.array([np.cos(2.0 * np.pi * b), np.sin(2.0 * np.pi * b)])
    starts = np.column_stack((-4.0 - STEP * phase, BAND * y, BAND * z))
    fields, size = np.zeros((BATCHES, ROWS, COLUMNS), np.int64), count // BATCHES

    def work(k):
        rows, space = starts[k * size : (k + 1) * size], np.empty(work_size)
        return follow(wall, arrays, gas, 0.5 * diameter, k * size, rows, space, fields[k])

    with ThreadPoolExecutor(numba.config.NUMBA_NUM_THREADS) as pool:
        hits = list(tqdm(pool.map(work, range(BATCHES)), total=BATCHES, desc=body, leave=False))
    return fields, np.concatenate(hits)


def density(body, counts, particles):
    """Density over that of the stream, (..., ROWS, COLUMNS); NaN in cells that the body meets."""
    y, x = PITCH * np.arange(ROWS), LEFT + PITCH * np.arange(COLUMNS)
    flux, size = 2.0 * BAND, np.full(ROWS, 2.0 * PITCH**2)
    if body == "sphere":
        flux, size = np.pi * BAND**2, np.pi * ((y + PITCH) ** 2 - y**2) * PITCH
    outside = np.add.outer(y**2, np.minimum(x**2, (x + PITCH) ** 2)) > 1.0
    return np.where(outside, STEP * flux / particles / size[:, None] * counts, np.nan)


def difference(one, other):
    """Mean difference of densities (BATCHES, ...), and by chance: with random signs of batches."""
    shape = (BATCHES, ROWS // 10, 10, COLUMNS // 10, 10)
    one, other = (np.nansum(field.reshape(shape), axis=(2, 4)) for field in (one, other))
    signs = np.random.default_rng(0).choice([-1.0, 1.0], (100, BATCHES))
    chance = np.abs(np.tensordot(signs, one - other, 1)).sum(axis=(1, 2)).mean()
    return np.array([np.abs((one - other).sum(axis=0)).sum(), chance]) * 2.0 / (one + other).sum()


def draw(fields, path):
    """Draw densities by (body, model)."""
    figure, panels = plt.subplots(2, 3, figsize=(10.0, 4.3), sharex=True, layout="constrained")
    look = {"norm": LogNorm(0.05, 10.0), "cmap": "cividis", "origin": "lower"}
    extent = (LEFT, LEFT + COLUMNS * PITCH, 0.0, ROWS * PITCH)
    for axes, ((body, model), field) in zip(panels.ravel(), fields.items(), strict=True):
        image = axes.imshow(np.clip(field, 0.05, 10.0), extent=extent, **look)
        axes.add_patch(plt.Circle((0.0, 0.0), 1.0, facecolor="white", edgecolor="black"))
        axes.set(title=f"{body}: {model}", xlabel="x / R", xlim=extent[:2], ylim=extent[2:])
    figure.colorbar(image, ax=panels, extend="both", label="density of bounced / stream")
    figure.savefig(path, dpi=110)


def main(arguments=None):
    """Run all models; print who hits, and how far densities are off those of direct simulation."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--table", default="corundum-steel", help="name, or path of a .h5 file")
    parser.add_argument("--stokes", type=float, default=100.0, help="Stokes number, with R")
    parser.add_argument("--count", type=int, default=400_000, help="particles of each case")
    parser.add_argument("--figure", metavar="F.png")
    args = parser.parse_args(arguments)
    table = sampler.load(args.table)
    direct = tablegen.DirectModel(config := tablegen.parse_config(table.config, args.table))
    spheres = tablegen.DirectModel(config, config.population.restricted_to("sphere"))
    models = {"direct simulation": (simulated, direct.arrays, direct.work_size)}
    models["table"] = (drawn, table.handle, 1)
    models["spheres"] = (simulated, spheres.arrays, spheres.work_size)
    count, fields = -(-args.count // BATCHES) * BATCHES, {}
    for body, name in [(body, name) for body in ("cylinder", "sphere") for name in models]:
        counts, hits = run(body, *models[name], args.stokes, count)
        fields[body, name] = density(body, counts, count)
        off, luck = difference(fields[body, name], fields[body, "direct simulation"])
        met, again = np.mean(hits > 0), np.mean(hits > 1)
        print(f"{body}, {name}: {met:.4f} hit, {again:.4f} twice; off {off:.2%}, chance {luck:.2%}")
    if args.figure:
        draw({key: field.sum(axis=0) for key, field in fields.items()}, args.figure)


if __name__ == "__main__":
    main()
