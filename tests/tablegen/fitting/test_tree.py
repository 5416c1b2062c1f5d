"""The tree of conditions: every condition is in one leaf."""

import numpy as np

from tablegen.fitting.tree import grow, joined

RNG = np.random.default_rng(5)
N = 4000


def spread(n, still=False):
    q = RNG.uniform([0.1, 0.0, 0.0, -1.0, -1.0], [1.25, 0.7, 1.0, 1.0, 1.0], (n, 5))
    return q * [1, 1, 0, 0, 0] if still else q


def grown(q, wanted):
    return grow(q, wanted, np.ones(len(q), dtype=bool))


def find_leaves(tree, q):
    """Find the leaf numbers, (n,), of folded conditions (n, 5)."""
    values = np.column_stack([q, np.sum(q[:, 2:] ** 2, axis=1)])
    at = np.zeros(len(q), dtype=np.int64)
    while (going := np.flatnonzero(at >= 0)).size:
        node = at[going]
        side = values[going, tree.axis[node]] >= tree.cut[node]
        at[going] = tree.child[node, side.astype(np.int64)]
    return -1 - at


def test_every_condition_is_in_one_leaf():
    q = spread(N)
    tree, leaves = grown(q, 12)
    assert len(leaves) == 12
    found = find_leaves(tree, q)
    for number, leaf in enumerate(leaves):
        assert set(leaf.rows[leaf.inside]) == set(np.flatnonzero(found == number))
        # some more lie beside it
        assert 0.0 < 1.0 - leaf.inside.mean() < 0.6
    assert np.bincount(found).min() > N / 12 / 3
    own = np.arange(len(tree.axis))[:, None]
    assert ((tree.child < 0) | (tree.child > own)).all()


def test_equal_conditions_are_not_cut():
    q = np.tile([[0.5, 0.3, 0.2, 0.0, 0.0]], (100, 1))
    tree, leaves = grown(q, 4)
    assert (len(tree.axis), len(leaves)) == (0, 1)
    q[50:, 3] = 1.0
    tree, leaves = grown(q, 4)
    assert len(leaves) == 2


def test_conditions_with_spin_have_leaves_of_their_own():
    still, spinning = grown(spread(N, still=True), 3), grown(spread(N), 8)
    tree = joined(still[0], 3, spinning[0])
    q = np.concatenate([spread(50, still=True), spread(50)])
    q[60:70, 2:] *= 1e-9
    found = find_leaves(tree, q)
    no_spin = np.sum(q[:, 2:] ** 2, axis=1) < 1e-12
    np.testing.assert_array_equal(found[no_spin], find_leaves(still[0], q[no_spin]))
    np.testing.assert_array_equal(found[~no_spin], 3 + find_leaves(spinning[0], q[~no_spin]))
