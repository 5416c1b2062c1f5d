"""A newly measured accuracy replaces the one in a file, and nothing else."""

import shutil

import numpy as np
import pytest
from corrupt_tables import shifted_speeds
from refusals import refused

from sampler.formats.hdf5 import read_table, write_table
from tablegen.accuracy.validate import validate
from tablegen.config.metric_table import METRICS
from tablegen.tables.assembly import store_accuracy

pytestmark = pytest.mark.usefixtures("quick_classifier")

#: As few states as there may be.
QUICK = {"conditions": 1, "samples": 1000, "seed": 1}


@pytest.fixture
def copy(tiny, tmp_path):
    return shutil.copy(tiny.path, tmp_path / "t.h5")


def test_replaces_the_accuracy_and_nothing_else(copy):
    before = read_table(copy)
    result = validate(copy, **QUICK | {"conditions": 3})
    checksum = store_accuracy(copy, result)
    after = read_table(copy)
    assert checksum == after.content_sha256 != before.content_sha256
    for path, values in after.datasets.items():
        if not path.startswith("accuracy/"):
            np.testing.assert_array_equal(values, before[path])
    assert after.attributes == before.attributes
    for name in METRICS:
        measured = [c.distances()[name] for c in result.comparisons]
        assert after[f"accuracy/{name}"].tolist() == measured


def test_another_table_than_the_measured_one_is_left_alone(copy):
    result = validate(copy, **QUICK)
    write_table(copy, shifted_speeds(read_table(copy)))
    before = read_table(copy).content_sha256
    assert "changed" in refused(copy, store_accuracy, copy, result)
    assert read_table(copy).content_sha256 == before
