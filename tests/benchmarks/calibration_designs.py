"""How a calibration searches: the experiments behind tablegen/measured/EXPERIMENTS.md.

Run ``python tests/benchmarks/calibration_designs.py NAME``, where NAME is one of

steps      chance and bias of difference quotients, by step
starts     cost at the end of searches from the given pair and from random ones
laws       largest residuals of the means of Grant & Tabakoff and of Forder, by law of resistance
"""

import sys

import numpy as np

from tablegen.config.config import load_config
from tablegen.measured.calibrate import calibrate
from tablegen.measured.evaluations import Evaluations
from tablegen.measured.parameters import make_parameters
from tablegen.measured.reader import read_measurements
from tablegen.measured.search import Search, random_starts
from tablegen.measured.targets import make_targets
from tablegen.measured.trial_pairs import TrialPairs

START = load_config("start-tabulated")
FREE = (
    "pair.restitution.value",
    "pair.resistance.value",
    "population.aspect.mean",
    "population.shapes",
)
SOURCE = {"source": "tried"}

#: Laws of resistance beside the tabulated one, each with what it has free.
RESISTANCES = {
    "exponential-orientation": {
        "law": "exponential-orientation",
        "strength": -1.0,
        "factor": 1.0,
        **SOURCE,
    },
    "constant": {"law": "constant", "value": 0.4, **SOURCE},
    "coulomb": {"law": "coulomb", "static": 0.3, "dynamic": 0.3, **SOURCE},
}
FREE_OF = {
    "tabulated": ("value",),
    "exponential-orientation": ("strength", "factor"),
    "constant": ("value",),
    "coulomb": ("static", "dynamic"),
}


def steps(count=500, seeds=20, sizes=(0.0003, 0.003, 0.03, 0.1)):
    """Chance and bias of central difference quotients, in units of the quotient's own size.

    Steps are parts of the range of search. The bias is that against the smallest step but one of
    all seeds together.
    """
    names = ("pair.restitution.value", "pair.resistance.value", "population.aspect.mean")
    config = START.with_changes({"population": {"shapes": {"sphere": 0.0}}})
    trials = TrialPairs(config, make_parameters(config, names), 0.0)
    angles = np.array([20.0, 45.0, 75.0])
    measured = read_measurements("grant-tabakoff-1975")
    width = trials.last - trials.first
    quotients = {}
    for size in sizes:
        trials.step = size * width
        found = []
        for seed in range(seeds):
            evaluations = Evaluations(trials, angles, np.full(3, 100.0), seed)
            found.append(evaluations.slopes(trials.start, count, _means, central=True))
        quotients[size] = np.array(found) * width
    print(f"{measured.name}: {count} particles of each shape; sizes over all means and spreads")
    base = quotients[sizes[-2]].mean(axis=0)
    scale = np.sqrt((base**2).mean(axis=0))
    for size, found in quotients.items():
        chance = np.sqrt(found.var(axis=0, ddof=1).mean(axis=0)) / scale
        bias = np.sqrt(((found.mean(axis=0) - base) ** 2).mean(axis=0)) / scale
        for name in names:
            of = [k for k, label in enumerate(trials.labels) if label.startswith(name)]
            print(
                f"step {size:<7g} {name:24} chance {chance[of].mean():.3f} "
                f"bias {bias[of].mean():.3f}"
            )


def _means(simulated):
    """Pick e_n and e_t, means and spreads."""
    values = [simulated.mean["e_n"], simulated.mean["e_t"]]
    values += [simulated.std["e_n"], simulated.std["e_t"]]
    return np.concatenate(values), np.zeros(12)


def starts(count=250, number=16, seed=1):
    """Print the cost of searches of one stage from several starts."""
    measured = read_measurements("grant-tabakoff-1975")
    trials = TrialPairs(START, make_parameters(START, FREE), 0.0)
    evaluations = Evaluations(trials, measured.alpha_deg, np.full(9, 100.0), seed)
    targets = make_targets(measured, evaluations.moments(trials.start, 200))
    search = Search(evaluations, targets, count)
    accuracy = search.accuracy(trials.start, count)
    looks, ends = [], []
    for x in random_starts(trials, number, seed):
        looks.append(0.5 * np.sum((search.residuals(x, count) / accuracy) ** 2))
        ends.append(search.end(x, 12, count, accuracy, central=False)[0])
        print(f"cost at the start {looks[-1]:9.1f}, at the end {ends[-1]:7.1f}", flush=True)
    ranks = [float(np.mean(np.argsort(np.argsort(v)))) for v in (looks, ends)]
    correlation = np.corrcoef(np.argsort(np.argsort(looks)), np.argsort(np.argsort(ends)))[0, 1]
    print(f"rank correlation of both {correlation:.2f} (mean rank {ranks[0]:.1f})")


def laws(count=1000, names=("grant-tabakoff-1975", "forder-1998")):
    """Print how closely each law of resistance follows the published means, spreads left out."""
    for name in names:
        measured = read_measurements(name)
        for column in measured.moments.values():
            column.std[:] = np.nan
        for law, fields in FREE_OF.items():
            changes = {} if law == "tabulated" else {"pair": {"resistance": RESISTANCES[law]}}
            config = START.with_changes(changes)
            free = [f"pair.resistance.{field}" for field in fields]
            free += [one for one in FREE if "resistance" not in one]
            made = calibrate(measured, config, free=free, count=count)
            worst = {c: (n.residual, n.alpha_deg) for c, n in made.largest().items()}
            print(f"{name:20} {law:24} scatter {made.scatter:.2f} {worst}", flush=True)


if __name__ == "__main__":
    {"steps": steps, "starts": starts, "laws": laws}[sys.argv[1]]()
