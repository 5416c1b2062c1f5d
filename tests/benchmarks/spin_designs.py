"""What limits the accuracy of a spin law: the experiments behind tablegen/fitting/EXPERIMENTS.md.

Run ``python tests/benchmarks/spin_designs.py NAME``, where NAME is one of

mirror     distance of the law of each shape from its mirror image, which a spin law takes for equal
rebounds   error of leaves of prisms at a condition in each, and seconds, by rebounds of the fit
experts    the same by the number of experts
"""

import sys
from functools import partial

import numpy as np

from sampler.formats.bounds import SCORE_MAX
from sampler.formats.shape_codes import SHAPE_CODES
from tablegen.accuracy.metrics import DISTANCES, ks_distances
from tablegen.config.config import load_config
from tablegen.config.metric_table import METRICS
from tablegen.fitting.coordinates import (
    CONDITION_SIGNS,
    OUTCOME_SIGNS,
    coordinates,
    features,
    folded,
    outcomes,
)
from tablegen.fitting.fit_tasks import (
    ShapeConditions,
    conditions_task,
    leaf_task,
    speed_coordinate,
)
from tablegen.fitting.leaf import LeafArrays
from tablegen.fitting.leaf_sizes import SPIN_SIZES
from tablegen.fitting.spin_scores import StoredExperts, bounded_scores
from tablegen.fitting.tree import Tree, find_leaves
from tablegen.simulation.direct import DirectModel

CONFIG = load_config("corundum-steel").with_changes(
    {"domain": {"speed": [5.0, 300.0], "extrapolate": True}}
)
PRISM = SHAPE_CODES["prism"]
COUNT = 40_000

#: Angle [rad], speed [m/s] and spin times a/V: one at the back of a particle, one steep, one fast.
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
    """Outcomes of a leaf at a condition, folded."""
    q, _ = folded(coordinates(np.tile(condition, (len(ratios), 1)), speed_coordinate(CONFIG)))
    t = (np.hstack([q, ratios]) - leaf.centre) * leaf.scale
    rng = np.random.default_rng(9)
    scores = bounded_scores(StoredExperts(*leaf[2:6]), features(t), rng)
    knots = np.linspace(-SCORE_MAX, SCORE_MAX, leaf.quantiles.shape[1])
    columns = [np.interp(s, knots, x) for s, x in zip(scores.T, leaf.quantiles, strict=True)]
    return np.column_stack(columns)


def leaves(sizes):
    """Error of a leaf at each condition, and seconds of its fit."""
    made = conditions_task(CONFIG, PRISM, sizes, "experiment")
    whole = ShapeConditions(**{name: made[name] for name in ShapeConditions._fields})
    tree, speed = Tree(whole.axis, whole.cut, whole.child), speed_coordinate(CONFIG)
    for condition in CONDITIONS:
        q, signs = folded(coordinates(condition[None], speed))
        number = int(find_leaves(tree, q)[0])
        arrays = leaf_task(CONFIG, PRISM, whole.of_leaf(number), sizes, f"leaf {number}")
        leaf = LeafArrays(**{name: arrays[name] for name in LeafArrays._fields})
        grains, states = simulated("prism", condition, 5)
        direct = outcomes(states, np.tile(condition[2:], (COUNT, 1))) * signs
        table = drawn(leaf, condition, grains[:, 1:])
        found = {name: np.max(d(table, direct, 100, 0)) for name, d in DISTANCES.items()}
        errors = [f"{METRICS[name].short} {value:.4f}" for name, value in found.items()]
        print(tuple(sizes), condition.round(2), f"{arrays['seconds'].sum():.0f} s", *errors)


def mirror():
    """Distance of each law from its mirror image."""
    for shape in ("ellipsoid", "prism", "truncated-prism", "tetrahedron"):
        for condition in CONDITIONS:
            _, one = simulated(shape, condition, 5)
            _, other = simulated(shape, condition * CONDITION_SIGNS, 6)
            distance = max(ks_distances(one, other * OUTCOME_SIGNS))
            print(shape, condition.round(2), f"KS {distance:.4f}")


def by_size(name, *values):
    """Errors of leaves by one of the sizes."""
    for value in values:
        leaves(SPIN_SIZES["standard"]._replace(**{name: value}))


EXPERIMENTS = {
    "mirror": mirror,
    "rebounds": partial(by_size, "rebounds", 60_000, 120_000, 240_000),
    "experts": partial(by_size, "experts", 4, 8, 16),
}

if __name__ == "__main__":
    EXPERIMENTS[sys.argv[1]]()
