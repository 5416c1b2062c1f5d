"""Validation passes a good table, refuses wrong ones, and says so in numbers.

The spin law of the spinning table is direct simulation itself, right or wrong.
"""

import json
import shutil
import sys
from dataclasses import fields, replace

import numpy as np
import pytest
from corrupt_tables import (
    declaring,
    forged,
    garbage,
    independent_channels,
    lopsided,
    shifted_speeds,
    spin_flipped,
)
from refusals import refused
from spin_laws import WRONG, DirectTable
from spin_tables import with_spin_law
from tiny_tables import TINY

import sampler
from sampler.errors import InputError
from sampler.formats.channels import STATE
from sampler.formats.hdf5 import read_table, write_table
from sampler.options import DONE, MISSED
from sampler.table import Table
from tablegen.accuracy.accuracy_text import validation_notes, validation_tables
from tablegen.accuracy.descriptive import Profile
from tablegen.accuracy.validate import validate
from tablegen.config.metric_table import METRICS, SPIN_PRESETS, worst_stored
from tablegen.tables.assembly import store_accuracy

pytestmark = pytest.mark.usefixtures("quick_classifier")

#: The module; in the package its name stands for the function.
VALIDATE = sys.modules[validate.__module__]

#: Accuracy of the tiny table at its nodes and between them: nodes fitted to 6000 states are off by
#: 0.02 in the Kolmogorov-Smirnov distance and 0.03 in a correlation, and interpolation adds 0.015.
#: A right table is said to miss it once in a hundred validations, at most.
TIGHT = {"ks": 0.06, "sliced_wasserstein": 0.06, "correlation_error": 0.13, "auc": 0.72}

#: As few states as there may be.
QUICK = {"conditions": 1, "samples": 1000, "seed": 1}


@pytest.fixture
def validated(tiny, tmp_path):
    """Validate the tiny table, tampered with by a function, at the tight declared accuracy."""

    def run(tamper=lambda contents: contents):
        path = tmp_path / "tight.h5"
        write_table(path, declaring(tamper(tiny.generated.table.contents), **TIGHT))
        return validate(path, conditions=2, samples=4000, seed=1)

    return run


def relabelled(contents):
    """The table of one pair with the configuration of another."""
    text = contents.config.replace("coefficient = 0.1", "coefficient = 0.03")
    assert text != contents.config
    return replace(contents, config=text)


class TestVerdict:
    def test_right_table_holds(self, tiny, validated):
        found = validate(tiny.path, conditions=2, samples=4000, seed=1)
        assert found.holds
        assert found.law.declared == found.law.asked == TINY.accuracy
        assert validated().missed == []

    @pytest.mark.parametrize(
        ("tamper", "metrics"),
        [
            (independent_channels, {"sliced_wasserstein", "correlation_error", "auc"}),
            (shifted_speeds, {"ks"}),
            (lopsided, {"ks"}),
            # the configuration is what counts: the simulation follows it, not the table
            (relabelled, {"ks"}),
        ],
    )
    def test_wrong_tables_are_refused(self, validated, tamper, metrics):
        found = validated(tamper)
        assert not found.holds
        assert {line.split(":")[0] for line in found.missed} >= metrics

    def test_a_wrong_node_that_no_condition_meets_is_found(self, validated):
        found = validated(lambda contents: spin_flipped(contents, (1, 1)))
        assert (45.0, 300.0) in found.screening.suspects
        assert any("at 45.00 degrees, 300.0 m/s" in line for line in found.missed)

    def test_forged_accuracy_is_contradicted(self, tiny, tmp_path):
        """Garbage at all nodes, a lenient declaration and a stored accuracy of 0 are noted."""
        path = tmp_path / "forged.h5"
        contents = tiny.generated.table.contents
        write_table(path, forged(garbage(contents, np.ones((2, 2), dtype=bool))))
        found = validate(path, **QUICK)
        assert found.holds
        assert found.law.stored["ks"] == 0.0
        assert found.law.surpassed(found.together)["ks"] > 0.3
        text = "\n".join(validation_notes(found))
        assert "Note: the table declares little: ks 1," in text
        assert "Note: the error is larger than the file says, at least KS 0." in text
        right = validate(tiny.path, **QUICK)
        assert right.law.stored == worst_stored(sampler.load(tiny.path).accuracy)
        assert right.law.surpassed(right.together) == {}


class TestResult:
    def test_as_json(self, tiny):
        found = validate(tiny.path, **QUICK)
        record = json.loads(json.dumps(found.to_dict(), allow_nan=False))
        assert record["holds"] is found.holds
        assert record["declared"] == record["asked"] == TINY.accuracy.model_dump()
        assert (record["seed"], record["false_alarms"]) == (1, 0.01)
        assert record["missed"] + record["undecided"] == found.missed + found.undecided
        assert record["screening"]["nodes"] == 4
        nodes = [(c["alpha_deg"], c["speed"]) for c in record["nodes"]]
        assert nodes == list(found.screening.suspects)
        records = record["conditions"] + record["nodes"]
        for condition, comparison in zip(records, found.law.measured.measured, strict=True):
            assert condition["components"] == list(STATE)
            assert condition["states"] == comparison.states >= 1000
            assert {name: condition[name] for name in METRICS} == comparison.distances()
            assert set(condition["direct"]) == {field.name for field in fields(Profile)}
            for estimate in condition["estimates"].values():
                assert 0.0 <= estimate["low"] <= estimate["high"]
                assert estimate["verdict"] in ("holds", "undecided", "missed")


ENDS, SPEEDS = [30.0, 45.0], [60.0, 250.0]


class TestRefusals:
    @pytest.mark.parametrize("value", [0, 2.5])
    def test_arguments(self, tiny, value):
        refused("conditions", validate, tiny.path, conditions=value)

    @pytest.mark.parametrize(
        ("field", "change"),
        [
            ("pair", {"pair": "titanium-glass"}),
            ("config", {"config": "name = "}),
            ("axes/alpha_deg", {"domain": {"alpha_deg": ENDS}, "table": {"alpha_nodes_deg": ENDS}}),
            ("axes/speed", {"domain": {"speed": SPEEDS}, "table": {"speed_nodes": SPEEDS}}),
            ("components", {"domain": {"components": ["u", "v"]}}),
            ("spin law", {"spin": True}),
        ],
    )
    def test_a_file_that_contradicts_its_configuration(self, tiny, tmp_path, field, change):
        if set(change) <= {"domain", "table", "spin"}:
            change = {"config": TINY.with_changes(change).text}
        path = tmp_path / "t.h5"
        write_table(path, replace(tiny.generated.table.contents, **change))
        with pytest.raises(InputError, match=rf"{field}: "):
            validate(path)


SPINNING = TINY.with_changes({"spin": True})

#: Accuracy of a right spin law with few states.
WIDE = "spin_ks=0.08,spin_sliced_wasserstein=0.2,spin_correlation_error=0.4,spin_auc=0.7"
WIDE += ",spin_joint_ks=0.08,spin_joint_auc=0.56,spin_cell_ks=0.3,spin_cell_energy=0.5"
WIDE += ",spin_chain_ks=0.3,spin_chain_energy=0.6,spin_chain_spin=0.6"
HOW = {"conditions": 1, "samples": 1000, "seed": 1, "accuracy": WIDE}


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


class TestSpinLaw:
    def test_right_law_holds_and_the_first_impact_law_is_measured_as_without(self, spinning, tiny):
        path, plain = spinning(), validate(tiny.path, **HOW)
        found = validate(path, **HOW)
        assert (found.spin.asked.ks, plain.spin) == (0.08, None)
        assert found.spin.declared.ks == SPIN_PRESETS["standard"]["ks"]
        assert [line for line in found.missed + found.undecided if line[:4] == "spin"] == []
        spin = found.spin.measured
        later = len(spin.cells) + len(spin.hits)
        assert found.together == plain.together + 2 + later
        assert later == 18  # no chain begins within its angles
        assert found.law.measured == plain.law.measured
        record = json.loads(json.dumps(found.to_dict(), allow_nan=False))["spin"]
        assert record["asked"]["joint_auc"] == 0.56
        assert record["joint"]["estimates"]["auc"]["verdict"] == "holds"
        assert len(record["later"]) == later
        assert all(condition["own"] for condition in record["conditions"])
        assert len(validation_tables(found)) == 5
        # stored beside the other accuracy, and kept where nothing of it is measured again
        store_accuracy(path, found)
        after = read_table(path)
        joint = found.spin.measured.joint.estimates
        assert after["spin_accuracy/spin"].tolist() == [[0.0, 0.0, 0.0]]
        assert after["spin_accuracy/cell_ks"].shape == (len(spin.cells),)
        assert after["spin_accuracy/joint_ks"].tolist() == [list(joint["ks"].by_variable)]

    @pytest.mark.study  # `test_command` refuses another
    @pytest.mark.parametrize("name", ["sign of spin_z turned", "fresh grains for kept ones"])
    def test_wrong_law_is_missed(self, spinning, name):
        found = validate(spinning(name), **HOW)
        assert any(line.startswith("spin joint_auc: ") for line in found.missed)
        assert all(line.startswith("spin ") for line in found.missed)

    def test_command(self, run, spinning, tmp_path):
        words = ("--conditions", 1, "--samples", 1000, "--seed", 1)
        page = tmp_path / "v.html"
        ended = run("validate", spinning(), *words, "--accuracy", WIDE, "--html", page, "--quiet")
        assert (ended.status, ended.err) == (DONE, "")
        assert ended.out.startswith("The accuracy asked for holds at every condition.\n")
        assert "Spin law, over the impacts of chains" in page.read_text()
        ended = run("validate", spinning("spin ignored"), *words, "--quiet")
        assert ended.status == MISSED
        assert "\nmissed: spin joint_ks: 0." in ended.out
        assert "\nmissed: spin joint_auc: 0." in ended.out


class TestStore:
    @pytest.fixture
    def copy(self, tiny, tmp_path):
        return shutil.copy(tiny.path, tmp_path / "t.h5")

    def test_replaces_the_accuracy_and_nothing_else(self, copy):
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

    def test_another_table_than_the_measured_one_is_left_alone(self, copy):
        result = validate(copy, **QUICK)
        write_table(copy, shifted_speeds(read_table(copy)))
        before = read_table(copy).content_sha256
        with pytest.raises(InputError, match="changed since it was measured"):
            store_accuracy(copy, result)
        assert read_table(copy).content_sha256 == before
