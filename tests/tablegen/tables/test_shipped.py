"""The shipped tables: provenance and accuracy."""

import tomllib

import h5py
import numpy as np
import pytest
from corrupt_tables import shifted_speeds

import sampler
from sampler.files import data_directory, find_table
from sampler.formats.hdf5 import read_table
from sampler.table import Table
from tablegen.accuracy.conditions import pick_conditions
from tablegen.accuracy.judgement import judge
from tablegen.accuracy.measure import measure
from tablegen.config.config import load_config
from tablegen.fitting.resolution import LADDER, resolution
from tablegen.tables.axes import make_axes

CONFIG, COMPACT = load_config("corundum-steel"), "corundum-steel-compact"
#: What is asked of the table, whatever its configuration declares.
ASKED = {"ks": 0.010, "sliced_wasserstein": 0.008, "correlation_error": 0.02, "auc": 0.56}
#: Most bytes of the file: with its spin law, and of all the rest.
BYTES, BYTES_WITHOUT_SPIN = 10_200_000, 6_000_000


@pytest.fixture(scope="module")
def contents():
    return read_table(find_table("corundum-steel"))


@pytest.fixture(scope="module")
def table(contents):
    return Table(contents)


class TestProvenance:
    def test_configuration_is_the_pair_with_given_nodes(self, table):
        assert sampler.load(COMPACT).config == load_config(COMPACT).text
        configuration = load_config("corundum-steel-standard")
        assert table.config == configuration.text
        nodes = {
            "table": configuration.table.model_dump(exclude_none=True),
            "spin_accuracy": configuration.spin_accuracy.model_dump(exclude_none=True),
        }
        names = {"name": configuration.name, "pair": {"name": CONFIG.name}}
        assert CONFIG.with_changes(nodes | names).text == configuration.text

    @pytest.mark.parametrize("name", sorted(path.stem for path in data_directory().glob("*.h5")))
    def test_the_stored_configuration_is_that_of_the_file(self, name):
        """Numbers, names and sources; comments may have been written anew."""
        scene = {"corundum-steel": "corundum-steel-standard"}.get(name, name)
        stored = tomllib.loads(sampler.load(name).config)
        assert stored == tomllib.loads(load_config(scene).text)

    def test_sizes_are_the_generators(self, contents, table):
        assert contents["dependence/alias_probability"].shape[-1] in LADDER
        assert contents["marginals/quantiles"].shape[-1] == resolution(CONFIG).knots
        # a search began with such a grid, and halved intervals
        axes = make_axes(CONFIG)
        widest = np.diff(np.sqrt(axes.alpha_deg)).max()
        assert np.diff(np.sqrt(table.alpha_nodes_deg)).max() < 1.02 * widest
        assert np.isin(axes.speed, table.speed_nodes).all()

    def test_bytes_of_the_files(self):
        assert (data_directory() / f"{COMPACT}.h5").stat().st_size <= 2_000_000
        path = data_directory() / "corundum-steel.h5"
        with h5py.File(path) as file:
            spin = sum(dataset.id.get_storage_size() for dataset in file["spin"].values())
        size = path.stat().st_size
        assert size <= BYTES
        assert size - spin <= BYTES_WITHOUT_SPIN


class TestAccuracy:
    @pytest.mark.parametrize(("name", "factor"), [("corundum-steel", 1.0), (COMPACT, np.inf)])
    def test_stored_accuracy_meets_the_declared_one(self, name, factor):
        stored, declared = sampler.load(name).accuracy, load_config(name).accuracy
        assert stored["auc"].size >= 8
        for metric, asked in ASKED.items():
            assert stored[metric].max() <= getattr(declared, metric) <= factor * asked

    def test_holds_and_a_table_shifted_by_a_speed_node_is_refused(
        self, contents, table, monkeypatch
    ):
        def missed(a_table, places):
            distances = measure(a_table, CONFIG, places, seed=11, samples=20_000)
            return {number.name for number in judge(distances, CONFIG.accuracy) if not number.holds}

        places, wrong = pick_conditions(table, 2, 11), Table(shifted_speeds(contents))
        assert missed(table, places) == set()
        monkeypatch.setattr("tablegen.accuracy.metrics.TREES", 20)  # others tell it apart
        assert {"ks", "sliced_wasserstein"} <= missed(wrong, places[1:])
