"""The accuracy that a user asks for: a preset, limits, or both."""

import pytest

from sampler.errors import InputError
from tablegen.accuracy.requested import asked_accuracy, asked_spin_accuracy
from tablegen.config.config import AccuracyTargets
from tablegen.config.metric_table import METRICS, PRESETS, SPIN_PRESETS, looser_than_compact
from tablegen.config.targets import SpinTargets

DECLARED = AccuracyTargets(ks=0.3, sliced_wasserstein=0.2, correlation_error=0.5, auc=0.7)


def numbers(accuracy):
    return {name: getattr(accuracy, name) for name in METRICS}


def test_none_is_what_the_table_declares():
    assert asked_accuracy(DECLARED, None) is DECLARED


@pytest.mark.parametrize("name", PRESETS)
def test_preset(name):
    asked = asked_accuracy(DECLARED, name)
    assert asked.preset == name
    assert numbers(asked) == PRESETS[name]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("ks=0.01", {**numbers(DECLARED), "ks": 0.01}),
        ("ks=0.01, auc = 0.56", {**numbers(DECLARED), "ks": 0.01, "auc": 0.56}),
        ("fine,auc=0.6", {**PRESETS["fine"], "auc": 0.6}),
    ],
)
def test_limits_change_what_is_declared_or_preset(text, expected):
    assert numbers(asked_accuracy(DECLARED, text)) == expected


@pytest.mark.parametrize(
    "text", ["", "best", "ks", "ks=", "ks=small", "standard=1", "ks=0.01;auc=0.6", "speed=3"]
)
def test_anything_else_is_refused(text):
    with pytest.raises(InputError) as caught:
        asked_accuracy(DECLARED, text)
    assert str(caught.value).startswith(f"accuracy: got {text!r}, allowed: compact, standard, fine")


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("ks=2", "accuracy: ks: got 2, allowed: less than or equal to 1"),
        ("auc=0.4", "accuracy: auc: got 0.4, allowed: greater than or equal to 0.5"),
        ("sliced_wasserstein=nan", "accuracy: sliced_wasserstein: got nan, allowed: a finite"),
    ],
)
def test_limits_out_of_range_are_refused(text, line):
    with pytest.raises(InputError) as caught:
        asked_accuracy(DECLARED, text)
    assert str(caught.value).startswith(line)


def test_what_is_looser_than_the_loosest_preset():
    assert looser_than_compact(DECLARED.model_dump()) == list(METRICS)
    compact = AccuracyTargets.model_validate({"preset": "compact"})
    assert looser_than_compact(compact.model_dump()) == []
    assert looser_than_compact(compact.model_dump() | {"auc": 0.66}) == ["auc"]


class TestSpinLaw:
    """A preset counts for both laws; limits with spin_ for the spin law alone."""

    DECLARED = SpinTargets(**SPIN_PRESETS["compact"])

    def test_limits(self):
        text = "spin_ks=0.01, ks=0.2,spin_joint_auc=0.6"
        asked = asked_spin_accuracy(self.DECLARED, text)
        expected = SPIN_PRESETS["compact"] | {"ks": 0.01, "joint_auc": 0.6}
        assert asked.model_dump(exclude={"preset"}) == expected
        assert numbers(asked_accuracy(DECLARED, text)) == {**numbers(DECLARED), "ks": 0.2}

    def test_preset(self):
        asked = asked_spin_accuracy(self.DECLARED, "fine,spin_auc=0.7")
        assert asked.model_dump() == {"preset": "fine", **SPIN_PRESETS["fine"], "auc": 0.7}
        assert asked_spin_accuracy(self.DECLARED, None) is self.DECLARED
        assert asked_spin_accuracy(self.DECLARED, "ks=0.1") == self.DECLARED

    @pytest.mark.parametrize(
        ("text", "line"),
        [
            ("spin_ks=2", "accuracy: spin_ks: got 2, allowed: less than or equal to 1"),
            ("spin_joint_w=1", "accuracy: got 'spin_joint_w=1', allowed: compact, standard"),
            ("spin_auc=x", "accuracy: got 'spin_auc=x', allowed: compact"),
        ],
    )
    def test_anything_else_is_refused(self, text, line):
        with pytest.raises(InputError) as caught:
            asked_spin_accuracy(self.DECLARED, text)
        assert str(caught.value).startswith(line)
