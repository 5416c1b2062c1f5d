"""Chance and bias of difference quotients, by step: for tablegen/measured/EXPERIMENTS.md.

python tests/benchmarks/calibration_designs.py
"""

import harness  # noqa: F401  (makes the imports from a checkout possible)
import numpy as np

from tablegen.config.config import load_config
from tablegen.measured.evaluations import Evaluations
from tablegen.measured.parameters import make_parameters
from tablegen.measured.trial_pairs import TrialPairs

NAMES = ("pair.restitution.value", "pair.resistance.value", "population.aspect.mean")


def means_and_spreads(simulated):
    """Pick the means and spreads of e_n and e_t."""
    values = [simulated.mean["e_n"], simulated.mean["e_t"]]
    values += [simulated.std["e_n"], simulated.std["e_t"]]
    return np.concatenate(values), np.zeros(12)


def main(count=500, seeds=20, sizes=(0.0003, 0.003, 0.03, 0.1)):
    """Print chance and bias of central difference quotients, over their own size.

    Steps are parts of the range of search. The bias is the difference from the mean over all seeds
    with the second largest step.
    """
    config = load_config("start-tabulated")
    config = config.with_changes({"population": {"shapes": {"sphere": 0.0}}})
    trials = TrialPairs(config, make_parameters(config, NAMES), 0.0)
    angles = np.array([20.0, 45.0, 75.0])
    width = trials.last - trials.first
    quotients = {}
    for size in sizes:
        trials.step = size * width
        found = []
        for seed in range(seeds):
            evaluations = Evaluations(trials, angles, np.full(3, 100.0), seed)
            found.append(evaluations.slopes(trials.start, count, means_and_spreads, central=True))
        quotients[size] = np.array(found) * width
    base = quotients[sizes[-2]].mean(axis=0)
    scale = np.sqrt((base**2).mean(axis=0))
    for size, found in quotients.items():
        chance = np.sqrt(found.var(axis=0, ddof=1).mean(axis=0)) / scale
        bias = np.sqrt(((found.mean(axis=0) - base) ** 2).mean(axis=0)) / scale
        for name in NAMES:
            of = [k for k, label in enumerate(trials.labels) if label.startswith(name)]
            print(
                f"step {size:<7g} {name:24} chance {chance[of].mean():.3f} "
                f"bias {bias[of].mean():.3f}"
            )


if __name__ == "__main__":
    main()
