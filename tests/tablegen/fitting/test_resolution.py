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
    one = spin_sizes(ROUGH.with_changes({"population": {"shapes": prisms}}))
    four = spin_sizes(ROUGH)
    assert (one.leaves, one.nonspinning_leaves) == (4 * four.leaves, 4 * four.nonspinning_leaves)
