"""Validation of a spin law: with today's law under one verdict, in text, page, JSON and file.

The table is the tiny one; its spin law is direct simulation itself, right or wrong.
"""

import json
import sys
from dataclasses import replace

import numpy as np
import pytest
from page_reader import read_page
from spin_laws import WRONG, DirectTable
from spin_tables import with_spin_law
from tiny_tables import TINY

from sampler.commands.program import DONE, MISSED
from sampler.errors import InputError
from sampler.formats.hdf5 import read_table, write_table
from sampler.table import Table
from tablegen.accuracy.accuracy_text import condition_text
from tablegen.accuracy.spin_text import spin_lines
from tablegen.accuracy.validate import validate
from tablegen.accuracy.validation_text import coverage_lines
from tablegen.config.metric_table import METRICS, SPIN_PRESETS
from tablegen.evidence.page import validation_page
from tablegen.tables.stored_accuracy import store_accuracy

pytestmark = pytest.mark.usefixtures("quick_classifier")

#: The module; in the package its name stands for the function.
VALIDATE = sys.modules[validate.__module__]

SPINNING = TINY.with_changes({"spin": True})

#: What a right law has with so few states.
WIDE = "spin_ks=0.08,spin_sliced_wasserstein=0.2,spin_correlation_error=0.4,spin_auc=0.7"
WIDE += ",spin_joint_ks=0.08,spin_joint_auc=0.56"
HOW = {"conditions": 1, "spin_conditions": 2, "samples": 2000, "seed": 1, "accuracy": WIDE}


@pytest.fixture
def spinning(tiny, tmp_path, monkeypatch):
    """Give the tiny table a spin law, changed as one of the wrong ones if named; its path."""

    def give(name=None):
        law = DirectTable(SPINNING, *WRONG[name] if name else ())

        class SpinTable(Table):
            def sample(self, alpha1, speed, *, spin=None, **keys):
                if spin is None:
                    return super().sample(alpha1, speed, **keys)
                return law.sample(alpha1, speed, spin=spin, **keys)

        monkeypatch.setattr(VALIDATE, "Table", SpinTable)
        path = tmp_path / "spinning.h5"
        contents = with_spin_law(tiny.generated.table.contents)
        write_table(path, replace(contents, config=SPINNING.text))
        return path

    return give


class TestVerdict:
    def test_right_law_holds(self, spinning):
        found = validate(spinning(), **HOW)
        assert found.spin.asked.ks == 0.08
        assert found.spin.declared.ks == SPIN_PRESETS["standard"]["ks"]
        assert [line for line in found.missed + found.undecided if line[:4] == "spin"] == []
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
    def test_conditions(self, spinning):
        path = spinning()
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
        with pytest.raises(InputError, match=r"alpha: got 0\.1 degrees, allowed: 0\.5 to 90"):
            validate(path, at=[(0.1, 100.0, spin)], **HOW)

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
        assert record["asked"]["joint_auc"] == 0.56
        assert record["joint"]["estimates"]["auc"]["verdict"] == "holds"
        assert record["joint"]["auc_without_grain"] < 0.56
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
        assert "at: got a spin, allowed: none" in refused("validate", tiny.path, *words[:8])


class TestAgreement:
    @pytest.mark.parametrize(
        ("has", "line"),
        [
            (True, "spin: got a spin law, allowed: none, as the table's configuration says"),
            (False, "spin: got no spin law, allowed: one, as the table's configuration says"),
        ],
    )
    def test_with_the_configuration_is_asked_for(self, tiny, tmp_path, has, line):
        contents = tiny.generated.table.contents
        contents = with_spin_law(contents) if has else replace(contents, config=SPINNING.text)
        write_table(tmp_path / "t.h5", contents)
        with pytest.raises(InputError, match=line):
            validate(tmp_path / "t.h5", **HOW)


class TestStored:
    def test_beside_todays_accuracy(self, spinning):
        path = spinning()
        found = validate(path, **HOW)
        store_accuracy(path, found)
        after = read_table(path)
        spins = [list(c.spin) for c in found.spin.measured.comparisons]
        assert after["spin_accuracy/spin"].tolist() == spins
        joint = found.spin.measured.joint.estimates
        assert after["spin_accuracy/joint_auc"].tolist() == [joint["auc"].value]
        assert after["spin_accuracy/joint_ks"].tolist() == [list(joint["ks"].by_variable)]
        again = validate(path, **HOW)
        assert again.spin.stored == again.spin.worst
        assert again.spin.surpassed(again.together) == {}
        assert "The file says of its spin law, at worst: KS " in "\n".join(coverage_lines(again))

    def test_is_contradicted_by_a_wrong_law(self, spinning):
        path = spinning()
        store_accuracy(path, validate(path, **HOW))
        stored = read_table(path)
        write_table(spinning("spin ignored"), stored)
        found = validate(path, **HOW)
        assert found.spin.surpassed(found.together)["ks"] > 0.2
        text = "\n".join(coverage_lines(found))
        assert "Note: the error of the spin law is larger than the file says, at least KS" in text

    def test_not_what_was_not_measured(self, spinning):
        path = spinning()
        store_accuracy(path, validate(path, **HOW))
        before = read_table(path)["spin_accuracy/ks"]
        store_accuracy(path, validate(path, **HOW | {"spin_conditions": 0, "seed": 2}))
        np.testing.assert_array_equal(read_table(path)["spin_accuracy/ks"], before)
