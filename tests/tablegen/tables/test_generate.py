"""Whole tables: the file, its accuracy, and bad configurations refused before any work."""

import numpy as np
import pytest
from refusals import refused
from tiny_tables import GENERATE, MEASURED, REFINE, ROUGH, TINY

import sampler
from sampler.formats.channels import WORKS, channels_for
from sampler.formats.hdf5 import read_table
from tablegen.accuracy.validate import validate
from tablegen.config.config import parse_config
from tablegen.config.metric_table import METRICS
from tablegen.fitting.marginals import round_quantiles
from tablegen.fitting.node import fit_node
from tablegen.tables.generate import generate
from tablegen.tables.plan import make_plan
from tablegen.tables.prune import pruned
from tablegen.tables.rehearsal import rehearse

pytestmark = pytest.mark.usefixtures("quick_measurement", "quick_classifier")


class TestFile:
    def test_configuration_makes_the_same_table_again(self, tiny, tmp_path):
        path = tmp_path / "again.h5"
        generate(parse_config(sampler.load(tiny.path).config, "t"), path, conditions=2)
        assert path.read_bytes() == tiny.path.read_bytes()

    def test_nodes_lie_row_by_row(self, tiny):
        contents = read_table(tiny.path)
        for i, j in np.ndindex(2, 2):
            node = fit_node(TINY, (35.0, 45.0)[i], (60.0, 300.0)[j])
            stored = round_quantiles(node.quantiles)
            np.testing.assert_array_equal(contents["marginals/quantiles"][i, j], stored)
            for name in ("reflection", "mean", "cholesky", "alias_index", "first_of_class"):
                stored = contents[f"dependence/{name}"][i, j]
                np.testing.assert_array_equal(stored, getattr(node, name))


@pytest.mark.parametrize("columns", [("u", "v", "omega_z"), ("v", "rotational_energy", *WORKS)])
def test_file_holds_the_columns_of_a_scene(tmp_path, columns):
    path, domain = tmp_path / "t.h5", {"variables": list(columns)}
    config = ROUGH.with_changes({"domain": domain})
    generate(config, path, conditions=1)
    contents = read_table(path)
    assert contents.variables == columns
    assert contents.channels == contents.marginals == channels_for(columns)
    size = len(contents.channels)
    assert contents["marginals/quantiles"].shape[3] == size
    assert contents["dependence/cholesky"].shape[-1] == size * (size + 1) // 2
    assert contents["accuracy/ks"].shape == (1, len(columns))
    at = validate(path, at=[(40.0, 70.0)], samples=MEASURED)
    assert at.comparisons[0].variables == columns


class TestAccuracy:
    def test_can_be_measured_again(self, tiny):
        """A validation with the generator's own seed finds the same numbers, bit by bit."""
        seed = GENERATE._MEASURE_SEED
        again = validate(tiny.path, conditions=2, seed=seed, samples=MEASURED)
        assert again.numbers == tiny.generated.validation.numbers
        assert again.comparisons == tiny.generated.validation.comparisons
        for name in METRICS:
            stored = sampler.load(tiny.path).accuracy[name]
            assert stored.tolist() == [c.distances()[name] for c in again.comparisons]
        other = validate(tiny.path, conditions=2, seed=seed + 1, samples=MEASURED)
        assert other.comparisons != tiny.generated.validation.comparisons


def test_law_without_speed_has_one_node_of_it_and_serves_any(tmp_path):
    law = {"pair": {"restitution": constant(0.5)}, "domain": {"extrapolate": True}}
    config = ROUGH.with_changes({**law, "table": {"speed_nodes": None}})
    path = tmp_path / "t.h5"
    table = generate(config, path, conditions=1).table
    assert table.speed_nodes.tolist() == [300.0]
    table.sample(0.7, [1e-3, 60.0, 5e3], seed=1, index=range(3))
    assert sum(table.counts.values()) == 0
    at = validate(path, at=[(40.0, 70.0)], samples=MEASURED)
    assert at.comparisons[0].speed == 70.0
    # a scene with other speeds keeps all
    part = pruned(read_table(path), config.with_changes({"domain": {"speed": [1.0, 900.0]}}))
    assert part.speed_independent
    assert part["axes/speed"].tolist() == [300.0]


def constant(value):
    return {"law": "constant", "value": value, "source": "a test"}


class TestRefusedBeforeAnyWork:
    @pytest.fixture
    def line(self, tmp_path, monkeypatch):
        """Generate a table that is refused for a field before a node is fitted."""

        def check(field, config, output="t.h5", **settings):
            monkeypatch.setattr(REFINE, "fit_node", None)
            line = refused(field, generate, config, tmp_path / output, **settings)
            assert list(tmp_path.iterdir()) == []
            return line

        return check

    def test_output_measurement_and_close_nodes(self, line):
        line("output", ROUGH, "none/t.h5")
        line("conditions", ROUGH, conditions=-1)
        line("samples", ROUGH, samples=999)
        nodes = {"table": {"alpha_nodes_deg": [35.0, 35.0001, 45.0]}}
        assert "35 and 35.0001" in line("table.alpha_nodes_deg", ROUGH.with_changes(nodes))

    def test_contents_that_the_file_format_refuses(self, line, monkeypatch):
        knots = "tablegen.tables.assembly.variate_knots"
        monkeypatch.setattr(knots, lambda count: np.linspace(0.0, 1.0, count))
        line("marginals/variate_knots", ROUGH)

    def test_constant_variables_may_be_left_out(self, line):
        elastic = {
            "pair": {"restitution": constant(1.0), "resistance": constant(0.0)},
            "domain": {"extrapolate": True},
        }
        config = ROUGH.with_changes(elastic)
        assert "u, w, omega_y" in line("domain.variables", config)
        variables = {"domain": {"variables": ["v", "omega_x", "omega_z", "collisions"]}}
        rehearse(make_plan(config.with_changes(variables)))
        # friction at an angle between the ends of the range is enough; round grains hit once
        resistance = {"law": "tabulated", "angle_deg": [39.0, 40.0, 41.0], "value": [0.0, 0.5, 0.0]}
        between = {
            "pair": {"resistance": resistance | {"source": "a test"}},
            "population": {
                "shapes": {"ellipsoid": 1.0},
                "aspect": {"distribution": "fixed", "values": [0.98, 0.98]},
            },
            "domain": {"variables": ["u", "w"]},
            "table": {"alpha_nodes_deg": [35.0, 40.0, 45.0]},
        }
        rehearse(make_plan(config.with_changes(between)))
