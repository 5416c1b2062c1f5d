"""Direct rebounds a second: particles with a condition each, and condition by condition.

    python tests/benchmarks/bench_direct.py

The particles have random angles (2 to 90 degrees) and speeds (20 to 250 m/s), and spins of some
V/a or none. One call simulates all of them, mixed; or there is a call for each condition. The
states are the same, which is checked. The lab frame is timed too, by arrays and one by one in
compiled code. The four take turns; times are processor time of one thread, the least of several
rounds.
"""

import argparse
import time
from collections.abc import Callable

import checkout  # noqa: F401  (before the imports that it makes possible)
import numba
import numpy as np

import tablegen
from tablegen.config.config import load_config
from tablegen.simulation.direct import DirectModel

#: Size of the particles, m.
_HALF_SIZE = 1e-5


class Impacts:
    """Random conditions, and particles that have one of them each, in random order."""

    def __init__(self, conditions: int, particles: int, spinning: bool) -> None:
        rng = np.random.default_rng(1)
        self.alpha = np.radians(rng.uniform(2.0, 90.0, conditions))
        self.speed = rng.uniform(20.0, 250.0, conditions)
        self.spin = rng.normal(0.0, 0.7 * spinning, (conditions, 3))
        self.index = rng.permutation(conditions * particles)
        self.which = self.index // particles
        self.particles = particles


@numba.njit
def one_by_one(arrays, velocity, omega, index, work, after):
    """Rebound the particles as a user's tracker does."""
    still, up = (0.0, 0.0, 0.0), (0.0, 1.0, 0.0)
    for k in range(len(velocity)):
        v = velocity[k, 0], velocity[k, 1], velocity[k, 2]
        w = omega[k, 0], omega[k, 1], omega[k, 2]
        grain = tablegen.grain(arrays, 1, index[k], 0)
        tablegen.rebound(arrays, v, up, _HALF_SIZE, still, w, grain, 1, index[k], 0, work, after[k])


def timers(model: DirectModel, impacts: Impacts) -> dict[str, Callable[[], np.ndarray]]:
    """What is timed: a function that returns the states of all particles by index, for each way."""
    alpha, speed, spin = impacts.alpha, impacts.speed, impacts.spin
    which, size = impacts.which, impacts.particles
    states = np.empty((len(which), 6))
    v, w = alpha[which], speed[which]
    velocity = w[:, None] * np.column_stack([np.cos(v), -np.sin(v), np.zeros(len(v))])
    omega = spin[which] * (w / _HALF_SIZE)[:, None]
    keys = {"seed": 1, "threads": 1}

    def apart() -> np.ndarray:
        for k in range(len(alpha)):
            rows = slice(k * size, (k + 1) * size)
            index = np.arange(rows.start, rows.stop)
            states[rows] = model.sample(alpha[k], speed[k], spin=spin[k], index=index, **keys)
        return states

    def mixed() -> np.ndarray:
        drawn = model.sample(v, w, spin=spin[which], index=impacts.index, **keys)
        states[impacts.index] = drawn
        return states

    def lab() -> np.ndarray:
        up = [0.0, 1.0, 0.0]
        after = model.rebound(velocity, up, _HALF_SIZE, omega=omega, index=impacts.index, **keys)
        states[impacts.index, :3] = after.velocity
        return states

    work = np.empty(model.work_size)

    def compiled() -> np.ndarray:
        after = np.empty((len(v), 6))
        one_by_one(model.arrays, velocity, omega, impacts.index, work, after)
        states[impacts.index] = after
        return states

    return {
        "one condition a call": apart,
        "mixed, wall frame": mixed,
        "mixed, lab frame": lab,
        "one by one, lab frame": compiled,
    }


def measure(impacts: Impacts, rounds: int) -> dict[str, float]:
    """Least time [us] of a rebound, in each way."""
    ways = timers(DirectModel(load_config("corundum-steel")), impacts)
    first, second, third, fourth = (way().copy() for way in ways.values())
    same = np.array_equal(first, second) and np.array_equal(third[:, :3], fourth[:, :3])
    if not same:
        raise AssertionError("a particle's rebound depends on the others of its call")
    best = dict.fromkeys(ways, np.inf)
    for _ in range(rounds):
        for name, way in ways.items():
            start = time.process_time()
            way()
            best[name] = min(best[name], time.process_time() - start)
    return {name: 1e6 * seconds / len(impacts.index) for name, seconds in best.items()}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--conditions", type=int, default=64)
    parser.add_argument("--particles", type=int, default=4000, help="for each condition")
    parser.add_argument("--rounds", type=int, default=7)
    arguments = parser.parse_args()
    for spinning in (False, True):
        impacts = Impacts(arguments.conditions, arguments.particles, spinning)
        for name, cost in measure(impacts, arguments.rounds).items():
            spin = "with spin" if spinning else "without spin"
            print(f"{spin:13} {name:21} {cost:6.2f} us  {1.0 / cost:5.2f} million a second")


if __name__ == "__main__":
    main()
