"""The tree that finds the leaf of a condition: cuts at medians, across the widest axis."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sampler.formats.bounds import N_CONDITIONS, NO_SPIN
from tablegen.model.float_array import FloatArray

#: Number of the axis |sigma|^2 in a tree.
_SPIN_AXIS = N_CONDITIONS

#: Width that counts as one on each axis: about that of the domain, two fifths of it for the speed,
#: of which a law depends on less.
_WIDTHS = np.array([1.16, 1.9, 2.44, 2.44, 2.44])

#: How far beyond a cut conditions still serve the fit of a leaf, over the width of what was cut.
_MARGIN = 0.08


class Tree(NamedTuple):
    """Nodes of a tree; a child below zero is a leaf, -1 minus its number.

    ``axis`` (n,) int8, ``cut`` (n,) float64, ``child`` (n, 2) int32: a condition with a value of
    at least the cut goes on at the second child.
    """

    axis: NDArray[np.int8]
    cut: FloatArray
    child: NDArray[np.int32]


class Leaf(NamedTuple):
    """Conditions in a leaf and a little beyond it, by number, and which of them are in it."""

    rows: NDArray[np.int64]
    inside: NDArray[np.bool_]


class _Cut(NamedTuple):
    axis: int
    value: float
    margin: float


def grow(q: FloatArray, leaves: int) -> tuple[Tree, list[Leaf]]:
    """Cut the leaf with the most conditions until there are enough.

    Parameters
    ----------
    q : (n, 5) float64
        Coordinates of conditions, folded.
    leaves : int
        Fewer are made where conditions cannot be told apart.

    Returns
    -------
    tuple (Tree, list of Leaf)
        A tree of a single leaf has no node.
    """
    everything = Leaf(np.arange(len(q)), np.ones(len(q), dtype=bool))
    found: list[Leaf | None] = [everything]
    nodes: list[tuple[_Cut, list[int]]] = []
    #: Of each leaf the node that it hangs on and the side, and whether it can be cut.
    places: list[tuple[int, int]] = [(-1, 0)]
    sizes = [len(q)]
    while len(found) < leaves and max(sizes) > 1:
        number = int(np.argmax(sizes))
        leaf = found[number]
        assert leaf is not None
        cut = _widest(q[leaf.rows[leaf.inside]])
        if cut is None:
            sizes[number] = 0
            continue
        first, second = _halves(q, leaf, cut)
        node, side = places[number]
        nodes.append((cut, [-1 - number, -1 - len(found)]))
        if node >= 0:
            nodes[node][1][side] = len(nodes) - 1
        places[number] = (len(nodes) - 1, 0)
        places.append((len(nodes) - 1, 1))
        found[number] = first
        found.append(second)
        sizes[number] = int(first.inside.sum())
        sizes.append(int(second.inside.sum()))
    tree = Tree(
        np.array([cut.axis for cut, _ in nodes], dtype=np.int8),
        np.array([cut.value for cut, _ in nodes], dtype=np.float64),
        np.array([child for _, child in nodes], dtype=np.int32).reshape(-1, 2),
    )
    return tree, [leaf for leaf in found if leaf is not None]


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
    """Tree that asks first whether there is a spin; leaves with one come after those without.

    Parameters
    ----------
    still : Tree
        Of conditions without spin.
    still_leaves : int
        How many leaves it has.
    spinning : Tree
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


def find_leaves(tree: Tree, q: FloatArray) -> NDArray[np.int64]:
    """Find the number of the leaf of each of some folded conditions (n, 5), (n,)."""
    values = np.column_stack([q, np.sum(q[:, 2:] ** 2, axis=1)])
    at = np.zeros(len(q), dtype=np.int64)
    while (going := np.flatnonzero(at >= 0)).size:
        node = at[going]
        side = values[going, tree.axis[node]] >= tree.cut[node]
        at[going] = tree.child[node, side.astype(np.int64)]
    return -1 - at
