"""Validation of a spin law: with today's law under one verdict, in text, page, JSON and file.

The table is the tiny one; its spin law is direct simulation itself, right or wrong.
"""

import json
import shutil
import sys

import numpy as np
import pytest
from page_reader import read_page
from spin_laws import WRONG, DirectTable
from tiny_tables import TINY

from sampler.commands.program import DONE, MISSED
from sampler.errors import InputError
from sampler.formats.hdf5 import TableContents, read_table
from sampler.table import Table
from tablegen.configuration.metric_table import METRICS, SPIN_PRESETS
from tablegen.studies.validation.accuracy_text import condition_text
from tablegen.studies.validation.spin_text import spin_lines
from tablegen.studies.validation.validation_page import validation_page
from tablegen.studies.validation.validation_text import coverage_lines
from tablegen.validate import validate

pytestmark = pytest.mark.usefixtures("quick_classifier")

#: The module; in the package its name stands for the function.
VALIDATE = sys.modules[validate.__module__]

#: What a right law has with so few states.
WIDE = "spin_ks=0.08,spin_sliced_wasserstein=0.2,spin_correlation_error=0.4,spin_auc=0.7"
WIDE += ",spin_joint_ks=0.08,spin_joint_auc=0.62"
HOW = {"conditions": 1, "spin_conditions": 2, "samples": 2000, "seed": 1, "accuracy": WIDE}


@pytest.fixture
def spinning(tiny, monkeypatch):
    """Give the tiny table a spin law, changed as one of the wrong ones if named."""

    def give(name=None):
        law = DirectTable(TINY, *WRONG[name] if name else ())

        class SpinTable(Table):
            def sample(self, alpha1, speed, *, spin=None, **keys):
                of = super() if spin is None else law
                given = {} if spin is None else {"spin": spin}
                return of.sample(alpha1, speed, **given, **keys)

        monkeypatch.setattr(VALIDATE, "Table", SpinTable)
        monkeypatch.setattr(TableContents, "has_spin", True)
        return tiny.path

    return give


class TestVerdict:
    def test_right_law_holds(self, spinning):
        found = validate(spinning(), **HOW)
        assert found.spin.asked.ks == 0.08
        assert found.spin.declared.ks == SPIN_PRESETS["standard"]["ks"]
        assert found.holds
        assert len(found.spin.measured.comparisons) == 2
        assert found.together == len(found.measured) + 3

    @pytest.mark.parametrize("name", ["sign of spin_z turned", "fresh grains for kept ones"])
    def test_wrong_law_is_missed(self, spinning, name):
        found = validate(spinning(name), **HOW)
        assert not found.holds
        assert all(line.startswith("spin ") for line in found.missed)
        assert any(line.startswith("spin joint_auc: ") for line in found.missed)

    def test_todays_law_is_measured_as_without(self, spinning, tiny):
        plain = validate(tiny.path, **HOW)
        assert plain.spin is None
        assert "spin" not in plain.comparisons[0].to_dict()
        found = validate(spinning(), **HOW)
        assert found.comparisons == plain.comparisons
        assert found.nodes == plain.nodes

    def test_none_of_it_is_looked_at_if_asked(self, spinning):
        assert validate(spinning(), **HOW | {"spin_conditions": 0}).spin is None


class TestChosen:
    def test_conditions(self, spinning, monkeypatch):
        path = spinning()
        law = {
            "spin/alpha_range_deg": np.array([35.0, 45.0]),
            "spin/speed_range": np.array([60.0, 600.0]),
        }
        monkeypatch.setattr(TableContents, "__getitem__", lambda c, name: (law | c.datasets)[name])
        spin = (0.0, 0.0, -1.0)
        found = validate(path, at=[(40.0, 100.0, spin)], **HOW)
        assert (found.comparisons, found.nodes, found.spin.measured.joint) == ([], [], None)
        (comparison,) = found.spin.measured.comparisons
        assert comparison.place == "40.00 degrees, 100.0 m/s, spin (0.00, 0.00, -1.00)"
        assert coverage_lines(found)[0] == (
            "Looked at the spin law at 1 spinning condition that you chose."
        )
        both = validate(path, at=[(40.0, 100.0, spin), (41.0, 100.0)], **HOW)
        assert [c.alpha_deg for c in both.comparisons] == [41.0]
        with pytest.raises(InputError, match="alpha: got 30 degrees, allowed: 35 to 45 degrees"):
            validate(path, at=[(30.0, 100.0, spin)], **HOW)

    def test_spin_needs_a_law(self, tiny):
        with pytest.raises(InputError, match="at: got a spin, allowed: none, of a table without"):
            validate(tiny.path, at=[(40.0, 100.0, (0.0, 0.0, 1.0))], **HOW)


@pytest.fixture
def found(spinning):
    return validate(spinning(), **HOW)


class TestShown:
    def test_in_text(self, found):
        lines = spin_lines(found.spin, False, found.together)
        assert lines[0] == "Looked at the spin law at 2 spinning conditions spread evenly."
        assert "Impacts 2 to 6 of chains" in lines[1]
        assert lines[2] == "The file stores no accuracy of its spin law."
        assert set(lines) <= set(coverage_lines(found))

    def test_on_the_page(self, found):
        texts = read_page(validation_page(found)).texts
        for comparison in found.spin.measured.comparisons:
            # in the list of distances, and with its means
            assert texts.count(condition_text(comparison)) >= 2
            for name, metric in METRICS.items():
                assert metric.text(comparison.estimates[name].value) in texts
        joint = found.spin.measured.joint
        assert f"{joint.states:,}" in texts
        assert METRICS["ks"].text(joint.estimates["ks"].value) in texts

    def test_as_json(self, found):
        record = json.loads(json.dumps(found.to_dict(), allow_nan=False))["spin"]
        assert record["declared"]["joint_auc"] == SPIN_PRESETS["standard"]["joint_auc"]
        assert record["asked"]["joint_auc"] == 0.62
        assert record["joint"]["estimates"]["auc"]["verdict"] == "holds"
        assert record["joint"]["auc_without_grain"] < 0.62
        for condition, c in zip(record["conditions"], found.spin.measured.comparisons, strict=True):
            assert condition["spin"] == list(c.spin)
            assert condition["estimates"]["ks"]["low"] <= condition["estimates"]["ks"]["high"]


class TestCommand:
    WORDS = ("--conditions", 1, "--spin-conditions", 2, "--samples", 2000, "--seed", 1, "--quiet")

    def test_holds(self, run, spinning, tmp_path):
        page, record = tmp_path / "v.html", tmp_path / "v.json"
        words = ("--accuracy", WIDE, "--json", record, "--html", page)
        ended = run("validate", spinning(), *self.WORDS, *words)
        assert (ended.status, ended.err) == (DONE, "")
        assert "the spin law, at spinning conditions" in ended.out
        assert "over the impacts of chains" in ended.out
        assert json.loads(record.read_text())["spin"]["joint"]["states"] > 1000
        assert "The spin law" in page.read_text()

    def test_misses(self, run, spinning):
        ended = run("validate", spinning("spin ignored"), *self.WORDS)
        assert ended.status == MISSED
        assert "missed: spin joint_ks: 0." in ended.out

    def test_spins_and_conditions_go_together(self, refused, tiny):
        words = ("--alpha", 40, "--speed", 100, "--spin", 0, 0, 1, "--spin", 0, 0, 2, "--spin", 0)
        assert refused("validate", tiny.path, *words, 0, 0, "--alpha", 41) == (
            "--alpha and --speed: got 2 and 1, allowed: as many of both, or one of either"
        )
        assert "--alpha and --speed: got 0 and 0" in refused(
            "validate", tiny.path, "--spin", 0, 0, 1
        )
        assert "at: got a spin, allowed: none" in refused("validate", tiny.path, *words[:7])


def test_may_be_stored(spinning, tmp_path, monkeypatch):
    """What a file with a spin law would be given beside today's accuracy."""
    stored = sys.modules["tablegen.studies.validation.stored_accuracy"]
    path = shutil.copy(spinning(), tmp_path / "t.h5")
    found, written = validate(path, **HOW), {}
    monkeypatch.setattr(stored, "write_table", lambda _, contents: written.update(vars(contents)))
    monkeypatch.setattr(stored, "read_table", lambda _: read_table(path))
    stored.store_accuracy(path, found)
    datasets = written["datasets"]
    assert datasets["spin_accuracy/spin"].tolist() == [
        list(c.spin) for c in found.spin.measured.comparisons
    ]
    assert datasets["spin_accuracy/joint_auc"].tolist() == [
        found.spin.measured.joint.estimates["auc"].value
    ]
