"""Grow the tree that divides the conditions of the spin law into leaves.

The experts of a leaf are functions of second degree of the inputs. So a leaf is cut where this
helps quadratic regressions of the outcomes most. With the covariance C of what a regression on the
inputs leaves of the outcomes' normal scores, a cut gains

    g = log det C - (share below) log det C_below - (share above) log det C_above,

and the leaf with the largest g n^0.8, for n conditions, is cut next. Where grains roll along a
wall, a spin that differs by a few hundredths changes the rebound, and leaves become small.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sampler.formats.bounds import NO_SPIN
from tablegen.fitting.marginals import normal_scores
from tablegen.fitting.spin_coordinates import AXES, SPIN_AXIS, features
from tablegen.model.float_array import FloatArray

#: A leaf is also fitted to conditions beyond its cuts, up to this part of the width of the leaf
#: that was cut.
_MARGIN = 0.03

#: Cuts of a leaf are compared with this number of its conditions. A leaf with fewer conditions than
#: the second number is not cut.
_COMPARED_CONDITIONS, _LEAST_CONDITIONS = 4000, 200

#: A cut with the gain g is worth n^_WORTH_POWER g in a leaf of n conditions.
_WORTH_POWER = 0.8

#: Regularisation of the regressions, and of the variances that they leave.
_RIDGE = 1e-3


class Tree(NamedTuple):
    """Nodes of a tree; the first one is the root. A tree of a single leaf has no node."""

    #: (n,): number of the axis that each node cuts.
    axis: NDArray[np.int8]
    #: (n,): conditions with a value of at least the cut go to the second child.
    cut: FloatArray
    #: (n, 2): numbers of nodes; a negative child c is leaf number -1 - c.
    child: NDArray[np.int32]


class Leaf(NamedTuple):
    """Conditions in a leaf and a little beyond it."""

    #: (m,): their row numbers.
    rows: NDArray[np.int64]
    #: (m,): whether each is in the leaf.
    inside: NDArray[np.bool_]


#: Inputs of all conditions, and directions, (n, 13).
Inputs = FloatArray | NDArray[np.float32]
#: Function that simulates the outcomes, (m, d), at the conditions with given row numbers, (m,).
Outcomes = Callable[[NDArray[np.int64]], FloatArray]


class _Cut(NamedTuple):
    """Cut of a leaf at a value of one input."""

    column: int
    value: float
    #: Distance beyond the cut up to which conditions are fitted too.
    margin: float
    #: Gain, times a power of the number of conditions.
    worth: float


def grow_tree(
    inputs: Inputs, outcomes: Outcomes, leaf_count: int, rng: np.random.Generator
) -> tuple[Tree, list[Leaf]]:
    """Grow a tree: cut the leaf that gains the most, until there are enough leaves.

    Parameters
    ----------
    inputs : (n, 13) float64 or float32
        Inputs and directions of `tablegen.fitting.spin_coordinates`, folded by `reflect`.
    outcomes : callable
        Simulates one rebound at each of the conditions with row numbers (m,), and returns the
        outcomes (m, d). It is called only for conditions with which cuts are compared.
    leaf_count : int
        Number of leaves. There are fewer if too many conditions are equal, or too few in all.
    rng : numpy.random.Generator

    Returns
    -------
    tree : Tree
    leaves : list of Leaf
        In the order of their numbers.
    """
    leaves = [Leaf(np.arange(len(inputs)), np.ones(len(inputs), dtype=bool))]
    best = [_best_cut(inputs, outcomes, leaves[0], rng) if leaf_count > 1 else None]
    # of each leaf: the number of its parent, and whether it is the first or the second child
    parents = [(-1, 0)]
    cuts: list[_Cut] = []
    children: list[list[int]] = []
    while len(leaves) < leaf_count:
        number = int(np.argmax([cut.worth if cut else -1.0 for cut in best]))
        cut = best[number]
        if cut is None:
            break
        parent, side = parents[number]
        if parent >= 0:
            children[parent][side] = len(cuts)
        parents[number] = (len(cuts), 0)
        parents.append((len(cuts), 1))
        cuts.append(cut)
        children.append([-1 - number, -1 - len(leaves)])
        leaves[number], second = _split_leaf(inputs, leaves[number], cut)
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
    """Find the cut at the median of an input that gains the most.

    Returns None if the leaf has too few conditions, or if no input varies enough.
    """
    rows = leaf.rows[leaf.inside]
    size = len(rows)
    if size < _LEAST_CONDITIONS:
        return None
    if size > _COMPARED_CONDITIONS:
        rows = rng.choice(rows, _COMPARED_CONDITIONS, replace=False)
    x = inputs[rows].astype(np.float64)
    scores = normal_scores(outcomes(rows))
    whole, best = _residual_spread(x, scores), None
    for column in range(len(AXES)):
        value = float(np.median(x[:, column]))
        above = x[:, column] >= value
        share = float(above.mean())
        if not 0.1 < share < 0.9:
            continue
        halves = share * _residual_spread(x[above], scores[above])
        halves += (1.0 - share) * _residual_spread(x[~above], scores[~above])
        worth = size**_WORTH_POWER * max(whole - halves, 1e-9)
        if best is None or worth > best.worth:
            low, high = np.quantile(x[:, column], [0.05, 0.95])
            best = _Cut(column, value, _MARGIN * float(high - low), worth)
    return best


def _residual_spread(x: FloatArray, scores: FloatArray) -> float:
    """Compute log det C of the scores that a quadratic regression on the inputs leaves."""
    deviation = x.std(axis=0)
    varies = deviation > 1e-9
    t = np.where(varies, (x - x.mean(axis=0)) / np.where(varies, deviation, 1.0), 0.0)
    phi = features(t)
    form = phi.T @ phi + _RIDGE * len(phi) * np.eye(phi.shape[1])
    residual = scores - phi @ np.linalg.solve(form, phi.T @ scores)
    covariance = residual.T @ residual / len(phi) + _RIDGE * np.eye(scores.shape[1])
    return float(np.linalg.slogdet(covariance)[1])


def _split_leaf(inputs: Inputs, leaf: Leaf, cut: _Cut) -> tuple[Leaf, Leaf]:
    """Divide a leaf into the one below the cut and the one above it."""
    values = inputs[leaf.rows, cut.column]
    below, above = values < cut.value + cut.margin, values >= cut.value - cut.margin
    inside = values < cut.value
    return (
        Leaf(leaf.rows[below], (leaf.inside & inside)[below]),
        Leaf(leaf.rows[above], (leaf.inside & ~inside)[above]),
    )


def join_trees(nonspinning: Tree, nonspinning_leaves: int, spinning: Tree) -> Tree:
    """Join the trees of conditions without spin and with spin by a root between them.

    The leaves of conditions without spin come first.
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
