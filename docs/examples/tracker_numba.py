"""Follow grains of corundum through a channel with two plates, in compiled code.

The gas exerts a drag and a torque on them. A grain keeps its index, the number of walls that it has
met, its spin, and the inertia about its spin. All quantities are in SI units.

The drag is that of Schiller & Naumann (Z. VDI 77 (1933) 318) on spheres of equal volume. It holds
up to a Reynolds number of 800; the slip of these grains gives up to 570. `cyclone.py` has a drag
for grains of any sphericity.
"""

import math

import numba
import numpy as np

import sampler
from sampler.numba import deposits, grain, half_size, rebound, spin_after

N_GRAINS = 2000
SEED = 7
TIME_STEP = 2e-5
CHANNEL_LENGTH = 0.5
CHANNEL_HEIGHT = 0.1

GAS_SPEED = 100.0  # along x
GAS_DENSITY = 1.2
VISCOSITY = 1.8e-5

DIAMETER = 60e-6  # of the sphere of equal volume
MASS = 4.5e-10
STOKES_RATE = 3.0 * math.pi * VISCOSITY * DIAMETER / MASS  # of the drag at small slip

OUTSIDE = sampler.errors.OUTSIDE  # flags of impacts outside the table

# x, y of one end; x, y of the normal into the gas; length
WALLS = (
    (-9.0, 0.0, 0.0, 1.0, 18.0),  # floor
    (9.0, 0.1, 0.0, -1.0, 18.0),  # roof
    (0.1, 0.0, -0.8660254, 0.5, 0.07),  # plate on the floor: front
    (0.135, 0.06062178, 0.8660254, -0.5, 0.07),  # back
    (0.235, 0.03937822, -0.8660254, -0.5, 0.07),  # plate on the roof: front
    (0.2, 0.1, 0.8660254, 0.5, 0.07),  # back
)


@numba.njit(cache=True)
def find_wall_ahead(x, y, v):
    """Return the normal of the wall that the next step of a grain crosses, zeros for none."""
    normal = (0.0, 0.0, 0.0)
    for end_x, end_y, normal_x, normal_y, length in WALLS:
        distance = normal_x * (x - end_x) + normal_y * (y - end_y)
        along = normal_y * (x - end_x) - normal_x * (y - end_y)
        approach = -(normal_x * v[0] + normal_y * v[1])
        if 0.0 <= distance < TIME_STEP * approach and 0.0 < along < length:
            normal = (normal_x, normal_y, 0.0)
    return normal


@numba.njit(cache=True)
def find_drag_rate(v):
    """Return the rate at which the drag takes the slip of a grain, 1/s."""
    slip = math.sqrt((GAS_SPEED - v[0]) ** 2 + v[1] ** 2 + v[2] ** 2)
    reynolds = GAS_DENSITY * DIAMETER / VISCOSITY * slip
    return STOKES_RATE * (1.0 + 0.15 * reynolds**0.687)


@numba.njit(cache=True)
def find_resting_speed(v, normal):
    """Return the normal speed below which a grain rests.

    Where the gas presses the grain to the wall, its next hop would be lower than a hundredth of its
    diameter.
    """
    slip = normal[0] * (GAS_SPEED - v[0]) - normal[1] * v[1]
    towards_wall = -find_drag_rate(v) * slip  # acceleration
    return math.sqrt(2.0 * max(towards_wall, 0.0) * 0.01 * DIAMETER)


@numba.njit(cache=True)
def slow_down_spin(omega, inertia, half, flight):
    """Return the spin that the torque of the gas leaves.

    One call for the whole flight since the last wall is exact.
    """
    if inertia == 0.0:  # before its first wall the grain does not spin
        return omega
    moment = inertia * MASS * half**2
    return spin_after(omega, flight, moment, DIAMETER, GAS_DENSITY, VISCOSITY)


@numba.njit(cache=True)
def follow(table, n_grains):
    """Follow grains until they leave the channel or rest on a wall; return what is printed."""
    passed = resting = hits = outside = 0
    squared_velocity = spin = 0.0
    after = np.empty(7)  # velocity, mean angular velocity, inertia about it
    for index in range(n_grains):
        half = half_size(table, DIAMETER, grain(table, SEED, index))  # a, the largest
        x = 0.0
        y = (index + 0.5) * CHANNEL_HEIGHT / n_grains
        v = (GAS_SPEED, 0.0, 0.0)
        omega = (0.0, 0.0, 0.0)  # mean angular velocity
        inertia = 0.0  # about it, over MASS half^2; 0 is not known
        flight = 0.0  # time since the last wall
        hit = 0  # number of walls that the grain has met
        while 0.0 <= x < CHANNEL_LENGTH:
            share = 1.0 - math.exp(-find_drag_rate(v) * TIME_STEP)  # of the slip
            v = (v[0] + share * (GAS_SPEED - v[0]), v[1] - share * v[1], v[2] - share * v[2])
            flight += TIME_STEP
            normal = find_wall_ahead(x, y, v)
            if normal == (0.0, 0.0, 0.0):
                x += TIME_STEP * v[0]
                y += TIME_STEP * v[1]
                continue
            if deposits(v, normal, find_resting_speed(v, normal)):
                break
            omega = slow_down_spin(omega, inertia, half, flight)
            code = rebound(
                table,
                v,
                normal,
                half,
                omega=omega,
                inertia=inertia,
                index=index,
                hit=hit,
                seed=SEED,
                out=after,
            )
            if code < 0:
                raise ValueError("a rebound has failed")
            if code & OUTSIDE:
                outside += 1
            v = (after[0], after[1], after[2])
            omega = (after[3], after[4], after[5])
            inertia = after[6]
            hit += 1
            flight = 0.0
        omega = slow_down_spin(omega, inertia, half, flight)
        passed += x >= CHANNEL_LENGTH
        resting += 0.0 <= x < CHANNEL_LENGTH
        hits += hit
        squared_velocity += v[0] ** 2 + v[1] ** 2 + v[2] ** 2
        spin += omega[2]
    return passed, resting, hits, squared_velocity, spin, outside


if __name__ == "__main__":
    table = sampler.load("corundum-steel")
    results = follow(table.handle, N_GRAINS)
    print("grains that pass:     ", results[0])
    print("grains that rest:     ", results[1])
    print("hits of walls:        ", results[2])
    print("sum of v^2, m2/s2:    ", results[3])
    print("sum of omega_z, rad/s:", results[4])
    print("outside the table:    ", results[5])
