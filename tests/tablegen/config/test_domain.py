"""What a scene asks for: components and dimension."""

import pytest

from sampler.formats.channels import STATE, VARIABLES, WORKS
from tablegen.config.config import load_config, parse_config

HEAD = 'name = "scene"\npair = "corundum-steel"\n[domain]\n'


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
        (f"components = {list(VARIABLES[7::-1])}", VARIABLES[:8]),
        ('components = ["work_shear", "work_normal", "v"]', ("v", *WORKS)),
        ('dimension = 2\ncomponents = ["work_normal"]', ("work_normal",)),
    ],
)
def test_columns_come_in_the_order_of_all_components(domain, columns):
    config = parse_config(f"{HEAD}{domain}\n", "scene.toml")
    assert config.domain.columns == columns
    assert parse_config(config.text, "stored") == config


def test_scenes_that_come_with_the_package():
    assert load_config("plane-flow").domain.columns == ("u", "v", "omega_z")
    assert load_config("no-spin").domain.columns == ("u", "v")
    assert load_config("wear").domain.columns == (*STATE, *WORKS)
    assert load_config("corundum-steel").domain.columns == STATE
