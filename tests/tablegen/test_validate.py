"""Validation: passes a good table, refuses wrong ones, and says so in numbers."""

import json
from dataclasses import replace

import numpy as np
import pytest
from tiny_tables import TINY
from wrong_tables import declaring, independent_channels, lopsided, shifted_speeds

import sampler
from sampler.channels import STATE
from sampler.errors import InputError, TableError
from sampler.schema import write_table
from tablegen.validate import validate

#: What the tiny table holds at any condition between its nodes, with 10,000 states a side. Noise:
#: two empirical distribution functions and that of the node (6000) differ by more than 0.045
#: with probability 2 exp(-2 0.045^2 / (2/10000 + 1/6000)) = 3e-5, and interpolation between the
#: nodes adds 0.015. Correlations have standard errors of 0.02, the AUC one of 0.006. All in
#: all a right table would miss one of these in a validation with probability below 1e-3.
TIGHT = {"ks": 0.06, "sliced_wasserstein": 0.06, "correlation_error": 0.13, "auc": 0.66}
SAMPLES = 10_000
CONDITIONS = 2


@pytest.fixture
def validated(tiny, tmp_path):
    """Validate the tiny table, tampered with by a function, at the tight declared accuracy."""

    def run(tamper=lambda contents: contents):
        path = tmp_path / "tight.h5"
        write_table(path, declaring(tamper(tiny.generated.table.contents), **TIGHT))
        return validate(path, conditions=CONDITIONS, samples=SAMPLES)

    return run


def missed_metrics(validation):
    return {line.split(":")[0] for line in validation.missed}


class TestVerdict:
    def test_table_as_generated_holds(self, tiny):
        validation = validate(tiny.path, conditions=CONDITIONS, samples=SAMPLES)
        assert validation.holds
        assert validation.missed == []
        assert validation.declared == TINY.accuracy

    def test_intact_table_holds_a_tight_accuracy(self, validated):
        assert validated().missed == []

    def test_independent_channels_are_refused(self, validated):
        validation = validated(independent_channels)
        assert not validation.holds
        assert missed_metrics(validation) >= {"sliced_wasserstein", "correlation_error", "auc"}

    def test_axis_shifted_by_a_node_is_refused(self, validated):
        validation = validated(shifted_speeds)
        assert not validation.holds
        assert "ks" in missed_metrics(validation)

    def test_broken_mirror_symmetry_is_refused(self, validated):
        validation = validated(lopsided)
        assert not validation.holds
        assert "ks" in missed_metrics(validation)
        # It is w that is wrong.
        worst = max(validation.comparisons, key=lambda c: max(c.ks))
        assert STATE[int(np.argmax(worst.ks))] == "w"

    def test_another_pairs_table_is_refused(self, validated):
        """The configuration is what counts: the simulation follows it, not the table."""

        def relabelled(contents):
            text = contents.config.replace("coefficient = 0.1", "coefficient = 0.03")
            assert text != contents.config
            return replace(contents, config=text)

        assert "ks" in missed_metrics(validated(relabelled))


class TestResult:
    def test_is_a_function_of_the_seed(self, tiny):
        first, again, other = (
            validate(tiny.path, conditions=1, samples=1000, seed=seed) for seed in (3, 3, 4)
        )
        assert first == again
        assert first.comparisons != other.comparisons

    def test_knows_its_table(self, tiny):
        validation = validate(tiny.path, conditions=3, samples=1000, seed=8)
        assert validation.table == str(tiny.path)
        assert validation.seed == 8
        assert validation.content_sha256 == sampler.load(tiny.path).contents.content_sha256
        assert len(validation.comparisons) == 3

    def test_as_json(self, tiny):
        validation = validate(tiny.path, conditions=2, samples=1000)
        record = json.loads(json.dumps(validation.to_dict(), allow_nan=False))
        assert set(record) == {
            "table",
            "content_sha256",
            "seed",
            "declared",
            "missed",
            "holds",
            "software_version",
            "conditions",
        }
        assert record["holds"] is validation.holds
        assert record["declared"] == TINY.accuracy.model_dump()
        assert record["software_version"] == sampler.__version__
        for condition, comparison in zip(record["conditions"], validation.comparisons, strict=True):
            assert condition["components"] == list(STATE)
            assert condition["ks"] == list(comparison.ks)
            for name in ("alpha_deg", "speed", "sliced_wasserstein", "correlation_error", "auc"):
                assert condition[name] == getattr(comparison, name)
            for side in ("table", "direct"):
                assert set(condition[side]) == {
                    "count",
                    "mean",
                    "standard_deviation",
                    "mode",
                    "translational_energy",
                    "scattering_mean_deg",
                    "scattering_standard_deviation_deg",
                }
                assert condition[side]["count"] == 1000


class TestRefusals:
    @pytest.mark.parametrize(
        ("argument", "value", "line"),
        [
            ("conditions", 0, "conditions: got 0, allowed: 1 or more"),
            ("samples", 999, "samples: got 999, allowed: 1000 or more"),
            ("seed", -1, "seed: got -1, allowed: 0 to 2**64 - 1"),
            ("seed", 2**64, f"seed: got {2**64}, allowed: 0 to 2**64 - 1"),
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
