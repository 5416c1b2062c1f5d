"""A number holds if it is within its limit when three errors are taken off."""

import pytest
from refusals import refused

from tablegen.accuracy.comparison import Measured
from tablegen.accuracy.judgement import Judged, advice, judge
from tablegen.accuracy.metrics import Estimate
from tablegen.config.config import AccuracyTargets, load_config
from tablegen.config.metric_table import (
    CHAIN_LIMITS,
    ELLIPSOID_LIMITS,
    METRICS,
    PRESETS,
    SPIN_PRESETS,
)
from tablegen.config.targets import SpinTargets, asked_accuracy

TARGETS = AccuracyTargets(ks=0.03, sliced_wasserstein=0.02, correlation_error=0.05, auc=0.6)
SPIN = SpinTargets(**SPIN_PRESETS["compact"], **CHAIN_LIMITS)


def measured(alpha_deg=40.0, **estimates):
    good = {name: Estimate(getattr(TARGETS, name), 0.0) for name in METRICS}
    return Measured(alpha_deg, 100.0, {**good, **estimates})


@pytest.mark.parametrize(
    ("value", "error", "holds"),
    [
        (0.03, 0.0, True),
        (0.0301, 0.0, False),
        (0.0599, 0.01, True),
        (0.0601, 0.01, False),
        (float("nan"), 0.01, False),
        (0.01, float("nan"), False),
    ],
)
def test_three_errors_are_taken_off(value, error, holds):
    assert Judged("ks", Estimate(value, error), 0.03, "here").holds is holds


@pytest.mark.parametrize("name", METRICS)
def test_worst_condition_is_judged(name):
    """That which is most certainly wrong, not that with the largest number."""
    bad, worse = measured(10.0, **{name: Estimate(0.9, 0.1)}), measured(20.0)
    worse.estimates[name] = Estimate(0.8, 0.01)
    found = {number.name: number for number in judge([bad, measured(), worse], TARGETS)}
    assert found[name].place == "20.00 degrees, 100.0 m/s"
    assert [number.name for number in found.values() if not number.holds] == [name]


def test_advice_is_a_limit_a_preset_and_a_range():
    numbers = judge([measured(7.0, ks=Estimate(0.0354, 0.001))], TARGETS)
    numbers += judge([measured()], SPIN, "spin_")
    numbers.append(Judged("spin_chain_ks", Estimate(0.061, 0.001), 0.03, "hit 3"))
    assert advice(numbers) == (
        "to hold: declare ks = 0.036 in [accuracy] and chain_ks = 0.061 in [spin_accuracy]; "
        "or a range without 7.00 degrees, 100.0 m/s"
    )
    numbers[-1] = numbers[-1]._replace(allowed=0.1)
    assert '; or preset = "compact"; or' in advice(numbers)


class TestLimits:
    def test_of_chains_follow_the_population(self):
        config = load_config("corundum-steel")
        half = config.with_changes({"population": {"shapes": {"ellipsoid": 3.0}}})
        for one, limits in ((config, CHAIN_LIMITS), (half, ELLIPSOID_LIMITS)):
            assert {k: getattr(one.spin_targets, k) for k in limits} == limits
        own = half.with_changes({"spin_accuracy": {"chain_ks": 0.2}}).spin_targets
        assert (own.chain_ks, own.chain_spin) == (0.2, ELLIPSOID_LIMITS["chain_spin"])

    @pytest.mark.parametrize(
        ("text", "expected", "spin"),
        [
            (None, {}, {}),
            ("fine", PRESETS["fine"], SPIN_PRESETS["fine"]),
            ("ks=0.01, auc = 0.56", {"ks": 0.01, "auc": 0.56}, {}),
            ("fine,auc=0.6", {**PRESETS["fine"], "auc": 0.6}, SPIN_PRESETS["fine"]),
            ("spin_ks=0.01, ks=0.2", {"ks": 0.2}, {"ks": 0.01}),
            ("spin_chain_ks=0.2", {}, {"chain_ks": 0.2}),
        ],
    )
    def test_asked_for_change_the_declared_ones(self, text, expected, spin):
        """A preset counts for both laws; limits with spin_ hold for the spin law alone."""
        kept = {"exclude": {"preset"}}
        asked, asked_spin = asked_accuracy(TARGETS, text), asked_accuracy(SPIN, text)
        assert asked.model_dump(**kept) == TARGETS.model_dump(**kept) | expected
        assert asked_spin.model_dump(**kept) == SPIN.model_dump(**kept) | spin

    def test_anything_else_is_refused(self):
        for text in ("", "best", "ks", "ks=", "ks=small", "standard=1", "ks=1;auc=1", "speed=3"):
            assert "compact, standard" in refused("accuracy", asked_accuracy, TARGETS, text)
        refused("accuracy: ks", asked_accuracy, TARGETS, "ks=2")
        refused("accuracy: spin_ks", asked_accuracy, SPIN, "spin_ks=2")
