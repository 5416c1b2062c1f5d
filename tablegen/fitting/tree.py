"""The tree that finds the leaf of a condition: cuts where they explain the outcomes best.

Each leaf is as good as its mixture of experts, which bends to the conditions as quadratic functions
do. So a leaf is cut across the input over which quadratic regressions of the outcomes gain the
most, and the leaf is cut next that gains the most for all of its conditions together: where grains
roll along a wall, a spin that differs by a few hundredths changes everything, and leaves there are
small.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sampler.formats.bounds import NO_SPIN
from tablegen.fitting.marginals import normal_scores
from tablegen.fitting.spin_coordinates import AXES, SPIN_AXIS, features
from tablegen.model.float_array import FloatArray

#: Distance beyond a cut, over the width of the cut leaf, up to which conditions are fitted too.
_MARGIN = 0.03

#: Conditions of a leaf with which its cuts are compared, and the least that a leaf can be cut from.
_COMPARED, _LEAST = 4000, 200

#: A leaf of n conditions that gains g by its cut is worth n^_POWER g.
_POWER = 0.8

#: Regularisation of regressions, and of the variances that they leave.
_RIDGE = 1e-3


class Tree(NamedTuple):
    """Nodes of a tree; a negative child c is leaf number -1 - c.

    ``axis`` (n,) int8, ``cut`` (n,) float64, ``child`` (n, 2) int32: conditions with a value of at
    least the cut go to the second child. A tree of a single leaf has no node.
    """

    axis: NDArray[np.int8]
    cut: FloatArray
    child: NDArray[np.int32]


class Leaf(NamedTuple):
    """Row numbers of the conditions in a leaf and a little beyond it, and which are in it."""

    rows: NDArray[np.int64]
    inside: NDArray[np.bool_]


#: Inputs of all conditions, and a function that simulates the outcomes at those of some rows.
Inputs = FloatArray | NDArray[np.float32]
Outcomes = Callable[[NDArray[np.int64]], FloatArray]


class _Cut(NamedTuple):
    column: int
    value: float
    margin: float
    worth: float


def grow(
    inputs: Inputs, outcomes: Outcomes, wanted: int, rng: np.random.Generator
) -> tuple[Tree, list[Leaf]]:
    """Cut the leaf that gains the most until there are as many leaves as wanted.

    Parameters
    ----------
    inputs : (n, 8) float64 or float32
        Folded inputs of `tablegen.fitting.spin_coordinates`.
    outcomes : callable
        Returns the outcomes (m, d) of one rebound at each of the conditions of some rows (m,). Only
        those with which cuts are compared are asked for.
    wanted : int
        Number of leaves. There are fewer if conditions are equal or few.
    rng : numpy.random.Generator
    """
    leaves = [Leaf(np.arange(len(inputs)), np.ones(len(inputs), dtype=bool))]
    best = [_best_cut(inputs, outcomes, leaves[0], rng) if wanted > 1 else None]
    places = [(-1, 0)]  # parent of each leaf, and whether it is its first or second child
    cuts: list[_Cut] = []
    children: list[list[int]] = []
    while len(leaves) < wanted:
        number = int(np.argmax([cut.worth if cut else -1.0 for cut in best]))
        cut = best[number]
        if cut is None:
            break
        parent, side = places[number]
        if parent >= 0:
            children[parent][side] = len(cuts)
        places[number] = (len(cuts), 0)
        places.append((len(cuts), 1))
        cuts.append(cut)
        children.append([-1 - number, -1 - len(leaves)])
        leaves[number], second = _halves(inputs, leaves[number], cut)
        leaves.append(second)
        best[number] = _best_cut(inputs, outcomes, leaves[number], rng)
        best.append(_best_cut(inputs, outcomes, second, rng))
    tree = Tree(
        AXES[[cut.column for cut in cuts]].astype(np.int8),
        np.array([cut.value for cut in cuts], dtype=np.float64),
        np.array(children, dtype=np.int32).reshape(-1, 2),
    )
    return tree, leaves


def _best_cut(
    inputs: Inputs, outcomes: Outcomes, leaf: Leaf, rng: np.random.Generator
) -> _Cut | None:
    """Find the cut at a median that gains the most, if conditions differ and are enough."""
    rows = leaf.rows[leaf.inside]
    size = len(rows)
    if size < _LEAST:
        return None
    if size > _COMPARED:
        rows = rng.choice(rows, _COMPARED, replace=False)
    x = inputs[rows].astype(np.float64)
    scores = normal_scores(outcomes(rows))
    whole, best = _spread(x, scores), None
    for column in range(x.shape[1]):
        value = float(np.median(x[:, column]))
        above = x[:, column] >= value
        share = float(above.mean())
        if not 0.1 < share < 0.9:
            continue
        cut = share * _spread(x[above], scores[above])
        cut += (1.0 - share) * _spread(x[~above], scores[~above])
        worth = size**_POWER * max(whole - cut, 1e-9)
        if best is None or worth > best.worth:
            low, high = np.quantile(x[:, column], [0.05, 0.95])
            best = _Cut(column, value, _MARGIN * float(high - low), worth)
    return best


def _spread(x: FloatArray, scores: FloatArray) -> float:
    """Logarithm of the generalised variance that a quadratic regression on inputs leaves."""
    deviation = x.std(axis=0)
    varies = deviation > 1e-9
    t = np.where(varies, (x - x.mean(axis=0)) / np.where(varies, deviation, 1.0), 0.0)
    phi = features(t)
    form = phi.T @ phi + _RIDGE * len(phi) * np.eye(phi.shape[1])
    rest = scores - phi @ np.linalg.solve(form, phi.T @ scores)
    covariance = rest.T @ rest / len(phi) + _RIDGE * np.eye(scores.shape[1])
    return float(np.linalg.slogdet(covariance)[1])


def _halves(inputs: Inputs, leaf: Leaf, cut: _Cut) -> tuple[Leaf, Leaf]:
    values = inputs[leaf.rows, cut.column]
    below, above = values < cut.value + cut.margin, values >= cut.value - cut.margin
    inside = values < cut.value
    return (
        Leaf(leaf.rows[below], (leaf.inside & inside)[below]),
        Leaf(leaf.rows[above], (leaf.inside & ~inside)[above]),
    )


def joined(nonspinning: Tree, nonspinning_leaves: int, spinning: Tree) -> Tree:
    """Join two trees by a root that asks whether a condition has spin.

    The leaves of the conditions without spin come first.
    """
    first = 1 + len(nonspinning.axis)
    below = np.where(nonspinning.child >= 0, nonspinning.child + 1, nonspinning.child)
    above = np.where(
        spinning.child >= 0, spinning.child + first, spinning.child - nonspinning_leaves
    )
    root = np.array(
        [
            [
                1 if len(nonspinning.axis) else -1,
                first if len(spinning.axis) else -1 - nonspinning_leaves,
            ]
        ],
        dtype=np.int32,
    )
    return Tree(
        np.concatenate([[SPIN_AXIS], nonspinning.axis, spinning.axis]).astype(np.int8),
        np.concatenate([[NO_SPIN], nonspinning.cut, spinning.cut]),
        np.concatenate([root, below, above]).astype(np.int32),
    )
