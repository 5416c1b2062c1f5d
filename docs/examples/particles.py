"""A particle loop in numba on all processors: gas drives particles from plate to plate.

    python docs/examples/particles.py corundum-steel 100000 20 0.05

takes a table (a name or a file), the number of particles and of the walls that each hits, and the
roughness of the plates, rad; it does what sampler/c/particles.c does, with the same digest.
"""

import sys
import time
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray

import sampler
from sampler import rough_rebound

SEED, HALF_SIZE = 7, 20e-6
AT_REST = (0.0, 0.0, 0.0)


@numba.njit
def bounce(arrays, kept, velocity, normal, roughness, particle, hit, out):
    """Rebound one particle; return the status."""
    v = (velocity[0], velocity[1], velocity[2])
    impact = (v, normal, HALF_SIZE, AT_REST, roughness)
    # compiled for one of both: no spin is kept where the table has no law for it
    if kept is None:
        return rough_rebound(arrays, *impact, SEED, particle, hit, out)
    before = (out[3], out[4], out[5])
    return rough_rebound(arrays, *impact, SEED, particle, hit, out, before)


@numba.njit(parallel=True)
def follow(arrays, kept, roughness, hits, velocity, omega, digests):
    """Send particles through all their wall hits; return how many failed or were clamped."""
    failed, clamped = 0, 0
    for k in numba.prange(len(velocity)):
        out = np.zeros(6)
        digest = np.uint64(0)
        for met in range(hits):
            # lower and upper plate take turns
            side = 1.0 if met % 2 == 0 else -1.0
            plate = (0.0, side, 0.0)
            status = bounce(arrays, kept, velocity[k], plate, roughness, k, met, out)
            if status < sampler.OK:
                failed += 1
                break
            clamped += status
            velocity[k], omega[k] = out[:3], out[3:]
            for bits in out.view(np.uint64):
                digest ^= bits
            # on the way to the other plate drag makes up most of the difference from the gas
            gas = (150.0, 80.0 * side, 0.0)
            for axis in range(3):
                velocity[k, axis] += 0.8 * (gas[axis] - velocity[k, axis])
        digests[k] = digest
    return failed, clamped


def start(particles: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Velocities and spins of particles before their first wall."""
    velocity = np.tile([150.0, -80.0, 0.0], (particles, 1))
    return velocity, np.zeros_like(velocity)


def run(
    table: sampler.Table, particles: int, hits: int, roughness: float
) -> tuple[NDArray[np.float64], NDArray[np.float64], int, Any]:
    """Velocities and spins after all walls, the digest, and how many failed and were clamped."""
    velocity, omega = start(particles)
    digests = np.zeros(particles, dtype=np.uint64)
    kept = True if table.has_spin else None
    counts = follow(table.arrays, kept, roughness, hits, velocity, omega, digests)
    return velocity, omega, int(np.bitwise_xor.reduce(digests)), counts


def main() -> int:
    """Print what became of the particles."""
    if len(sys.argv) not in (4, 5):
        print("usage: particles.py TABLE PARTICLES HITS [ROUGHNESS]", file=sys.stderr)
        return 2
    table = sampler.load(sys.argv[1])
    particles, hits = int(sys.argv[2]), int(sys.argv[3])
    roughness = float(sys.argv[4]) if len(sys.argv) == 5 else 0.0
    run(table, 1, 1, roughness)  # compiles
    begin = time.perf_counter()
    velocity, omega, digest, (failed, clamped) = run(table, particles, hits, roughness)
    seconds = time.perf_counter() - begin
    along, spin = velocity[:, 0].mean(), omega[:, 2].mean()
    print(
        f"mean velocity along the plates {along:.3f} m/s, mean spin {spin:.4g} rad/s, "
        f"failed {failed}"
    )
    rate = particles * hits / seconds
    print(f"{rate:.3g} rebounds per second on {numba.get_num_threads()} threads")
    print(f"digest {digest:016X}")
    if clamped:
        print(f"{clamped} rebounds lay outside the table and took its nearest condition")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
