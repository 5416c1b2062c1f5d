"""The tree that finds the leaf of a condition: cuts at medians, across the widest axis."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sampler.formats.bounds import N_CONDITIONS, NO_SPIN
from tablegen.model.float_array import FloatArray

#: Number of the axis |sigma|^2 in a tree.
_SPIN_AXIS = N_CONDITIONS

#: Unit of width on each axis: about the width of the domain, or what a law depends on as much.
_WIDTHS = np.array([0.9, 1.9, 2.44, 2.44, 2.44])

#: Distance beyond a cut, over the width of the cut leaf, up to which conditions are fitted too.
_MARGIN = 0.03


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


class _Cut(NamedTuple):
    axis: int
    value: float
    margin: float


def grow(q: FloatArray, wanted: int, inside: NDArray[np.bool_]) -> tuple[Tree, list[Leaf]]:
    """Cut the leaf with the most conditions until there are as many leaves as wanted.

    Conditions are folded coordinates (n, 5). Those that are not ``inside`` (n,), beyond the fold,
    belong to leaves but do not count. There are fewer leaves if conditions are equal.
    """
    leaves = [Leaf(np.arange(len(q)), inside)]
    sizes = [int(inside.sum())]
    places = [(-1, 0)]  # parent of each leaf, and whether it is its first or second child
    cuts: list[_Cut] = []
    children: list[list[int]] = []
    while len(leaves) < wanted and max(sizes) > 1:
        number = int(np.argmax(sizes))
        leaf = leaves[number]
        cut = _widest(q[leaf.rows[leaf.inside]])
        if cut is None:
            sizes[number] = 0
            continue
        parent, side = places[number]
        if parent >= 0:
            children[parent][side] = len(cuts)
        places[number] = (len(cuts), 0)
        places.append((len(cuts), 1))
        cuts.append(cut)
        children.append([-1 - number, -1 - len(leaves)])
        leaves[number], second = _halves(q, leaf, cut)
        leaves.append(second)
        sizes[number] = int(leaves[number].inside.sum())
        sizes.append(int(second.inside.sum()))
    tree = Tree(
        np.array([cut.axis for cut in cuts], dtype=np.int8),
        np.array([cut.value for cut in cuts], dtype=np.float64),
        np.array(children, dtype=np.int32).reshape(-1, 2),
    )
    return tree, leaves


def _widest(q: FloatArray) -> _Cut | None:
    """Cut at the median of the axis over which conditions are spread widest, if there is one."""
    low, high = np.quantile(q, [0.05, 0.95], axis=0)
    for axis in np.argsort(-(high - low) / _WIDTHS, kind="stable"):
        value = float(np.median(q[:, axis]))
        second = q[:, axis] >= value
        if second.any() and not second.all():
            return _Cut(int(axis), value, _MARGIN * float(high[axis] - low[axis]))
    return None


def _halves(q: FloatArray, leaf: Leaf, cut: _Cut) -> tuple[Leaf, Leaf]:
    values = q[leaf.rows, cut.axis]
    below, above = values < cut.value + cut.margin, values >= cut.value - cut.margin
    inside = values < cut.value
    return (
        Leaf(leaf.rows[below], (leaf.inside & inside)[below]),
        Leaf(leaf.rows[above], (leaf.inside & ~inside)[above]),
    )


def joined(still: Tree, still_leaves: int, spinning: Tree) -> Tree:
    """Join two trees by a root that asks whether a condition has spin.

    The leaves of the conditions without spin come first, and there are ``still_leaves`` of them.
    """
    first = 1 + len(still.axis)
    below = np.where(still.child >= 0, still.child + 1, still.child)
    above = np.where(spinning.child >= 0, spinning.child + first, spinning.child - still_leaves)
    root = np.array(
        [[1 if len(still.axis) else -1, first if len(spinning.axis) else -1 - still_leaves]],
        dtype=np.int32,
    )
    return Tree(
        np.concatenate([[_SPIN_AXIS], still.axis, spinning.axis]).astype(np.int8),
        np.concatenate([[NO_SPIN], still.cut, spinning.cut]),
        np.concatenate([root, below, above]).astype(np.int32),
    )
