"""The tree of conditions: every condition is in one leaf, and cuts are where a law changes."""

import numpy as np
import pytest
from spin_laws import folded_inputs
from threadpoolctl import threadpool_limits

from sampler.formats.bounds import CONDITIONS, N_CONDITIONS, N_INPUTS, NO_SPIN
from tablegen.fitting.spin_coordinates import AXES, SPIN_AXIS
from tablegen.fitting.tree import grow_tree, join_trees

N = 6000
#: Sizes of the inputs, so that all of them count alike.
SPREADS = np.array([1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 3.0, 1.0, 1.0])


@pytest.fixture(autouse=True)
def one_blas_thread():
    """Matrices are small."""
    with threadpool_limits(limits=1, user_api="blas"):
        yield


def make_outcomes(inputs, rng):
    """Make outcomes that depend smoothly on all inputs, one for each condition."""
    slopes = np.random.default_rng(1).normal(0.0, 0.3, (9, 7)) / SPREADS[:, None]
    return np.sin(inputs[:, :N_INPUTS] @ slopes) + 0.1 * rng.standard_normal((len(inputs), 7))


def grow(inputs, leaf_count, outcomes=None):
    rng = np.random.default_rng(5)
    outcomes = make_outcomes(inputs, rng) if outcomes is None else outcomes
    return grow_tree(inputs, outcomes.__getitem__, leaf_count, rng)


def find_leaves(tree, inputs):
    """Find the leaf numbers, (n,), of folded inputs (n, 13), as a draw finds them."""
    square = np.sum(inputs[:, 2:5] ** 2, axis=1)
    ratios = inputs[:, N_CONDITIONS:N_INPUTS]
    values = np.column_stack([inputs[:, :N_CONDITIONS], square, ratios])
    at = np.zeros(len(inputs), dtype=np.int64)
    while (going := np.flatnonzero(at >= 0)).size:
        node = at[going]
        side = values[going, tree.axis[node]] >= tree.cut[node]
        at[going] = tree.child[node, side.astype(np.int64)]
    return -1 - at


def test_every_condition_is_in_one_leaf():
    inputs = folded_inputs(N, np.random.default_rng(2))
    tree, leaves = grow(inputs, 12)
    assert len(leaves) == 12
    leaf_numbers = find_leaves(tree, inputs)
    for number, leaf in enumerate(leaves):
        assert set(leaf.rows[leaf.inside]) == set(np.flatnonzero(leaf_numbers == number))
        # some more lie beside it
        assert 0.0 < 1.0 - leaf.inside.mean() < 0.4
    assert np.bincount(leaf_numbers).min() > N / 12 / 4
    node_numbers = np.arange(len(tree.axis))[:, None]
    assert ((tree.child < 0) | (tree.child > node_numbers)).all()


@pytest.mark.parametrize("column", range(9))
def test_a_law_is_cut_where_it_has_a_step(column):
    """A step at the median of one input, which no quadratic function follows."""
    rng = np.random.default_rng(column)
    inputs = folded_inputs(N, rng)
    step = inputs[:, column] > np.median(inputs[:, column])
    outcomes = make_outcomes(inputs, rng) + 2.0 * step[:, None] * [1.0, 1.0, 0, 0, 1.0, 0, 0]
    tree, _ = grow(inputs, 2, outcomes)
    assert tree.axis.tolist() == [AXES[column]]
    # an axis of a tree is a condition, |sigma|^2, or a ratio of the grain
    assert (tree.axis[0] < N_CONDITIONS) == (column < N_CONDITIONS)
    assert tree.axis[0] != SPIN_AXIS
    spread = np.ptp(inputs[:, column])
    assert tree.cut[0] == pytest.approx(np.median(inputs[:, column]), abs=0.03 * spread)


def test_leaves_are_small_where_the_law_bends():
    """The law waves where root_angle is below its median, and is linear above."""
    rng = np.random.default_rng(7)
    inputs = folded_inputs(N, rng)
    root_angle = inputs[:, CONDITIONS.index("root_angle")]
    low = root_angle < np.median(root_angle)
    waves = np.where(low[:, None], np.sin(20.0 * inputs[:, [0] * 7]), inputs[:, [0] * 7])
    outcomes = waves + 0.05 * rng.standard_normal((N, 7))
    tree, leaves = grow(inputs, 8, outcomes)
    assert tree.axis[0] == 0
    below = [low[leaf.rows[leaf.inside]].mean() > 0.5 for leaf in leaves]
    assert sum(below) >= 6


def test_equal_conditions_and_few_are_not_cut():
    inputs = np.tile(folded_inputs(1, np.random.default_rng(3)), (N, 1))
    noise = np.random.default_rng(4).standard_normal((N, 7))
    tree, leaves = grow(inputs, 4, noise)
    assert (len(tree.axis), len(leaves)) == (0, 1)
    few = folded_inputs(150, np.random.default_rng(3))
    assert len(grow(few, 4)[1]) == 1
    inputs[:, 3] = noise[:, 0]
    tree, leaves = grow(inputs, 4, noise)
    assert tree.axis.tolist() == [3] * 3
    assert len(leaves) == 4


def test_conditions_with_spin_have_leaves_of_their_own():
    rng = np.random.default_rng(8)
    nonspinning, spinning = (folded_inputs(N, rng, spins) for spins in (False, True))
    first, second = grow(nonspinning, 3), grow(spinning, 8)
    # of any two trees, a single leaf among them
    for below, above, leaves in ((first, second, 3), (grow(nonspinning, 1), second, 1)):
        tree = join_trees(below[0], leaves, above[0])
        assert (tree.axis[0], tree.cut[0]) == (SPIN_AXIS, NO_SPIN)
        leaf_numbers = find_leaves(tree, nonspinning)
        np.testing.assert_array_equal(leaf_numbers < leaves, True)
        if leaves > 1:
            np.testing.assert_array_equal(leaf_numbers, find_leaves(below[0], nonspinning))
        leaf_numbers = find_leaves(tree, spinning)
        np.testing.assert_array_equal(leaf_numbers, leaves + find_leaves(above[0], spinning))
    alone = join_trees(first[0], 3, grow(spinning, 1)[0])
    np.testing.assert_array_equal(find_leaves(alone, spinning), 3)
