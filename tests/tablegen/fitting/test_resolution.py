"""Sizes of nodes and of spin laws, which follow the accuracy."""

import math

import pytest
from tiny_tables import ROUGH

from sampler.formats.bounds import GROUP_SIZE, N_GROUPS
from sampler.formats.shape_codes import SHAPE_CODES
from tablegen.fitting.resolution import SPIN_SIZES, resolution, spin_sizes

ELLIPSOID, PRISM, SPHERE = (SHAPE_CODES[name] for name in ("ellipsoid", "prism", "sphere"))
ALONE = {"ellipsoid": 0.0, "prism": 1.0, "truncated-prism": 0.0, "tetrahedron": 0.0}


def test_sizes_follow_the_accuracy():
    chosen = ROUGH.with_changes({"table": {"samples_per_node": None, "quantile_knots": None}})
    presets = ({"accuracy": {"preset": name}} for name in ("compact", "fine"))
    coarse, fine = (resolution(chosen.with_changes(preset)) for preset in presets)
    assert coarse.knots < fine.knots
    assert coarse.samples < fine.samples == pytest.approx(25.0 / 0.005**2, rel=1e-12)


def test_shapes_share_the_leaves_of_a_preset():
    (one,) = spin_sizes(ROUGH.with_changes({"population": {"shapes": ALONE}})).values()
    preset = SPIN_SIZES[ROUGH.accuracy.preset]
    assert one == preset
    four = spin_sizes(ROUGH)
    ellipsoids = four.pop(ELLIPSOID)
    assert len(set(four.values())) == 1
    assert ellipsoids.leaves == math.ceil(2.5 * preset.leaves / 5.5)
    assert ellipsoids.rebounds == 2 * four[PRISM].rebounds
    whole = ellipsoids.leaves + 3 * four[PRISM].leaves
    assert preset.leaves <= whole < preset.leaves + 4
    two_shapes = ALONE | {"prism": 0.5, "sphere": 0.5}
    shares = spin_sizes(ROUGH.with_changes({"population": {"shapes": two_shapes}}))
    assert shares[SPHERE].leaves < shares[PRISM].leaves / 3


def test_a_configuration_names_the_sizes_of_a_shape():
    sizes = {"spin_leaves": 8, "spin_groups": 3, "spin_experts": 2, "spin_rebounds": 2000}
    sizes_by_shape = spin_sizes(ROUGH.with_changes({"table": sizes}))
    assert {(own.leaves, *own[2:6]) for own in sizes_by_shape.values()} == {(8, 3, 2, 2, 2000)}
    assert all(own.nonspinning_leaves <= 8 for own in sizes_by_shape.values())
    assert all(own.conditions(own.leaves) >= 1000 for own in sizes_by_shape.values())


def test_a_file_has_room_for_the_experts_of_a_preset():
    for sizes in SPIN_SIZES.values():
        assert sizes.groups <= N_GROUPS
        assert sizes.experts <= GROUP_SIZE
