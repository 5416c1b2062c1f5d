"""The tree of conditions: every condition is in one leaf, and the draw finds it."""

from types import SimpleNamespace

import numpy as np
from sampler.drawing.spin_steps import find_leaf

from tablegen.fitting.tree import find_leaves, grow, joined

RNG = np.random.default_rng(5)
N = 4000


def spread(n, still=False):
    q = RNG.uniform([0.1, 0.0, 0.0, -1.0, -1.0], [1.25, 0.7, 1.0, 1.0, 1.0], (n, 5))
    return q * [1, 1, 0, 0, 0] if still else q


def test_every_condition_is_in_one_leaf():
    q = spread(N)
    tree, leaves = grow(q, 12)
    assert len(leaves) == 12
    found = find_leaves(tree, q)
    for number, leaf in enumerate(leaves):
        assert set(leaf.rows[leaf.inside]) == set(np.flatnonzero(found == number))
        # others lie beside it, not anywhere
        assert 0.0 < 1.0 - leaf.inside.mean() < 0.6
    assert np.bincount(found).min() > N / 12 / 3


def test_children_come_after_their_parents():
    tree, _ = grow(spread(N), 9)
    own = np.arange(len(tree.axis))[:, None]
    assert ((tree.child < 0) | (tree.child > own)).all()


def test_what_cannot_be_told_apart_is_not_cut():
    q = np.tile([[0.5, 0.3, 0.2, 0.0, 0.0]], (100, 1))
    tree, leaves = grow(q, 4)
    assert (len(tree.axis), len(leaves)) == (0, 1)
    q[50:, 3] = 1.0
    tree, leaves = grow(q, 4)
    assert len(leaves) == 2


def test_a_spin_leads_to_leaves_of_its_own_and_the_draw_finds_them():
    still, spinning = grow(spread(N, still=True), 3), grow(spread(N), 8)
    tree = joined(still[0], 3, spinning[0])
    q = np.concatenate([spread(50, still=True), spread(50)])
    q[60:70, 2:] *= 1e-9
    found = find_leaves(tree, q)
    no_spin = np.sum(q[:, 2:] ** 2, axis=1) < 1e-12
    assert (found[no_spin] < 3).all()
    assert (found[~no_spin] >= 3).all()
    law = SimpleNamespace(
        roots=np.zeros(1, np.int32),
        node_axis=tree.axis,
        node_cut=tree.cut,
        node_child=tree.child.ravel(),
    )
    for row, leaf in zip(q, found, strict=True):
        assert find_leaf(law, 0, np.append(row, np.sum(row[2:] ** 2)), 0) == leaf


def test_single_leaves_join_as_well():
    tree = joined(grow(spread(10, still=True), 1)[0], 1, grow(spread(10), 1)[0])
    q = np.array([[0.5, 0.5, 0.0, 0.0, 0.0], [0.5, 0.5, 0.1, 0.0, 0.0]])
    assert find_leaves(tree, q).tolist() == [0, 1]
