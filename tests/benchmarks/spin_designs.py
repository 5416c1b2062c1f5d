"""Accuracy of leaves of a spin law: the experiments behind tablegen/fitting/EXPERIMENTS.md.

    python tests/benchmarks/spin_designs.py NAME

where NAME is one of

mirror     distance of the law of each shape from its mirror image; a spin law takes both as equal
rebounds   error of leaves of prisms at a condition in each, by number of rebounds of the fit
"""

import sys

import harness  # noqa: F401  (makes the imports from a checkout possible)
import numpy as np

from sampler.formats.bounds import SCORE_MAX
from sampler.formats.shape_codes import SHAPE_CODES
from tablegen.accuracy.metrics import DISTANCES, ks_distances
from tablegen.config.config import load_config
from tablegen.fitting.law_conditions import inertia_coefficients
from tablegen.fitting.leaf import LeafArrays
from tablegen.fitting.resolution import SPIN_SIZES
from tablegen.fitting.spin_coordinates import (
    CONDITION_SIGNS,
    OUTCOME_SIGNS,
    coordinates,
    features,
    folded,
    outcomes,
)
from tablegen.fitting.spin_law import ShapeConditions, conditions_task, leaf_task, speed_coordinate
from tablegen.fitting.spin_scores import StoredExperts, bounded_scores
from tablegen.fitting.tree import Tree, find_leaves
from tablegen.simulation.direct import DirectModel

CONFIG = load_config("corundum-steel").with_changes(
    {"domain": {"speed": [5.0, 300.0], "extrapolate": True}}
)
COUNT = 40_000

#: Angle [rad], speed [m/s] and spin times a/V.
CONDITIONS = np.array(
    [
        [0.49, 63.0, -0.39, -0.65, -0.12],
        [1.27, 148.0, -0.5, 0.84, 0.11],
        [0.42, 235.0, -0.26, -0.66, 1.14],
    ]
)


def simulated(shape, condition, seed):
    """Simulate grains of a shape at a condition."""
    model = DirectModel(CONFIG, CONFIG.population.restricted_to(shape))
    index = np.arange(COUNT)
    keys = {"seed": seed, "index": index, "spin": condition[2:], "threads": 1}
    return model.grains(seed, index), model.sample(condition[0], condition[1], **keys)


def drawn(leaf, condition, ratios):
    """Draw outcomes of a leaf at a condition, folded."""
    q, _ = folded(coordinates(np.tile(condition, (len(ratios), 1)), speed_coordinate(CONFIG)))
    t = (np.hstack([q, ratios]) - leaf.centre) * leaf.scale
    stored = StoredExperts(leaf.group_gate, leaf.gate, leaf.mean, leaf.factor)
    scores = bounded_scores(stored, features(t), np.random.default_rng(9))
    knots = np.linspace(-SCORE_MAX, SCORE_MAX, leaf.quantiles.shape[1])
    columns = [np.interp(s, knots, x) for s, x in zip(scores.T, leaf.quantiles, strict=True)]
    return np.column_stack(columns)


def mirror():
    """Print the distance of each law from its mirror image."""
    for shape in ("ellipsoid", "prism", "truncated-prism", "tetrahedron"):
        for condition in CONDITIONS:
            _, one = simulated(shape, condition, 5)
            _, other = simulated(shape, condition * CONDITION_SIGNS, 6)
            distance = max(ks_distances(one, other * OUTCOME_SIGNS))
            print(shape, condition.round(2), f"KS {distance:.4f}")


def rebounds():
    """Print the error of the leaf at each condition."""
    prism, speed = SHAPE_CODES["prism"], speed_coordinate(CONFIG)
    for count in (60_000, 120_000, 240_000):
        sizes = SPIN_SIZES["standard"]._replace(rebounds=count)
        made = conditions_task(CONFIG, prism, sizes, "experiment")
        whole = ShapeConditions(**{name: made[name] for name in ShapeConditions._fields})
        for condition in CONDITIONS:
            q, signs = folded(coordinates(condition[None], speed))
            number = int(find_leaves(Tree(whole.axis, whole.cut, whole.child), q)[0])
            arrays = leaf_task(CONFIG, prism, whole.of_leaf(number), sizes, f"leaf {number}")
            leaf = LeafArrays(**{name: arrays[name] for name in LeafArrays._fields})
            grains, states = simulated("prism", condition, 5)
            largest, _ = inertia_coefficients(CONFIG.population, prism)
            moment = largest * (1.0 + grains[:, 1] ** 2)
            direct = outcomes(states, 1.0 + moment * np.sum(condition[2:] ** 2)) * signs
            table = drawn(leaf, condition, grains[:, 1:])
            errors = (f"{n} {np.max(d(table, direct, 100, 0)):.4f}" for n, d in DISTANCES.items())
            print(count, condition.round(2), *errors, flush=True)


if __name__ == "__main__":
    {"mirror": mirror, "rebounds": rebounds}[sys.argv[1]]()
