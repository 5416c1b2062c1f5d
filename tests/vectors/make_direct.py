"""Known answers of direct simulation: some rebounds of the shipped pair, to the last bit.

    python tests/vectors/make_direct.py

writes direct.txt, with angular velocities of an instant, and direct-coulomb.txt, under Coulomb
friction and with mean ones, beside itself, one particle a line, numbers as hexadecimal floating
point:

    ALPHA_DEG SPEED SPIN*3 INDEX COLLISIONS STATE*6

The model is compared with an independent one in tests/reference; run this again only when the model
is meant to change.
"""

from pathlib import Path

import numpy as np

from tablegen.config.config import load_config
from tablegen.simulation.simulate import simulate

FOLDER = Path(__file__).parent

#: Changes of the shipped pair's configuration, by file.
PAIRS = {
    "direct.txt": {"domain": {"omega": "departure"}},
    "direct-coulomb.txt": {
        "pair": {
            "resistance": {"law": "coulomb", "static": 0.4, "dynamic": 0.3, "source": "an example"}
        }
    },
}
CONDITIONS = (
    (0.5, 300.0, (0.0, 0.0, 0.0)),
    (20.0, 50.0, (0.0, 0.0, 0.0)),
    (46.96, 258.0, (0.0, 0.0, 0.0)),
    (46.96, 258.0, (1.0, -2.0, 3.0)),
    (90.0, 200.0, (0.0, 0.0, 0.0)),
    (90.0, 200.0, (0.0, 0.5, 20.0)),
)
COUNT, SEED = 20, 7


def simulated(name, alpha_deg, speed, spin):
    config = load_config("corundum-steel").with_changes(PAIRS[name])
    return simulate(config, np.radians(alpha_deg), speed, COUNT, seed=SEED, spin=spin)


def lines(name):
    for alpha_deg, speed, spin in CONDITIONS:
        made = simulated(name, alpha_deg, speed, spin)
        given = " ".join(float(x).hex() for x in (alpha_deg, speed, *spin))
        for index, (state, collisions) in enumerate(zip(made.state, made.collisions, strict=True)):
            numbers = " ".join(float(x).hex() for x in state)
            yield f"{given} {index} {collisions} {numbers}\n"


if __name__ == "__main__":
    for file in PAIRS:
        (FOLDER / file).write_text("".join(lines(file)), encoding="ascii")
