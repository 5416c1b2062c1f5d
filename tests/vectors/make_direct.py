"""Known answers of direct simulation: some rebounds of the shipped pair, to the last bit.

    python tests/vectors/make_direct.py

writes direct.txt, with angular velocities at departure, and direct-coulomb.txt, under Coulomb
friction and with mean ones, beside itself, one particle a line, numbers as hexadecimal floating
point:

    ALPHA_DEG SPEED SPIN*3 INERTIA INDEX COLLISIONS STATE*6 INERTIA_AFTER

The model is compared with an independent one in tests/reference; run this again only when the model
is meant to change.
"""

from pathlib import Path

import numpy as np

from tablegen.config.config import load_config
from tablegen.simulation.simulate import simulate

FOLDER = Path(__file__).parent

_COULOMB = {"law": "coulomb", "static": 0.4, "dynamic": 0.3, "source": "an example"}

#: Changes of the shipped pair's configuration, and which angular velocities, by file.
PAIRS = {
    "direct.txt": ({}, "departure"),
    "direct-coulomb.txt": ({"pair": {"resistance": _COULOMB}}, "mean"),
}
CONDITIONS = (
    (0.5, 300.0, (0.0, 0.0, 0.0), 0.0),
    (20.0, 50.0, (0.0, 0.0, 0.0), 0.0),
    (46.96, 258.0, (0.0, 0.0, 0.0), 0.0),
    (46.96, 258.0, (1.0, -2.0, 3.0), 0.0),
    (46.96, 258.0, (1.0, -2.0, 3.0), 0.3),
    (0.05, 100.0, (0.02, 0.3, -0.4), 2.0),
    (90.0, 200.0, (0.0, 0.0, 0.0), 0.0),
    (90.0, 200.0, (0.0, 0.5, 20.0), 0.0),
)
COUNT, SEED = 20, 7


def simulated(name, alpha_deg, speed, spin, inertia):
    changes, omega = PAIRS[name]
    config, alpha1 = load_config("corundum-steel").with_changes(changes), np.radians(alpha_deg)
    return simulate(
        config, alpha1, speed, COUNT, seed=SEED, spin=spin, inertia=inertia, omega=omega
    )


def lines(name):
    for alpha_deg, speed, spin, inertia in CONDITIONS:
        simulation = simulated(name, alpha_deg, speed, spin, inertia)
        given = " ".join(float(x).hex() for x in (alpha_deg, speed, *spin, inertia))
        for index in range(COUNT):
            after = *simulation.state[index], simulation.inertia[index]
            numbers = " ".join(float(x).hex() for x in after)
            yield f"{given} {index} {simulation.collisions[index]} {numbers}\n"


if __name__ == "__main__":
    for file in PAIRS:
        (FOLDER / file).write_text("".join(lines(file)), encoding="ascii")
