"""Chance and bias of difference quotients, by step: tablegen/measured/EXPERIMENTS.md."""

import numpy as np

from tablegen.config.config import load_config
from tablegen.measured.parameters import make_parameters
from tablegen.measured.trials import Evaluations, TrialPairs

START = load_config("start-tabulated")
LAWS = ("pair.restitution.value", "pair.resistance.value")
MEAN = "population.aspect.mean"


def steps(count=500, seeds=20, sizes=(0.0003, 0.003, 0.03, 0.1)):
    """Print chance and bias of central difference quotients, over the size of the quotients.

    Steps are parts of the width of the search. The bias is that against the largest step but one.
    """
    config = START.with_changes({"population": {"shapes": {"sphere": 0.0}}})
    trials = TrialPairs(config, make_parameters(config, (*LAWS, MEAN)), 0.0)
    space, angles = trials.space, np.array([20.0, 45.0, 75.0])
    quotients = {}
    for size in sizes:
        trials.space = space._replace(step=size * space.width)
        found = []
        for seed in range(seeds):
            evaluations = Evaluations(trials, angles, np.full(3, 100.0), seed)
            found.append(evaluations.slopes(space.start, count, pick, central=True))
        quotients[size] = np.array(found) * space.width
    base = quotients[sizes[-2]].mean(axis=0)
    scale = np.sqrt((base**2).mean(axis=0))
    for size, found in quotients.items():
        chance = np.sqrt(found.var(axis=0, ddof=1).mean(axis=0)) / scale
        bias = np.sqrt(((found.mean(axis=0) - base) ** 2).mean(axis=0)) / scale
        for name in (*LAWS, MEAN):
            of = [k for k, label in enumerate(trials.labels) if label.startswith(name)]
            numbers = f"chance {chance[of].mean():.3f} bias {bias[of].mean():.3f}"
            print(f"step {size:<7g} {name:24} {numbers}")


def pick(simulated):
    """Pick means and spreads of e_n and e_t."""
    maps = (simulated.mean, simulated.std)
    values = np.concatenate([of[name] for of in maps for name in ("e_n", "e_t")])
    return values, np.zeros_like(values)


if __name__ == "__main__":
    steps()
