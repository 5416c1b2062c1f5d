"""Numba particle loop with spin on all processors: gas carries particles from plate to plate.

    python docs/examples/particles.py corundum-steel 100000 20 --roughness 0.05

``sampler/c/particles.c`` and ``sampler/fortran/particles.f90`` do the same, with the same digest.
"""

import argparse
import sys
import time

import numba
import numpy as np

import sampler
from sampler import rough_rebound

SEED, HALF_SIZE = 7, 20e-6
AT_REST = (0.0, 0.0, 0.0)


@numba.njit
def bounce(table, has_spin, velocity, normal, roughness, particle, hit, out):
    """Rebound one particle whose spin is in out[3:]; return the status."""
    v = (velocity[0], velocity[1], velocity[2])
    impact = (v, normal, HALF_SIZE, AT_REST, roughness)
    if has_spin is None:  # a table without a spin law: numba compiles this branch alone
        return rough_rebound(table, *impact, SEED, particle, hit, out)
    omega = (out[3], out[4], out[5])
    return rough_rebound(table, *impact, SEED, particle, hit, out, omega)


@numba.njit(parallel=True)
def follow(table, has_spin, roughness, hits, velocity, omega, digests):
    """Send each particle through its hits; return the numbers of failed and clamped ones."""
    failed, clamped = 0, 0
    for k in numba.prange(len(velocity)):
        out = np.zeros(6)  # velocity and angular velocity after the last wall
        digest = np.uint64(0)
        for met in range(hits):
            side = 1.0 if met % 2 == 0 else -1.0  # lower and upper plate take turns
            plate = (0.0, side, 0.0)
            status = bounce(table, has_spin, velocity[k], plate, roughness, k, met, out)
            if status < sampler.OK:
                failed += 1
                break
            clamped += status & sampler.CLAMPED
            velocity[k], omega[k] = out[:3], out[3:]
            for bits in out.view(np.uint64):
                digest ^= bits
            # on the way to the other plate drag removes 0.8 of the slip
            gas = (150.0, 80.0 * side, 0.0)
            for axis in range(3):
                velocity[k, axis] += 0.8 * (gas[axis] - velocity[k, axis])
        digests[k] = digest
    return failed, clamped


def start(particles):
    """Return velocities and spins of particles before their first wall."""
    velocity = np.tile([150.0, -80.0, 0.0], (particles, 1))
    return velocity, np.zeros_like(velocity)


def run(table, particles, hits, roughness):
    """Return velocities and spins after all walls, the digest, and (failed, clamped)."""
    velocity, omega = start(particles)
    digests = np.zeros(particles, dtype=np.uint64)
    has_spin = True if table.has_spin else None
    counts = follow(table.handle, has_spin, roughness, hits, velocity, omega, digests)
    return velocity, omega, int(np.bitwise_xor.reduce(digests)), counts


def main(arguments=None):
    """Run the loop and print a summary; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("table", help="name of a table, or path of a .h5 file")
    parser.add_argument("particles", type=int)
    parser.add_argument("hits", type=int, help="walls that each particle hits")
    parser.add_argument("--roughness", type=float, default=0.0, help="of the plates, rad")
    args = parser.parse_args(arguments)
    table = sampler.load(args.table)
    run(table, 1, 1, args.roughness)  # compiles
    begin = time.perf_counter()
    velocity, omega, digest, (failed, clamped) = run(
        table, args.particles, args.hits, args.roughness
    )
    rate = args.particles * args.hits / (time.perf_counter() - begin)
    print(
        f"mean velocity along the plates {velocity[:, 0].mean():.3f} m/s, "
        f"mean spin {omega[:, 2].mean():.4g} rad/s, failed {failed}, clamped {clamped}"
    )
    print(f"{rate:.3g} rebounds per second on {numba.get_num_threads()} threads")
    print(f"digest {digest:016X}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
