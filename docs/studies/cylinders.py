"""A dusty gas past three columns of cylinders: the flow of `wall_laws.py`, flown by numba.

The gas is the potential flow of three rows of doublets, whose closed streamlines are the cylinders
within 2 %. Drag is that of Schiller and Naumann with Ganser's factors for the sphericity of each
grain (Powder Technol. 77 (1993) 143), and the torque of the gas is that on a sphere. It changes a
spin by the grain's own moment of inertia about that spin, which a rebound gives.
"""

import math
import time
from collections import namedtuple

import numba
import numpy as np
from tqdm import tqdm

import sampler

GAS_DENSITY, VISCOSITY, DENSITY, SPEED = 1.16, 1.85e-5, 3950.0, 120.0  # air and corundum, SI
RADIUS, PITCH, COLUMNS, AHEAD = 5e-3, 20e-3, 3, -10e-3  # of cylinders; where grains enter, m
STEP, CELL = 2e-4, 5e-4  # of path, m; of the density, m
HOP = 0.01  # height of the lowest hop that is followed, in diameters
CELLS = round(PITCH / CELL), round((COLUMNS * PITCH - AHEAD) / CELL)  # across, along the stream
BACK, PASSED, STAYED = -1, -2, -3  # fates, in place of the number of a column
ENERGY = "energy of grains thrown back, J/kg"
#: Of grains: diameter, fate, hits, energy [J/kg] and spin at the end, seconds ahead of cylinders
#: after a hit. Of hits: column, speed, angle [degrees]. Seconds that bounced grains were in each
#: cell. Share of the law of the wall in the CPU time.
Result = namedtuple("Result", "diameter fate hits energy spin ahead column speed angle field share")


def drag_of(diameter, sphericity):
    """Factors of the rate of drag: that of Stokes, 1/s, and Reynolds number over slip, s/m."""
    round_ = np.minimum(sphericity, 1.0)  # rounding of spheres
    k1 = 1.0 / (1.0 / 3.0 + 2.0 / 3.0 / np.sqrt(round_))
    k2 = 10.0 ** (1.8148 * (-np.log10(round_)) ** 0.5743)
    stokes = 18.0 * VISCOSITY / (DENSITY * diameter**2 * k1)
    return np.stack((stokes, k1 * k2 * GAS_DENSITY * diameter / VISCOSITY), axis=1)


def spin_after(omega, time, moment, diameter):
    """Angular velocities (n, 3) that the torque of the gas leaves after flights of some times.

    One call for a whole flight is exact, since the gas has the same torque all along. ``moment`` is
    that of inertia about the spin over the mass, m^2; 0 before the first wall, without a spin.
    """
    after, spins = omega.copy(), moment > 0.0
    inertia = math.pi / 6.0 * DENSITY * diameter**3 * moment
    given = omega[spins], time[spins], inertia[spins]
    size = np.broadcast_to(diameter, moment.shape)[spins]
    after[spins] = sampler.spin_after(*given, size, GAS_DENSITY, VISCOSITY)
    return after


@numba.njit(cache=True)
def from_axis(x, y):
    """Nearest column, and the place from the nearest of its axes."""
    column = min(max(round(x / PITCH), 0), COLUMNS - 1)
    y = y / PITCH - 0.5 * (column % 2)
    return column, x - column * PITCH, PITCH * (y - round(y))


@numba.njit(cache=True)
def gas_velocity(x, y):
    """Velocity of the gas."""
    flow, doublet = complex(SPEED, 0.0), 4.0 * SPEED * math.sinh(math.pi * RADIUS / PITCH) ** 2
    for column in range(COLUMNS):
        z = 2.0 * math.pi * complex(x / PITCH - column, y / PITCH - 0.5 * (column % 2))
        e = np.exp(-z if z.real > 0.0 else z)
        flow -= doublet * e / (1.0 - e) ** 2
    return flow.real, -flow.imag


@numba.njit(cache=True)
def acceleration(p, drag):
    """Acceleration at a state: x, y, and three components of velocity."""
    du, dv = gas_velocity(p[0], p[1])
    du, dv, dw = du - p[2], dv - p[3], -p[4]
    reynolds = drag[1] * math.sqrt(du * du + dv * dv + dw * dw)
    rate = drag[0] * (1.0 + 0.15 * reynolds**0.687)
    return rate * du, rate * dv, rate * dw


@numba.njit(cache=True)
def step(p, drag, h):
    """State after a time h, by the midpoint rule, and whether it is outside of all cylinders."""
    (x, y, u, v, w), t, a = p, 0.5 * h, acceleration(p, drag)
    um, vm, wm = u + t * a[0], v + t * a[1], w + t * a[2]
    a = acceleration((x + t * u, y + t * v, um, vm, wm), drag)
    p = x + h * um, y + h * vm, u + h * a[0], v + h * a[1], w + h * a[2]
    _, x, y = from_axis(p[0], p[1])
    return p, x * x + y * y > RADIUS * RADIUS


@numba.njit(cache=True)
def fly(states, drags, field):
    """Fly grains to their next walls or ends, from states that are replaced by those there.

    Adds the seconds in each cell to a field. Returns columns or fates, normals, times, times ahead,
    and the accelerations that press grains to the cylinders, less those of their paths round them.
    """
    where, normal, times = np.empty(len(states), np.int64), 0.0 * states[:, :3], 0.0 * states[:, :2]
    pressing = np.empty(len(states))
    for k in range(len(states)):
        p = (states[k, 0], states[k, 1], states[k, 2], states[k, 3], states[k, 4])
        drag, outside = (drags[k, 0], drags[k, 1]), True
        while outside and AHEAD <= p[0] < COLUMNS * PITCH:
            low, h = 0.0, STEP / (math.hypot(p[2], p[3]) + 10.0)
            field[int(p[1] % PITCH / CELL), int((p[0] - AHEAD) / CELL)] += h
            times[k, 1] += h if p[0] < -RADIUS else 0.0
            end, outside = step(p, drag, h)
            for _ in range(0 if outside else 40):
                middle = 0.5 * (low + h)
                low, h = (middle, h) if step(p, drag, middle)[1] else (low, middle)
            p = end if outside else step(p, drag, low)[0]
            times[k, 0] += h
        states[k, 0], states[k, 1], states[k, 2], states[k, 3], states[k, 4] = p
        column, x, y = from_axis(p[0], p[1])
        where[k] = column if not outside else BACK if p[0] < 0.0 else PASSED
        normal[k, 0], normal[k, 1] = x / math.hypot(x, y), y / math.hypot(x, y)
        a, around = acceleration(p, drag), normal[k, 0] * p[3] - normal[k, 1] * p[2]
        pressing[k] = -a[0] * normal[k, 0] - a[1] * normal[k, 1] - around * around / RADIUS
    return where, normal, times[:, 0], times[:, 1], pressing


def follow(law, model, count, sizes, seed, progress):
    """Follow grains of diameters between two from wall to wall to their ends; return a `Result`.

    ``model`` is the table or direct model whose grains they are.
    """
    rng, index, hits = np.random.default_rng(seed), np.arange(count), np.zeros(count, int)
    diameter = rng.uniform(*sizes, count)
    drags = drag_of(diameter, sampler.sphericity(model, model.grains(seed, index)))
    states = np.tile([AHEAD, 0.0, SPEED, 0.0, 0.0], (count, 1))
    states[:, 1] = PITCH * rng.random(count)
    omega, moment, fate = np.zeros((count, 3)), np.zeros(count), np.full(count, STAYED)
    fields, met, ahead, walls, start = [], [], np.zeros(count), 0.0, time.process_time()
    while len(index):
        fields.append(np.zeros(CELLS))
        flown, of_grain = states[index], diameter[index]
        column, normal, flight, passing, pressing = fly(flown, drags[index], fields[-1])
        states[index] = flown
        ahead[index] += passing * (hits[index] > 0)
        omega[index] = spin_after(omega[index], flight, moment[index], of_grain)
        velocity, ended = flown[:, 2:], column < 0
        fate[index[ended]] = column[ended]
        into = -(velocity * normal).sum(axis=1)
        slowest = np.sqrt(2.0 * np.maximum(pressing, 0.0) * HOP * of_grain)
        k = (into >= slowest) & ~ended
        progress.update(len(index) - k.sum())
        index, velocity, into = index[k], velocity[k], into[k]
        speed = np.linalg.norm(velocity, axis=1)
        met.append((column[k], speed, np.degrees(np.arcsin(np.minimum(into / speed, 1.0)))))
        impact = velocity, normal[k], of_grain[k], omega[index], moment[index]
        before = time.process_time()
        after = law(*impact, seed=seed, index=index, hit=hits[index])
        walls += time.process_time() - before
        states[index, 2:], omega[index], moment[index] = after
        hits[index] += 1
    energy = 0.5 * (states[:, 2:] ** 2).sum(axis=1)
    ends = diameter, fate, hits, energy, np.linalg.norm(omega, axis=1), ahead
    share = walls / (time.process_time() - start)
    return Result(*ends, *map(np.concatenate, zip(*met, strict=True)), sum(fields[1:]), share)


def follow_each(laws, model, count, sizes, seed):
    """Follow independent grains under each law; return `Result`s by name."""
    results = {}
    with tqdm(total=count * len(laws), unit="grain") as progress:
        for number, (name, law) in enumerate(laws.items()):
            results[name] = follow(law, model, count, sizes, 100 * seed + number, progress)
    return results


def figures_of(result, low, high):
    """Compute the columns of the table of results, and errors, of grains of a range of sizes."""
    of_size = (result.diameter >= low) & (result.diameter < high)
    back, left = of_size & (result.fate == BACK), of_size & (result.fate != STAYED)
    samples = {
        "thrown back": back[of_size],
        "density ahead": result.ahead[of_size] * SPEED / (-RADIUS - AHEAD),
        "hits a grain": result.hits[of_size],
        ENERGY: result.energy[back],
        "exit spin, 10³ rad/s": 1e-3 * result.spin[left],
    }
    return {
        name: (x.mean(), x.std() / math.sqrt(x.size)) if x.size else (math.nan, math.nan)
        for name, x in samples.items()
    }
