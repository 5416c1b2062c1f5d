"""`validate`: good tables hold, wrong tables miss, and the result has all numbers.

The spin law of the spinning table is direct simulation itself, right or wrong.
"""

import json
import sys
from dataclasses import replace

import numpy as np
import pytest
from corrupt_tables import (
    declaring,
    forged,
    garbage,
    independent_channels,
    lopsided,
    shifted_speeds,
)
from direct_table import DirectTable
from refusals import refused
from spin_tables import with_spin_law
from tiny_tables import TINY

from sampler.formats.hdf5 import read_table, write_table
from sampler.options import MISSED
from sampler.table import Table
from tablegen.accuracy.accuracy_text import validation_notes, verdict_lines
from tablegen.accuracy.validate import validate
from tablegen.config.config import load_config, load_population
from tablegen.config.metric_table import CHAINS, METRICS, SPIN
from tablegen.tables.assembly import store_accuracy

pytestmark = pytest.mark.usefixtures("quick_classifier")

#: The module; in the package its name stands for the function.
VALIDATE = sys.modules[validate.__module__]

#: Accuracy of the tiny table at its nodes and between them: nodes fitted to 6000 states are off by
#: 0.02 in the Kolmogorov-Smirnov distance and 0.03 in a correlation, and interpolation adds 0.015.
TIGHT = {"ks": 0.06, "sliced_wasserstein": 0.06, "correlation_error": 0.13, "auc": 0.72}

#: As few states as there may be.
QUICK = {"conditions": 1, "samples": 1000, "seed": 1}


@pytest.fixture
def validated(tiny, tmp_path):
    """Change the tiny table by a function, declare a tight accuracy, and validate it."""

    def run(tamper=lambda contents: contents):
        path = tmp_path / "tight.h5"
        write_table(path, declaring(tamper(read_table(tiny.path)), **TIGHT))
        return validate(path, conditions=2, samples=20_000, seed=1)

    return run


class TestVerdict:
    def test_right_table_holds(self, tiny, validated):
        result = validate(tiny.path, conditions=2, samples=4000, seed=1)
        assert result.holds
        assert result.asked == TINY.accuracy
        assert validated().missed == []

    @pytest.mark.parametrize(
        ("tamper", "metrics"),
        [
            (independent_channels, {"sliced_wasserstein", "correlation_error", "auc"}),
            (shifted_speeds, {"ks"}),
            (lopsided, {"ks"}),
        ],
    )
    def test_wrong_tables_are_refused(self, validated, tamper, metrics):
        result = validated(tamper)
        assert not result.holds
        assert {number.name for number in result.missed} >= metrics

    def test_a_forged_accuracy_stands_beside_the_measured_one(self, tiny, tmp_path):
        """The table is garbage, declares little accuracy, and stores distances of 0."""
        path = tmp_path / "forged.h5"
        contents = read_table(tiny.path)
        write_table(path, forged(garbage(contents, np.ones((2, 2), dtype=bool))))
        result = validate(path, **QUICK)
        assert result.holds
        assert result.stored["ks"] == 0.0
        assert result.numbers[0].estimate.value > 0.3
        notes = "\n".join(validation_notes(result))
        assert "Note: the table declares little accuracy: ks 1," in notes
        nothing = replace(result, comparisons=[], config=load_config("corundum-steel"))
        notes = "\n".join(validation_notes(nothing))
        assert "was compared at 0 conditions." in notes
        assert "Note:" not in notes


class TestResult:
    def test_as_json(self, tiny):
        result = validate(tiny.path, **QUICK)
        record = json.loads(json.dumps(result.to_dict(), allow_nan=False))
        assert (record["holds"], record["seed"]) == (result.holds, 1)
        for number, judged in zip(record["numbers"], result.numbers, strict=True):
            assert (number["value"], number["holds"]) == (judged.estimate.value, judged.holds)
            assert number["stored"] == result.stored[judged.name]
        (condition,), (comparison,) = record["conditions"], result.comparisons
        assert condition["states"] == comparison.states == 1000
        assert {name: condition[name] for name in METRICS} == comparison.distances()


ENDS, SPEEDS = [30.0, 45.0], [60.0, 250.0]


class TestRefusals:
    @pytest.mark.parametrize("value", [0, 2.5])
    def test_arguments(self, tiny, value):
        refused("conditions", validate, tiny.path, conditions=value)

    @pytest.mark.parametrize(
        ("field", "change"),
        [
            ("pair", {"pair": "titanium-glass"}),
            ("config", {"config": 'name = "x"'}),
            ("axes/alpha_deg", {"domain": {"alpha_deg": ENDS}, "table": {"alpha_nodes_deg": ENDS}}),
            ("axes/speed", {"domain": {"speed": SPEEDS}, "table": {"speed_nodes": SPEEDS}}),
            ("variables", {"domain": {"variables": ["u", "v"]}}),
            ("spin law", {"spin": True}),
        ],
    )
    def test_a_file_that_contradicts_its_configuration(self, tiny, tmp_path, field, change):
        if set(change) <= {"domain", "table", "spin"}:
            change = {"config": TINY.with_changes(change).text}
        path = tmp_path / "t.h5"
        write_table(path, replace(read_table(tiny.path), **change))
        refused(f"{path}: {field}", validate, path)


SPINNING = TINY.with_changes({"spin": True})


@pytest.fixture
def spinning(tiny, tmp_path, monkeypatch):
    """Give the tiny table the spin law of a configuration, and return its path."""

    def give(config=SPINNING):
        law = DirectTable(config)

        class SpinTable(Table):
            def sample(self, alpha1, speed, *, spin=None, **keys):
                if spin is None:
                    return super().sample(alpha1, speed, **keys)
                return law.sample(alpha1, speed, spin=spin, **keys)

            def rebound(self, *impacts, **keys):
                return law.rebound(*impacts, **keys)

        monkeypatch.setattr(VALIDATE, "Table", SpinTable)
        path = tmp_path / "spinning.h5"
        contents = with_spin_law(read_table(tiny.path))
        write_table(path, replace(contents, config=SPINNING.text))
        return path

    return give


class TestSpinLaw:
    def test_right_law_holds_and_the_first_impact_law_is_measured_as_without(self, spinning, tiny):
        path, plain = spinning(), validate(tiny.path, **QUICK)
        result = validate(path, **QUICK)
        assert result.missed == []
        assert [place.own for place in result.own] == [True]
        # later hits need any angle, so the law is followed through chains whatever its nodes are
        assert (plain.own, plain.hits) == ([], [])
        assert result.hits
        judged = {number.name for number in result.numbers}
        assert {SPIN + name for name in (*METRICS, *CHAINS)} <= judged
        assert result.comparisons == plain.comparisons
        # stored beside the other accuracy, and kept where nothing of it is measured again
        store_accuracy(path, result)
        after = read_table(path)
        assert after["spin_accuracy/spin"].tolist() == [[0.0, 0.0, 0.0]]
        assert after["spin_accuracy/auc"].tolist() == [result.own[0].estimates["auc"].value]
        # where a spin law misses, nearly round grains are named as the cause
        missed = replace(result, asked_spin=result.asked_spin.model_copy(update={"auc": 0.1}))
        assert "Nearly round" not in " ".join(verdict_lines(missed))
        grains = SPINNING.with_changes({"population": load_population("well-rounded")})
        assert "Nearly round" in " ".join(verdict_lines(replace(missed, config=grains)))

    def test_command(self, run, spinning, tmp_path):
        """`test_chains` has the wrong laws that chains must notice."""
        words = ("--conditions", 1, "--samples", 1000, "--seed", 1, "--quiet")
        elastic = SPINNING.with_changes({"pair": {"restitution": {"coefficient": 0.03}}})
        ended = run("validate", spinning(elastic), *words, "--html", tmp_path / "v.html")
        assert (ended.status, ended.err) == (MISSED, "")
        assert "spin_auc" in (tmp_path / "v.html").read_text()
        assert "times its limit. Give the spin law more leaves" in ended.out
