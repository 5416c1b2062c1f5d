"""Sizes of nodes and of spin laws, which follow the accuracy."""

import pytest
from tiny_tables import ROUGH

from tablegen.fitting.resolution import resolution, spin_sizes


def test_sizes_follow_the_accuracy():
    chosen = ROUGH.with_changes({"table": {"samples_per_node": None, "quantile_knots": None}})
    presets = ({"accuracy": {"preset": name}} for name in ("compact", "fine"))
    coarse, fine = (resolution(chosen.with_changes(preset)) for preset in presets)
    assert coarse.knots < fine.knots
    assert coarse.samples < fine.samples == pytest.approx(40.0 / 0.005**2, rel=1e-12)


def test_shapes_share_the_leaves_of_a_preset():
    prisms = {"ellipsoid": 0.0, "prism": 1.0, "truncated-prism": 0.0, "tetrahedron": 0.0}
    (one,) = spin_sizes(ROUGH.with_changes({"population": {"shapes": prisms}})).values()
    four = list(spin_sizes(ROUGH).values())
    # ellipsoids, which come first, have twice as many as each of the others
    assert (one.leaves, one.nonspinning_leaves) == (5 * four[1].leaves, 5 * four[1].nonspinning_leaves)
    assert four[0].leaves == 2 * four[1].leaves
    assert four[1] == four[2] == four[3]
