"""The configuration in a table says everything itself: it opens no file, and uses up no memory."""

import json
import re
from dataclasses import replace

import pytest
import tomli_w

from sampler.errors import InputError
from sampler.files import data_directory
from sampler.formats.hdf5 import read_table, write_table
from tablegen.accuracy.measure import sample_size
from tablegen.accuracy.validate import validate
from tablegen.config.config import load_config, stored_config

TABLE = read_table(data_directory() / "corundum-steel-compact.h5")
OWN = stored_config(TABLE.config, "shipped")


@pytest.fixture
def table(tmp_path):
    """Write the shipped table with another configuration; returns its path."""

    def write(config):
        path = tmp_path / "t.h5"
        write_table(path, replace(TABLE, config=config))
        return path

    return write


def naming_a_mesh():
    tree = OWN.model_dump(mode="json", by_alias=True, exclude_none=True)
    tree["population"]["meshes"] = [{"file": "../../../../etc/passwd"}]
    return tomli_w.dumps(tree)


NAMING_FILES = {
    'name = "a"\npair = "../../../../etc/passwd"\n': "pair: got '../../../../etc/passwd', all",
    'name = "a"\npair = "corundum-steel"\n': "pair: got 'corundum-steel', allowed: the laws of the",
    naming_a_mesh(): "population.meshes[0].vertices: missing, allowed: a value",
}


@pytest.mark.parametrize("config", NAMING_FILES, ids=["path", "name", "mesh"])
def test_no_file_is_opened(refused, table, tmp_path, monkeypatch, config):
    for function in ("read_text", "read_mesh"):
        monkeypatch.setattr(f"tablegen.config.config.{function}", None)
    path, reason = table(config), NAMING_FILES[config]
    output = ("--output", tmp_path / "s.h5")
    for words in (("validate", path), ("prune", path, "--dimension", "2", *output)):
        assert reason in refused(*words)


def test_the_shipped_one_is_complete():
    assert OWN.pair_name == load_config("corundum-steel").name


@pytest.mark.parametrize("config", ["[" * 5000, "seed = 1" + "0" * 5000, "ks = [[[["])
def test_what_is_no_configuration(run, refused, table, config):
    path = table(config)
    assert "config: " in refused("validate", path)
    assert "declared          ?" in run("inspect", path).out


@pytest.mark.parametrize("number", ["inf", "nan", "1e400", '"little"'])
def test_declared_distances_that_are_none(run, table, number):
    ended = run("inspect", table(f"[accuracy]\nks = {number}\n"), "--json")
    assert json.loads(ended.out)["declared"] is None


def test_the_accuracy_sets_no_endless_number_of_states(table):
    for ks, most in ((0.01, 400_000), (0.005, 1_600_000), (0.001, 4_000_000)):
        targets = OWN.with_changes({"accuracy": {"ks": ks}}).accuracy
        assert sample_size(targets) == pytest.approx(most, abs=1)
    text, count = re.subn("^ks = .*$", "ks = 1e-9", OWN.text, flags=re.MULTILINE)
    assert count == 1
    with pytest.raises(InputError, match=r"config: accuracy\.ks: got 1e-09, allowed: gr"):
        validate(table(text))
