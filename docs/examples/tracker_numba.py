"""Grains of corundum in a channel with two plates: each keeps its number, hits and spin."""

import numba
import numpy as np

import sampler
from sampler.numba import rebound, spin_after

DT, GAS, RHO, MU, D, M, NONE = 2e-5, 100.0, 1.2, 1.8e-5, 60e-6, 4.5e-10, (0.0, 0.0, 0.0)  # SI units
A = 0.63 * D
# floor, roof, two sides of each plate: x, y of an end, the normal into the gas, the length
CHANNEL = (-9.0, 0.0, 0.0, 1.0, 18.0), (9.0, 0.1, 0.0, -1.0, 18.0)
PLATE = (0.1, 0.0, -0.8660254, 0.5, 0.07), (0.135, 0.06062178, 0.8660254, -0.5, 0.07)
HUNG = (0.235, 0.03937822, -0.8660254, -0.5, 0.07), (0.2, 0.1, 0.8660254, 0.5, 0.07)


@numba.njit(cache=True)
def follow(table, grains):
    ends, to, share = np.zeros(6), np.zeros(7), 1.0 - np.exp(-3.0 * np.pi * MU * D * DT / M)
    for k in range(grains):
        (x, y), v, omega, hit, into = (0.0, (k + 0.5) * 0.1 / grains), (GAS, 0.0, 0.0), NONE, 0, 0.0
        inertia, time = 0.4, 0.0  # that of a grain at rest has no effect
        while 0.0 <= x < 0.5 and not 0.0 < into < 1.0:  # m/s: slow grains rest, instead of hops
            v = v[0] + share * (GAS - v[0]), v[1] - share * v[1], v[2] - share * v[2]
            n, into, time = NONE, 0.0, time + DT  # since the last wall
            for a, b, p, q, length in CHANNEL + PLATE + HUNG:  # does the next step cross one?
                away, along = (x - a) * p + (y - b) * q, (x - a) * q - (y - b) * p
                if 0.0 <= away < -DT * (v[0] * p + v[1] * q) and 0.0 < along < length:
                    n, into = (p, q, 0.0), -v[0] * p - v[1] * q
            if into == 0.0:
                x, y = x + DT * v[0], y + DT * v[1]
            elif into >= 1.0:
                omega = spin_after(omega, time, inertia * M * A**2, D, RHO, MU)  # once a flight
                code = rebound(
                    table, v, n, A, omega=omega, inertia=inertia, index=k, hit=hit, seed=7, out=to
                )
                assert code >= 0
                v, omega, inertia = (to[0], to[1], to[2]), (to[3], to[4], to[5]), to[6]
                hit, time = hit + 1, 0.0
                ends[5] += code > 0  # outside the table, or of the measured speeds
        ends += np.array([x >= 0.5, x < 0.0, hit, v[0] ** 2 + v[1] ** 2 + v[2] ** 2, omega[2], 0.0])
    return ends


table = sampler.load("corundum-steel")
print(*follow(table.handle, 2000))
