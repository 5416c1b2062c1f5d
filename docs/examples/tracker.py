"""Grains of corundum in a channel with two plates: each keeps its number, hits and spin."""

import numpy as np

import sampler

# SI units: time step, gas, diameter and mass of a grain
DT, GAS, RHO, MU, D, M = 2e-5, np.array([100.0, 0.0, 0.0]), 1.2, 1.8e-5, 60e-6, 4.5e-10
# floor, roof, two sides of each plate: x, y of an end, the normal into the gas, the length
WALLS = [(-9, 0, 0, 1, 18), (9, 0.1, 0, -1, 18), (0.1, 0, -0.8660254, 0.5, 0.07)]
WALLS += [(0.135, 0.06062178, 0.8660254, -0.5, 0.07)]
WALLS += [(0.235, 0.03937822, -0.8660254, -0.5, 0.07), (0.2, 0.1, 0.8660254, 0.5, 0.07)]


def follow(table, n):
    """Send n grains through; return their places, velocities, spins and numbers of hits."""
    share, half = 1.0 - np.exp(-3.0 * np.pi * MU * D * DT / M), 0.63 * D
    x = np.stack([np.zeros(n), (np.arange(n) + 0.5) * 0.1 / n], axis=1)
    v, omega, hit, k = np.tile(GAS, (n, 1)), np.zeros((n, 3)), np.zeros(n, int), np.arange(n)
    inertia, time = np.full(n, 0.4), np.zeros(n)  # that of a grain at rest has no effect
    while k.size:  # the grains in flight
        v[k] += share * (GAS - v[k])
        time[k] += DT  # since the last wall
        normal = np.zeros((k.size, 3))  # of a wall that the next step crosses
        for a, b, p, q, length in WALLS:
            away, along = (x[k] - (a, b)) @ (p, q), (x[k] - (a, b)) @ (q, -p)
            near = (away >= 0) & (away < -DT * (v[k, :2] @ (p, q))) & (along > 0) & (along < length)
            normal[near] = p, q, 0.0
        into, free = -(normal * v[k]).sum(axis=1), ~normal.any(axis=1)
        met, n_met = k[into > 1.0], normal[into > 1.0]  # m/s: slower ones rest, instead of hops
        given = {"seed": 7, "index": met, "hit": hit[met], "inertia": inertia[met]}
        moment = inertia[met] * M * half**2  # of the torque of the gas, once a flight
        given["omega"] = sampler.spin_after(omega[met], time[met], moment, D, RHO, MU)
        v[met], omega[met], inertia[met] = table.rebound(v[met], n_met, half, **given)
        hit[met], time[met] = hit[met] + 1, 0.0
        x[k[free]] += DT * v[k[free], :2]
        k = k[(free | (into > 1.0)) & (x[k, 0] >= 0.0) & (x[k, 0] < 0.5)]
    return (x[:, 0] >= 0.5).sum(), (x[:, 0] < 0.0).sum(), hit.sum(), (v**2).sum(), omega[:, 2].sum()


if __name__ == "__main__":
    print(*follow(sampler.load("corundum-steel"), 2000))
