"""Validation: passes a good table, refuses wrong ones, and says so in numbers."""

import json
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
from tiny_tables import TINY

import sampler
from sampler.errors import InputError, TableError
from sampler.formats.channels import STATE
from sampler.formats.hdf5 import write_table
from tablegen.accuracy.descriptive import Profile
from tablegen.accuracy.measure import measure
from tablegen.accuracy.validate import validate
from tablegen.accuracy.validation_text import coverage_lines
from tablegen.config.metric_table import METRICS, errors_text, worst_stored

pytestmark = pytest.mark.usefixtures("quick_classifier")

#: The module; in the package its name stands for the function.
VALIDATE = sys.modules[validate.__module__]

#: An accuracy that the tiny table has at its nodes and between them: nodes fitted to 6000 states
#: are off by 0.02 in the Kolmogorov-Smirnov distance and 0.03 in a correlation, and interpolation
#: adds 0.015. A right table is said to miss it once in a hundred validations, at most.
TIGHT = {"ks": 0.06, "sliced_wasserstein": 0.06, "correlation_error": 0.13, "auc": 0.72}
SAMPLES = 4_000
CONDITIONS = 2


@pytest.fixture
def validated(tiny, tmp_path):
    """Validate the tiny table, tampered with by a function, at the tight declared accuracy."""

    def run(tamper=lambda contents: contents):
        path = tmp_path / "tight.h5"
        write_table(path, declaring(tamper(tiny.generated.table.contents), **TIGHT))
        return validate(path, conditions=CONDITIONS, samples=SAMPLES, seed=1)

    return run


def relabelled(contents):
    """The table of one pair with the configuration of another."""
    text = contents.config.replace("coefficient = 0.1", "coefficient = 0.03")
    assert text != contents.config
    return replace(contents, config=text)


class TestVerdict:
    def test_table_as_generated_holds(self, tiny):
        validation = validate(tiny.path, conditions=CONDITIONS, samples=SAMPLES, seed=1)
        assert validation.holds
        assert (validation.missed, validation.undecided) == ([], [])
        assert validation.declared == validation.asked == TINY.accuracy

    def test_intact_table_holds_a_tight_accuracy(self, validated):
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
        validation = validated(tamper)
        assert not validation.holds
        assert {line.split(":")[0] for line in validation.missed} >= metrics
        if tamper is lopsided:  # it is w that is wrong
            worst = max(validation.comparisons, key=lambda c: max(c.distances()["ks"]))
            assert STATE[int(np.argmax(worst.distances()["ks"]))] == "w"

    def test_a_node_that_no_condition_meets_is_found(self, validated):
        """Far from the conditions, which alone would pass it."""
        validation = validated(lambda contents: spin_flipped(contents, (1, 1)))
        assert not validation.holds
        assert (45.0, 300.0) in validation.screening.suspects
        assert any("at 45.00 degrees, 300.0 m/s" in line for line in validation.missed)


class TestAccuracyAskedFor:
    def test_takes_the_place_of_the_declared_one(self, tiny):
        found = validate(tiny.path, conditions=1, samples=1000, seed=1, accuracy="ks=0.001,auc=0.9")
        assert found.declared == TINY.accuracy
        assert (found.asked.ks, found.asked.auc) == (0.001, 0.9)
        assert found.asked.correlation_error == TINY.accuracy.correlation_error
        assert not found.holds
        assert not [line for line in found.missed + found.undecided if line[:3] == "auc"]

    def test_a_lenient_declaration_is_known(self, tiny):
        found = validate(tiny.path, conditions=1, samples=1000, seed=1)
        assert found.lenient == list(METRICS)


class TestStoredAccuracy:
    def test_stands_beside_what_was_measured(self, tiny):
        found = validate(tiny.path, conditions=1, samples=1000, seed=1)
        assert found.stored == worst_stored(sampler.load(tiny.path).accuracy)
        text = "\n".join(coverage_lines(found))
        assert f"The file says of itself, at worst: {errors_text(found.stored)}. Measured" in text
        assert "larger than the file says" not in text

    def test_of_a_forged_table_is_contradicted(self, tiny, tmp_path):
        """Garbage at all nodes, with a lenient declaration and a stored accuracy of 0: it holds
        what it declares, and both are said to be worth nothing."""
        path = tmp_path / "forged.h5"
        contents = tiny.generated.table.contents
        write_table(path, forged(garbage(contents, np.ones((2, 2), dtype=bool))))
        found = validate(path, conditions=1, samples=1000, seed=1)
        assert found.holds
        assert found.stored["ks"] == 0.0
        assert found.surpassed["ks"] > 0.3
        assert found.to_dict()["stored"] == found.stored
        text = "\n".join(coverage_lines(found))
        assert "Note: the table declares little: ks 1," in text
        assert "says of itself, at worst: KS 0.0000, sliced Wasserstein 0.0000" in text
        assert "Note: the error is larger than the file says, at least KS 0." in text


class TestChosenConditions:
    def test_are_measured_and_nothing_else(self, tiny):
        found = validate(tiny.path, at=[(40.0, 100.0), (45.0, 300.0)], samples=1000, seed=1)
        places = [(c.alpha_deg, c.speed) for c in found.comparisons]
        assert places == [(40.0, 100.0), (45.0, 300.0)]
        assert found.screening is None
        assert found.nodes == []

    def test_outside_of_the_table_are_refused(self, tiny):
        with pytest.raises(InputError, match="alpha: got 50 degrees, allowed: 35 to 45 degrees"):
            validate(tiny.path, at=[(50.0, 100.0)])


class TestAgreement:
    """A file that contradicts its own configuration is refused before anything is measured."""

    @pytest.mark.parametrize(
        ("change", "line"),
        [
            ({"pair": "titanium-glass"}, "pair: got 'titanium-glass', allowed: 'corundum-steel'"),
            (
                {"domain": {"alpha_deg": [30.0, 45.0]}, "table": {"alpha_nodes_deg": [30.0, 45.0]}},
                "axes/alpha_deg: got 35 to 45, allowed: 30 to 45, the domain",
            ),
            (
                {"domain": {"speed": [60.0, 250.0]}, "table": {"speed_nodes": [60.0, 250.0]}},
                "axes/speed: got 60 to 300, allowed: 60 to 250, the domain",
            ),
            (
                {"domain": {"components": ["u", "v"]}},
                "components: got u v w omega_x omega_y omega_z, allowed: u v, those of",
            ),
        ],
    )
    def test_is_asked_for(self, tiny, tmp_path, change, line):
        contents = tiny.generated.table.contents
        if "pair" in change:
            contents = replace(contents, **change)
        else:
            contents = replace(contents, config=TINY.with_changes(change).text)
        path = tmp_path / "t.h5"
        write_table(path, contents)
        with pytest.raises(InputError) as caught:
            validate(path)
        assert line in str(caught.value)


class TestResult:
    def test_is_a_function_of_the_seed(self, tiny):
        first, again, other = (
            validate(tiny.path, conditions=1, samples=1000, seed=seed) for seed in (3, 3, 4)
        )
        assert first == again
        assert first.comparisons != other.comparisons
        assert first.screening != other.screening

    def test_seed_is_another_each_time_and_repeats(self, tiny):
        first, other = (validate(tiny.path, conditions=1, samples=1000) for _ in range(2))
        assert first.seed != other.seed
        assert validate(tiny.path, conditions=1, samples=1000, seed=first.seed) == first

    def test_knows_its_table(self, tiny):
        validation = validate(tiny.path, conditions=3, samples=1000, seed=8)
        assert validation.table == str(tiny.path)
        assert validation.seed == 8
        assert validation.content_sha256 == sampler.load(tiny.path).contents.content_sha256
        assert len(validation.comparisons) == 3
        assert [(c.alpha_deg, c.speed) for c in validation.nodes] == list(
            validation.screening.suspects
        )

    @pytest.mark.parametrize("removed", [False, True])
    def test_attests_what_it_measured(self, tiny, tmp_path, monkeypatch, removed):
        """The file is exchanged or removed while it is measured."""
        path = tmp_path / "t.h5"
        contents = tiny.generated.table.contents
        write_table(path, contents)

        def exchanging(*arguments, **options):
            path.unlink()
            if not removed:
                write_table(path, replace(contents, seed=contents.seed + 1))
            return measure(*arguments, **options)

        monkeypatch.setattr(VALIDATE, "measure", exchanging)
        validation = validate(path, conditions=1, samples=1000, seed=1)
        assert validation.content_sha256 == contents.content_sha256

    def test_as_json(self, tiny):
        validation = validate(tiny.path, conditions=2, samples=1000, seed=1)
        record = json.loads(json.dumps(validation.to_dict(), allow_nan=False))
        assert record["holds"] is validation.holds
        assert record["declared"] == record["asked"] == TINY.accuracy.model_dump()
        assert record["software_version"] == sampler.__version__
        assert (record["seed"], record["false_alarms"]) == (1, 0.01)
        assert record["missed"] + record["undecided"] == validation.missed + validation.undecided
        assert record["screening"]["nodes"] == 4
        records = record["conditions"] + record["nodes"]
        for condition, comparison in zip(records, validation.measured, strict=True):
            check_record(condition, comparison)


def check_record(condition, comparison):
    """A condition of the JSON record has every number, with limits and verdict."""
    assert condition["components"] == list(STATE)
    assert condition["states"] == comparison.states >= 1000
    assert (condition["alpha_deg"], condition["speed"]) == (comparison.alpha_deg, comparison.speed)
    assert {name: condition[name] for name in METRICS} == comparison.distances()
    for name, estimate in condition["estimates"].items():
        assert estimate["value"] == comparison.estimates[name].value
        assert 0.0 <= estimate["low"] <= estimate["high"]
        assert estimate["verdict"] in ("holds", "undecided", "missed")
    for side in ("table", "direct"):
        assert set(condition[side]) == {field.name for field in fields(Profile)}
        assert condition[side]["count"] == 1000


class TestRefusals:
    @pytest.mark.parametrize(
        ("argument", "value", "line"),
        [
            ("conditions", 0, "conditions: got 0, allowed: 1 or more"),
            ("samples", 999, "samples: got 999, allowed: 1000 or more"),
            ("seed", -1, "seed: got -1, allowed: 0 to 2**64 - 1"),
            ("seed", 2**64, f"seed: got {2**64}, allowed: 0 to 2**64 - 1"),
            ("seed", 1.0, "seed: got 1.0, allowed: 0 to 2**64 - 1"),
            ("conditions", 2.5, "conditions: got 2.5, allowed: 1 or more"),
            ("samples", True, "samples: got True, allowed: 1000 or more"),
        ],
    )
    def test_arguments(self, tiny, argument, value, line):
        with pytest.raises(InputError) as caught:
            validate(tiny.path, **{argument: value})
        assert str(caught.value) == line

    def test_no_table(self, tmp_path):
        path = tmp_path / "t.h5"
        path.write_bytes(b"\x89HDF\r\n\x1a\n")
        with pytest.raises(TableError):
            validate(path)

    def test_table_whose_configuration_cannot_be_read(self, tiny, tmp_path):
        path = tmp_path / "t.h5"
        write_table(path, replace(tiny.generated.table.contents, config="name = "))
        with pytest.raises(InputError, match=r"t\.h5: config: not valid TOML"):
            validate(path)
