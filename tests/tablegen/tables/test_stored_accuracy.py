"""A measured accuracy stored in the table: nothing else changes, and only what was measured."""

import shutil

import numpy as np
import pytest
from corrupt_tables import shifted_speeds

import sampler
from sampler.errors import InputError
from sampler.formats.hdf5 import read_table, write_table
from tablegen.accuracy.validate import validate
from tablegen.config.metric_table import METRICS
from tablegen.tables.stored_accuracy import check_store, store_accuracy

pytestmark = pytest.mark.usefixtures("quick_classifier")


@pytest.fixture
def copy(tiny, tmp_path):
    return shutil.copy(tiny.path, tmp_path / "t.h5")


def test_replaces_the_accuracy_and_nothing_else(copy):
    before, drawn = read_table(copy), sampler.load(copy).sample(0.7, 100.0, seed=1, index=range(9))
    result = validate(copy, conditions=3, samples=1000, seed=1)
    checksum = store_accuracy(copy, result)
    after = read_table(copy)
    assert checksum == after.content_sha256 != before.content_sha256
    for path, values in after.datasets.items():
        if not path.startswith("accuracy/"):
            np.testing.assert_array_equal(values, before[path])
    changing = ("content_sha256",)
    assert {n: v for n, v in after.attributes.items() if n not in changing} == {
        n: v for n, v in before.attributes.items() if n not in changing
    }
    np.testing.assert_array_equal(
        sampler.load(copy).sample(0.7, 100.0, seed=1, index=range(9)), drawn
    )
    assert after["accuracy/alpha_deg"].tolist() == [c.alpha_deg for c in result.comparisons]
    for name in METRICS:
        measured = [c.distances()[name] for c in result.comparisons]
        assert after[f"accuracy/{name}"].tolist() == measured


def test_another_table_than_was_measured_is_left_alone(copy):
    result = validate(copy, conditions=1, samples=1000, seed=1)
    write_table(copy, shifted_speeds(read_table(copy)))
    before = read_table(copy).content_sha256
    with pytest.raises(InputError, match="changed since it was measured"):
        store_accuracy(copy, result)
    assert read_table(copy).content_sha256 == before


def test_chosen_conditions_and_names_are_refused(copy):
    with pytest.raises(InputError, match="--store: got it with --alpha and --speed"):
        check_store(copy, True)
    with pytest.raises(InputError, match="--store: got the name 'corundum-steel', allowed: the"):
        check_store("corundum-steel", False)
    check_store(copy, False)
