"""Grains of corundum in a channel with two plates.

A grain keeps its number, the number of walls that it has met, its spin, and the inertia about it.
"""

import math

import numba
import numpy as np

import sampler
from sampler.numba import deposits, rebound, spin_after

# SI units: time step, gas, diameter, mass and largest half-size of a grain
DT, GAS, DENSITY, VISCOSITY = 2e-5, 100.0, 1.2, 1.8e-5
DIAMETER, MASS, HALF_SIZE = 60e-6, 4.5e-10, 0.63 * 60e-6
DRAG = 9.42477796 * VISCOSITY * DIAMETER / MASS  # of Stokes, 1/s
OUTSIDE = sampler.errors.OUTSIDE

# floor, roof, two sides of each plate: x, y of an end, the normal into the gas, the length
WALLS = (
    (-9.0, 0.0, 0.0, 1.0, 18.0),
    (9.0, 0.1, 0.0, -1.0, 18.0),
    (0.1, 0.0, -0.8660254, 0.5, 0.07),
    (0.135, 0.06062178, 0.8660254, -0.5, 0.07),
    (0.235, 0.03937822, -0.8660254, -0.5, 0.07),
    (0.2, 0.1, 0.8660254, 0.5, 0.07),
)


@numba.njit(cache=True)
def wall_ahead(x, y, v):
    """Return the normal of the wall that the next step of a grain crosses, zeros for none."""
    normal = (0.0, 0.0, 0.0)
    for end_x, end_y, n_x, n_y, length in WALLS:
        away = n_x * (x - end_x) + n_y * (y - end_y)
        along = n_y * (x - end_x) - n_x * (y - end_y)
        approach = -(n_x * v[0] + n_y * v[1])
        if 0.0 <= away < DT * approach and 0.0 < along < length:
            normal = (n_x, n_y, 0.0)
    return normal


@numba.njit(cache=True)
def resting_speed(v, normal):
    """Return the normal speed below which a grain rests.

    The next hop would be lower than a hundredth of the diameter, since the gas presses the grain to
    the wall.
    """
    pressure = -(normal[0] * (GAS - v[0]) - normal[1] * v[1]) * DRAG  # acceleration to the wall
    return math.sqrt(2.0 * max(pressure, 0.0) * 0.01 * DIAMETER)


@numba.njit(cache=True)
def slow_down(omega, inertia, flight):
    """Return the spin that the torque of the gas leaves; one call for a whole flight is exact."""
    if inertia == 0.0:  # a grain that has met no wall does not spin
        return omega
    moment = inertia * MASS * HALF_SIZE**2
    return spin_after(omega, flight, moment, DIAMETER, DENSITY, VISCOSITY)


@numba.njit(cache=True)
def follow(table, grains):
    """Send grains through; return how many pass, and so on, as the last line prints."""
    share = 1.0 - math.exp(-DRAG * DT)
    passed = back = hits = outside = 0
    energy = spin = 0.0
    after = np.empty(7)
    for index in range(grains):
        x, y, v = 0.0, (index + 0.5) * 0.1 / grains, (GAS, 0.0, 0.0)
        omega, inertia, flight, hit = (0.0, 0.0, 0.0), 0.0, 0.0, 0
        while 0.0 <= x < 0.5:
            v = (v[0] + share * (GAS - v[0]), v[1] - share * v[1], v[2] - share * v[2])
            flight += DT  # since the last wall
            normal = wall_ahead(x, y, v)
            if normal == (0.0, 0.0, 0.0):
                x += DT * v[0]
                y += DT * v[1]
                continue
            if deposits(v, normal, resting_speed(v, normal)):
                break
            omega = slow_down(omega, inertia, flight)
            code = rebound(
                table,
                v,
                normal,
                HALF_SIZE,
                omega=omega,
                inertia=inertia,
                index=index,
                hit=hit,
                seed=7,
                out=after,
            )
            if code < 0:
                raise ValueError("a rebound has failed")
            outside += (code & OUTSIDE) != 0
            v = (after[0], after[1], after[2])
            omega = (after[3], after[4], after[5])
            inertia = after[6]
            hit += 1
            flight = 0.0
        omega = slow_down(omega, inertia, flight)
        passed += x >= 0.5
        back += x < 0.0
        hits += hit
        energy += v[0] ** 2 + v[1] ** 2 + v[2] ** 2
        spin += omega[2]
    return passed, back, hits, energy, spin, outside


table = sampler.load("corundum-steel")
print(*follow(table.handle, 2000))
