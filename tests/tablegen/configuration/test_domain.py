"""What a scene asks for: components and dimension, and one clear line for each mistake."""

import pytest

from sampler.errors import InputError
from sampler.formats.channels import COMPONENTS, STATE
from tablegen.config import load_config, parse_config

HEAD = 'name = "scene"\npair = "corundum-steel"\n[domain]\n'
SOME = f"a list of some of {', '.join(COMPONENTS)}"


@pytest.mark.parametrize(
    ("domain", "columns"),
    [
        ("", STATE),
        ("dimension = 3", STATE),
        ("dimension = 2", ("u", "v", "omega_z")),
        ('components = ["omega_z", "v"]', ("v", "omega_z")),
        ('components = ["collisions"]', ("collisions",)),
        ('dimension = 2\ncomponents = ["v", "u"]', ("u", "v")),
        ('dimension = 2\ncomponents = ["rotational_energy", "v"]', ("v", "rotational_energy")),
        (f"components = {list(COMPONENTS[::-1])}", COMPONENTS),
    ],
)
def test_columns_come_in_the_order_of_all_components(domain, columns):
    config = parse_config(f"{HEAD}{domain}\n", "scene.toml")
    assert config.domain.columns == columns
    assert parse_config(config.text, "stored") == config


def test_scenes_that_come_with_the_package():
    assert load_config("plane-flow").domain.columns == ("u", "v", "omega_z")
    assert load_config("no-spin").domain.columns == ("u", "v")
    assert load_config("corundum-steel").domain.columns == STATE


@pytest.mark.parametrize(
    ("domain", "line"),
    [
        ("components = []", f"components: got [], allowed: {SOME}"),
        ('components = ["u", "q"]', f"components: got ['u', 'q'], allowed: {SOME}"),
        ('components = ["U"]', f"components: got ['U'], allowed: {SOME}"),
        ("components = [1]", f"components: got [1], allowed: {SOME}"),
        ('components = [["u"]]', f"components: got [['u']], allowed: {SOME}"),
        ('components = "u"', f"components: got 'u', allowed: {SOME}"),
        ("components = true", f"components: got true, allowed: {SOME}"),
        ('components = ["u", "u"]', "components: got ['u', 'u'], allowed: each component once"),
        ("dimension = 1", "dimension: got 1, allowed: 2 or 3"),
        ("dimension = true", "dimension: got true, allowed: 2 or 3"),
        ('dimension = "2"', "dimension: got '2', allowed: 2 or 3"),
        (
            'dimension = 2\ncomponents = ["u", "w"]',
            "components: got ['u', 'w'], allowed: without w in a plane flow (dimension = 2)",
        ),
        (
            'dimension = 2\ncomponents = ["omega_y", "omega_x"]',
            "components: got ['omega_y', 'omega_x'], "
            "allowed: without omega_x, omega_y in a plane flow (dimension = 2)",
        ),
    ],
)
def test_mistakes_get_one_line(domain, line):
    with pytest.raises(InputError) as caught:
        parse_config(f"{HEAD}{domain}\n", "scene.toml")
    assert str(caught.value) == f"scene.toml: domain.{line}"
