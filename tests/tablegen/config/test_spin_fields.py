"""Whether a table has a spin law: said in a file, inherited by scenes, or refused."""

import pytest
from tiny_tables import TINY

from sampler.errors import InputError
from tablegen.config.config import load_config, parse_config

SPINNING = TINY.with_changes({"spin": True})


def test_is_left_out_unless_a_file_asks_for_it():
    text = TINY.text.replace("spin = false\n", "")
    assert not parse_config(text, "t.toml").spin
    assert parse_config(text.replace("[pair]", "spin = true\n[pair]", 1), "t.toml").spin
    for scene in ("demo", "no-spin", "plane-flow", "wear"):
        assert not load_config(scene).spin


def test_scenes_inherit_it_but_not_with_other_components():
    assert SPINNING.with_changes({"domain": {"speed": [60.0, 100.0]}}).spin
    assert not SPINNING.with_changes({"domain": {"dimension": 2}}).spin
    assert not SPINNING.with_changes({"domain": {"components": ["u", "v"]}}).spin
    assert SPINNING.with_changes({"domain": {"dimension": 2}, "spin": True}).spin


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        (
            {"spin": True, "domain": {"components": ["u", "v", "collisions", "work_shear"]}},
            "spin: got true, allowed: false with collisions, work_shear among the components, "
            "which it does not give",
        ),
        ({"spin": "yes"}, "spin: got 'yes', allowed: a valid boolean"),
        (
            {"table": {"spin_groups": 9}},
            "table.spin_groups: got 9, allowed: less than or equal to 8",
        ),
        (
            {"table": {"spin_leaves": 0}},
            "table.spin_leaves: got 0, allowed: greater than or equal to 1",
        ),
        (
            {"table": {"spin_rebounds": 10}},
            "table.spin_rebounds: got 10, allowed: greater than or ",
        ),
    ],
)
def test_refusals(changes, line):
    with pytest.raises(InputError) as caught:
        TINY.with_changes(changes)
    assert line in str(caught.value)
    assert "\n" not in str(caught.value)
