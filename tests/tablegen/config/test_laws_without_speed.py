"""Which laws depend on the speed, and that tables of the others cover every speed."""

import numpy as np
import pytest
from contact_law_samples import RESTITUTION, SOURCE
from tiny_tables import ROUGH

import sampler
from sampler.formats.hdf5 import write_table
from tablegen.checkpoints import TaskRunner
from tablegen.commands.inspect import identity, identity_text
from tablegen.config.config import load_config
from tablegen.simulation.simulate import simulate
from tablegen.tables.assembly import assemble
from tablegen.tables.axes import first_grid, make_axes
from tablegen.tables.prune import pruned
from tablegen.tables.refine import fit_nodes

POLYNOMIAL = RESTITUTION["polynomial"] | SOURCE


def tabulated(*rows):
    table = {"angle_deg": [10.0, 90.0], "speed": [50.0, 200.0][: len(rows[0])], "value": list(rows)}
    return {"law": "tabulated", **table, **SOURCE}


LAWS = [
    (POLYNOMIAL, False),
    (RESTITUTION["constant"] | SOURCE, False),
    (tabulated([0.9], [0.5]), False),
    (tabulated([0.9, 0.9], [0.5, 0.5]), False),
    (tabulated([0.9, 0.9], [0.5, 0.4]), True),
    (RESTITUTION["exponential"] | SOURCE, True),
    (RESTITUTION["power"] | SOURCE, True),
]


def with_law(law):
    changes = {"pair": {"restitution": law}, "domain": {"extrapolate": True}}
    return ROUGH.with_changes(changes)


@pytest.mark.parametrize(("law", "depends"), LAWS)
def test_laws_say_whether_the_speed_matters_and_the_model_agrees(law, depends):
    config = with_law(law)
    assert config.pair.restitution.depends_on_speed is depends
    slow, fast = (simulate(config, 0.7, speed, 50, seed=1).state for speed in (60.0, 300.0))
    assert np.allclose(slow, fast, rtol=1e-6, atol=1e-9) is not depends


@pytest.fixture(scope="module")
def contents():
    config = with_law(POLYNOMIAL)
    axes = make_axes(config)
    nodes = fit_nodes(config, first_grid(config), TaskRunner())
    return assemble(config, axes, nodes)


def test_tables_cover_every_speed(contents, tmp_path):
    write_table(tmp_path / "t.h5", contents)
    table = sampler.load(tmp_path / "t.h5", outside="raise")
    assert table.sample(0.7, [1.0, 1000.0], seed=1, index=0).shape == (2, 6)
    assert identity(table.contents)["speed_independent"] is True
    assert "60 to 300 m/s, 2 nodes, the same at any speed" in identity_text(table.contents)


def test_a_scene_of_any_speed_is_cut_from_them(contents):
    scene = with_law(POLYNOMIAL).with_changes(
        {"domain": {"speed": [1.0, 900.0], "components": ["u", "v"]}, "table": {}}
    )
    part = pruned(contents, scene)
    assert part.speed_independent
    assert part["axes/speed"].tolist() == [60.0, 300.0]


def test_shipped_laws():
    names = ("corundum-steel", "forder-1998", "grant-tabakoff-1975")
    found = [load_config(name).pair.restitution.depends_on_speed for name in names]
    assert found == [True, False, False]
