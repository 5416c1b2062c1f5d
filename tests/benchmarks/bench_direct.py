"""Direct rebounds a second: particles with a condition each, and condition by condition.

    python tests/benchmarks/bench_direct.py

The particles have random angles (2 to 90 degrees) and speeds (20 to 250 m/s), and spins of some
V/a or none. One call simulates all of them, mixed, or one call simulates each condition; the states
are the same. The lab frame is timed too. Times are processor time of one thread, the least of
several rounds.
"""

import argparse
from collections.abc import Callable

from harness import in_turns  # isort: skip
import numpy as np

from tablegen.config.config import load_config
from tablegen.simulation.direct import DirectModel

#: Half-size of the particles [m].
HALF_SIZE = 1e-5


def ways(conditions: int, particles: int, spinning: bool) -> dict[str, Callable[[], object]]:
    """Functions that rebound the same particles, each in another way."""
    model = DirectModel(load_config("corundum-steel"))
    rng = np.random.default_rng(1)
    alpha = np.radians(rng.uniform(2.0, 90.0, conditions))
    speed = rng.uniform(20.0, 250.0, conditions)
    spin = rng.normal(0.0, 0.7 * spinning, (conditions, 3))
    index = rng.permutation(conditions * particles)
    which = index // particles
    a, v, s = alpha[which], speed[which], spin[which]
    velocity = v[:, None] * np.column_stack([np.cos(a), -np.sin(a), np.zeros(len(a))])
    omega = s * (v / HALF_SIZE)[:, None]
    keys = {"seed": 1, "hit": 0, "threads": 1}

    def apart() -> None:
        for k in range(conditions):
            own = np.arange(k * particles, (k + 1) * particles)
            model.sample(alpha[k], speed[k], spin=spin[k], index=own, **keys)

    def lab() -> None:
        model.rebound(velocity, [0.0, 1.0, 0.0], HALF_SIZE, omega=omega, index=index, **keys)

    return {
        "one condition a call": apart,
        "mixed, wall frame": lambda: model.sample(a, v, spin=s, index=index, **keys),
        "mixed, lab frame": lab,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--conditions", type=int, default=64)
    parser.add_argument("--particles", type=int, default=4000, help="for each condition")
    parser.add_argument("--rounds", type=int, default=7)
    options = parser.parse_args()
    for spinning in (False, True):
        timed = ways(options.conditions, options.particles, spinning)
        for name, times in in_turns(timed, options.rounds).items():
            cost = 1e6 * min(times) / (options.conditions * options.particles)
            spin = "with spin" if spinning else "without spin"
            print(f"{spin:13} {name:20} {cost:6.2f} us  {1.0 / cost:5.2f} million a second")


if __name__ == "__main__":
    main()
