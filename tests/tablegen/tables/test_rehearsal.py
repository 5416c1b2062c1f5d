"""What would refuse a finished table does so before the first piece is made."""

import numpy as np
import pytest
from tiny_tables import REFINE, ROUGH

from sampler.errors import InputError, TableError
from tablegen.tables.generate import generate
from tablegen.tables.rehearsal import rehearse

SPHERES = {
    "ellipsoid": 0.0,
    "prism": 0.0,
    "truncated-prism": 0.0,
    "tetrahedron": 0.0,
    "sphere": 1.0,
}


def constant(value):
    return {"law": "constant", "value": value, "source": "a test"}


@pytest.fixture
def refused(tmp_path, monkeypatch):
    """Generate what is refused before a node is fitted, and leaves nothing; returns the line."""

    def line(config, **settings):
        monkeypatch.setattr(REFINE, "fit_node", None)
        with pytest.raises(InputError) as caught:
            generate(config, tmp_path / "t.h5", **settings)
        assert list(tmp_path.iterdir()) == []
        return str(caught.value)

    return line


def test_leaves_nothing_where_all_is_well(tmp_path):
    rehearse(ROUGH, tmp_path / "t.h5")
    assert list(tmp_path.iterdir()) == []


def test_nodes_that_are_too_close(refused):
    nodes = [35.0, 35.0001, 45.0]
    line = refused(ROUGH.with_changes({"table": {"alpha_nodes_deg": nodes}}))
    assert line.startswith("table.alpha_nodes_deg: got 35 and 35.0001, ")


def test_anything_that_the_file_format_refuses(refused, monkeypatch):
    monkeypatch.setattr(
        "tablegen.tables.assembly.variate_knots", lambda count: np.linspace(0.0, 1.0, count)
    )
    assert refused(ROUGH).startswith("marginals/variate_knots: got ")


def test_anything_that_the_reader_refuses(refused, monkeypatch):
    def load(path):
        assert path.is_file()
        raise TableError("as a reader says")

    monkeypatch.setattr("tablegen.tables.rehearsal.load", load)
    assert refused(ROUGH) == "as a reader says"


@pytest.mark.parametrize(
    ("settings", "line"),
    [
        ({"conditions": -1}, "conditions: got -1, allowed: 0 or more"),
        ({"samples": 999}, "samples: got 999, allowed: 1000 or more"),
    ],
)
def test_measurement_that_cannot_be_made(refused, settings, line):
    assert refused(ROUGH, **settings) == line


class TestConstantVariables:
    """Their rounding in a table would be another law to every metric."""

    @pytest.mark.parametrize("value", [0.0, 0.5, 1.0])
    def test_spheres(self, refused, value):
        changes = {
            "population": {"shapes": SPHERES},
            "pair": {"restitution": constant(value)},
            "domain": {"extrapolate": True},
        }
        assert refused(ROUGH.with_changes(changes)) == (
            "domain.components: got u, v, w, omega_x, omega_y, omega_z, the same for all particles "
            "at 35 degrees and 60 m/s, allowed: components that vary (a formula gives the others), "
            "or other particles or laws"
        )

    def test_of_frictionless_walls_may_be_left_out(self, refused, tmp_path):
        elastic = {
            "pair": {"restitution": constant(1.0), "resistance": constant(0.0)},
            "domain": {"extrapolate": True},
        }
        config = ROUGH.with_changes(elastic)
        assert refused(config).startswith("domain.components: got u, w, the same for all")
        components = {"domain": {"components": ["v", "omega_x", "omega_z", "collisions"]}}
        rehearse(config.with_changes(components), tmp_path / "t.h5")
