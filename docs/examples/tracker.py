"""Grains of corundum in a channel with two plates.

A grain keeps its number, the number of walls that it has met, its spin, and the inertia about it.
"""

import numpy as np

import sampler

# SI units: time step, gas, diameter, mass and largest half-size of a grain
DT, GAS, DENSITY, VISCOSITY = 2e-5, np.array([100.0, 0.0, 0.0]), 1.2, 1.8e-5
DIAMETER, MASS, HALF_SIZE = 60e-6, 4.5e-10, 0.63 * 60e-6
DRAG = 9.42477796 * VISCOSITY * DIAMETER / MASS  # of Stokes, 1/s

# floor, roof, two sides of each plate: x, y of an end, the normal into the gas, the length
WALLS = [
    (-9.0, 0.0, 0.0, 1.0, 18.0),
    (9.0, 0.1, 0.0, -1.0, 18.0),
    (0.1, 0.0, -0.8660254, 0.5, 0.07),
    (0.135, 0.06062178, 0.8660254, -0.5, 0.07),
    (0.235, 0.03937822, -0.8660254, -0.5, 0.07),
    (0.2, 0.1, 0.8660254, 0.5, 0.07),
]


def walls_ahead(x, v):
    """Return normals of the walls that the next step of grains crosses, zeros where none."""
    normal = np.zeros_like(v)
    for end_x, end_y, n_x, n_y, length in WALLS:
        from_x, from_y = x[:, 0] - end_x, x[:, 1] - end_y
        away = n_x * from_x + n_y * from_y
        along = n_y * from_x - n_x * from_y
        approach = -(n_x * v[:, 0] + n_y * v[:, 1])
        near = (away >= 0.0) & (away < DT * approach) & (along > 0.0) & (along < length)
        normal[near] = n_x, n_y, 0.0
    return normal


def resting_speeds(v, normal):
    """Return the normal speeds below which grains rest.

    The next hop would be lower than a hundredth of the diameter, since the gas presses the grain to
    the wall.
    """
    pressure = -(normal * (GAS - v)).sum(axis=1) * DRAG  # acceleration towards the wall
    return np.sqrt(2.0 * np.maximum(pressure, 0.0) * 0.01 * DIAMETER)


def slow_down(omega, inertia, flight):
    """Return the spins that the torque of the gas leaves; one call for a whole flight is exact."""
    moment = inertia * MASS * HALF_SIZE**2
    spins = inertia > 0.0  # a grain that has met no wall does not spin
    after = omega.copy()
    gas = DIAMETER, DENSITY, VISCOSITY
    after[spins] = sampler.spin_after(omega[spins], flight[spins], moment[spins], *gas)
    return after


def follow(table, n):
    """Send n grains through.

    Returns how many pass, how many come back, how many walls they meet, and at the end of their
    paths the sums of their squared velocities and of their spins.
    """
    x = np.stack([np.zeros(n), (np.arange(n) + 0.5) * 0.1 / n], axis=1)
    v = np.tile(GAS, (n, 1))
    omega, inertia = np.zeros((n, 3)), np.zeros(n)
    flight = np.zeros(n)  # time since the last wall
    hit = np.zeros(n, dtype=int)
    flying = np.arange(n)  # numbers of the grains in flight
    while flying.size:
        v[flying] += (1.0 - np.exp(-DRAG * DT)) * (GAS - v[flying])
        flight[flying] += DT
        normal = walls_ahead(x[flying], v[flying])
        at_wall = normal.any(axis=1)
        x[flying[~at_wall]] += DT * v[flying[~at_wall], :2]

        met, normal = flying[at_wall], normal[at_wall]
        rests = sampler.deposits(v[met], normal, resting_speeds(v[met], normal))
        flying = flying[~np.isin(flying, met[rests])]
        met, normal = met[~rests], normal[~rests]
        omega[met] = slow_down(omega[met], inertia[met], flight[met])
        v[met], omega[met], inertia[met] = table.rebound(
            v[met],
            normal,
            HALF_SIZE,
            omega=omega[met],
            inertia=inertia[met],
            seed=7,
            index=met,
            hit=hit[met],
        )
        hit[met] += 1
        flight[met] = 0.0
        flying = flying[(x[flying, 0] >= 0.0) & (x[flying, 0] < 0.5)]
    omega = slow_down(omega, inertia, flight)
    passed, back = (x[:, 0] >= 0.5).sum(), (x[:, 0] < 0.0).sum()
    return passed, back, hit.sum(), (v**2).sum(), omega[:, 2].sum()


if __name__ == "__main__":
    print(*follow(sampler.load("corundum-steel"), 2000))
