"""What `generate` measures of a spin law, stores and says; the law itself is random numbers."""

import numpy as np
import pytest
from spin_tables import spin_datasets
from tiny_tables import GENERATE, MEASURED, ROUGH

from sampler.formats.hdf5 import read_table
from sampler.options import MISSED
from tablegen.accuracy.spin_conditions import pick_spin_conditions
from tablegen.config.metric_table import METRICS, worst_spin_stored

pytestmark = pytest.mark.usefixtures("quick_measurement", "quick_classifier")

LAW = spin_datasets(codes=(0, 1, 2, 3), depth=1)


@pytest.fixture
def random_law(monkeypatch):
    """A spin law that no simulation made."""
    monkeypatch.setattr(GENERATE, "spin_law", lambda *_: LAW)


@pytest.fixture
def config_file(tmp_path):
    path = tmp_path / "spinning.toml"
    accuracy = {"preset": "compact", "ks": 0.5, "joint_auc": 0.9}
    path.write_text(ROUGH.with_changes({"spin": True, "spin_accuracy": accuracy}).text)
    return path


@pytest.mark.usefixtures("random_law")
def test_is_stored_and_missed(run, config_file, tmp_path):
    output = tmp_path / "t.h5"
    words = ("--output", output, "--conditions", 1, "--samples", MEASURED, "--quiet")
    ended = run("generate", config_file, *words)
    assert (ended.status, ended.err) == (MISSED, "")
    contents = read_table(output)
    places = pick_spin_conditions(ROUGH, 3, GENERATE._MEASURE_SEED)
    assert contents["spin_accuracy/alpha_deg"].tolist() == [p.alpha_deg for p in places]
    np.testing.assert_array_equal(contents["spin_accuracy/spin"], [p.spin for p in places])
    assert contents["spin_accuracy/joint_ks"].shape == (1, 6)
    worst = worst_spin_stored(contents.datasets)
    assert worst["ks"] > 0.3
    assert worst["joint_auc"] > 0.9
    assert "the spin law, at spinning conditions" in ended.out
    assert "missed: spin joint_auc: " in ended.out
    assert METRICS["auc"].text(worst["joint_auc"]) in ended.out
    np.testing.assert_array_equal(contents["spin/mean"], LAW["spin/mean"])
