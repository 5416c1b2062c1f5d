"""Sizes of nodes and of spin laws, which follow the accuracy."""

import pytest
from tiny_tables import ROUGH

from sampler.formats.bounds import GROUP_SIZE, N_GROUPS
from sampler.formats.shape_codes import SHAPE_CODES
from tablegen.fitting.resolution import SPIN_SIZES, resolution, spin_sizes


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


def test_a_file_has_room_for_the_experts_of_a_preset():
    for sizes in SPIN_SIZES.values():
        assert sizes.groups <= N_GROUPS
        assert sizes.experts <= GROUP_SIZE


def test_spheres_need_few_leaves_and_leaves_many_conditions():
    sizes = SPIN_SIZES["standard"]
    spheres, prisms = (sizes.of_shape(SHAPE_CODES[name]) for name in ("sphere", "prism"))
    assert prisms == sizes
    assert spheres.leaves < prisms.leaves
    assert spheres.conditions < prisms.conditions
    assert prisms.conditions > 1000 * prisms.leaves
