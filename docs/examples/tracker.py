"""Follow grains of corundum, in air of 100 m/s, through a channel with two plates.

The gas exerts a drag and a torque on them. A grain keeps its index, the number of walls that it has
met, its spin, and the inertia about its spin. All quantities are in SI units.

The drag is that of Schiller & Naumann (Z. VDI 77 (1933) 318) on spheres of equal volume. It holds
up to a Reynolds number of 800; the slip of these grains gives up to 570. `cyclone.py` has a drag
for grains of any sphericity.
"""

import numpy as np

import sampler

N_GRAINS = 2000
SEED = 7
TIME_STEP = 2e-5
CHANNEL_LENGTH = 0.5
CHANNEL_HEIGHT = 0.1

GAS_VELOCITY = np.array([100.0, 0.0, 0.0])
GAS_DENSITY = 1.2
VISCOSITY = 1.8e-5

DIAMETER = 60e-6  # of the sphere of equal volume
MASS = 4.5e-10
STOKES_RATE = 3.0 * np.pi * VISCOSITY * DIAMETER / MASS  # of the drag at small slip

# x, y of one end; x, y of the normal into the gas; length
WALLS = [
    (-9.0, 0.0, 0.0, 1.0, 18.0),  # floor
    (9.0, 0.1, 0.0, -1.0, 18.0),  # roof
    (0.1, 0.0, -0.8660254, 0.5, 0.07),  # plate on the floor: front
    (0.135, 0.06062178, 0.8660254, -0.5, 0.07),  # back
    (0.235, 0.03937822, -0.8660254, -0.5, 0.07),  # plate on the roof: front
    (0.2, 0.1, 0.8660254, 0.5, 0.07),  # back
]


def find_walls_ahead(x, v):
    """Return the normals of the walls that the next step of grains crosses, zeros for none."""
    normals = np.zeros_like(v)
    for end_x, end_y, normal_x, normal_y, length in WALLS:
        from_end_x = x[:, 0] - end_x
        from_end_y = x[:, 1] - end_y
        distance = normal_x * from_end_x + normal_y * from_end_y
        along = normal_y * from_end_x - normal_x * from_end_y
        approach = -(normal_x * v[:, 0] + normal_y * v[:, 1])
        crosses = (distance >= 0.0) & (distance < TIME_STEP * approach)
        crosses &= (along > 0.0) & (along < length)
        normals[crosses] = normal_x, normal_y, 0.0
    return normals


def find_drag_rates(v):
    """Return the rates at which the drag takes the slip of grains, 1/s."""
    reynolds = GAS_DENSITY * DIAMETER / VISCOSITY * np.linalg.norm(GAS_VELOCITY - v, axis=1)
    return STOKES_RATE * (1.0 + 0.15 * reynolds**0.687)


def find_resting_speeds(v, normals):
    """Return the normal speeds below which grains rest.

    Where the gas presses a grain to the wall, its next hop would be lower than a hundredth of its
    diameter.
    """
    slip = GAS_VELOCITY - v
    towards_wall = -find_drag_rates(v) * (normals * slip).sum(axis=1)  # acceleration
    return np.sqrt(2.0 * np.maximum(towards_wall, 0.0) * 0.01 * DIAMETER)


def slow_down_spins(omega, inertia, half_size, flight):
    """Return the spins that the torque of the gas leaves.

    One call for the whole flight since the last wall is exact.
    """
    after = omega.copy()
    spins = inertia > 0.0  # before its first wall a grain does not spin
    moment = inertia[spins] * MASS * half_size[spins] ** 2
    after[spins] = sampler.spin_after(
        omega[spins], flight[spins], moment, DIAMETER, GAS_DENSITY, VISCOSITY
    )
    return after


def follow(table, n):
    """Follow n grains until they leave the channel or rest on a wall.

    Returns
    -------
    passed, resting, hits : int
        How many grains pass, how many come to rest on a wall, and how many walls they meet.
    squared_velocity, spin : float
        Sums of v^2 and of omega_z over the grains at the ends of their paths.
    """
    grains = table.grains(SEED, np.arange(n))  # shape and aspect ratios
    half_size = sampler.half_size(table, DIAMETER, grains)  # a, the largest of each grain
    x = np.stack([np.zeros(n), (np.arange(n) + 0.5) * CHANNEL_HEIGHT / n], axis=1)
    v = np.tile(GAS_VELOCITY, (n, 1))
    omega = np.zeros((n, 3))  # mean angular velocity
    inertia = np.zeros(n)  # about it, over MASS half_size^2; 0 is not known
    flight = np.zeros(n)  # time since the last wall
    hit = np.zeros(n, dtype=int)  # number of walls that a grain has met
    flying = np.arange(n)  # indices of the grains in flight
    while flying.size:
        share = 1.0 - np.exp(-find_drag_rates(v[flying]) * TIME_STEP)  # of the slip
        v[flying] += share[:, np.newaxis] * (GAS_VELOCITY - v[flying])
        flight[flying] += TIME_STEP
        normals = find_walls_ahead(x[flying], v[flying])
        is_at_wall = normals.any(axis=1)
        free = flying[~is_at_wall]
        x[free] += TIME_STEP * v[free, :2]

        at_wall = flying[is_at_wall]
        normals = normals[is_at_wall]
        rests = sampler.deposits(v[at_wall], normals, find_resting_speeds(v[at_wall], normals))
        flying = flying[~np.isin(flying, at_wall[rests])]
        bounces = at_wall[~rests]
        omega[bounces] = slow_down_spins(
            omega[bounces], inertia[bounces], half_size[bounces], flight[bounces]
        )
        v[bounces], omega[bounces], inertia[bounces] = table.rebound(
            v[bounces],
            normals[~rests],
            half_size[bounces],
            omega=omega[bounces],
            inertia=inertia[bounces],
            seed=SEED,
            index=bounces,
            hit=hit[bounces],
        )
        hit[bounces] += 1
        flight[bounces] = 0.0
        flying = flying[(x[flying, 0] >= 0.0) & (x[flying, 0] < CHANNEL_LENGTH)]
    omega = slow_down_spins(omega, inertia, half_size, flight)
    passed = (x[:, 0] >= CHANNEL_LENGTH).sum()
    resting = ((x[:, 0] >= 0.0) & (x[:, 0] < CHANNEL_LENGTH)).sum()
    return passed, resting, hit.sum(), (v**2).sum(), omega[:, 2].sum()


if __name__ == "__main__":
    table = sampler.load("corundum-steel")
    passed, resting, hits, squared_velocity, spin = follow(table, N_GRAINS)
    print("grains that pass:     ", passed)
    print("grains that rest:     ", resting)
    print("hits of walls:        ", hits)
    print("sum of v^2, m2/s2:    ", squared_velocity)
    print("sum of omega_z, rad/s:", spin)
