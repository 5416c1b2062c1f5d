"""`tablegen.accuracy.judgement`: which numbers hold, and the advice if they do not."""

import pytest

from tablegen.accuracy.comparison import ConditionDistances
from tablegen.accuracy.judgement import Judged, advice, judge
from tablegen.accuracy.metrics import Estimate
from tablegen.config.metric_table import CHAIN_LIMITS, METRICS, SPIN_PRESETS
from tablegen.config.targets import AccuracyTargets, SpinTargets

TARGETS = AccuracyTargets(ks=0.03, sliced_wasserstein=0.02, correlation_error=0.05, auc=0.6)
SPIN = SpinTargets(**SPIN_PRESETS["compact"], **CHAIN_LIMITS)


def measured(alpha_deg=40.0, **estimates):
    good = {name: Estimate(getattr(TARGETS, name), 0.0) for name in METRICS}
    return ConditionDistances(alpha_deg, 100.0, {**good, **estimates})


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
def test_a_number_holds_if_it_is_within_its_limit_less_three_errors(value, error, holds):
    assert Judged("ks", Estimate(value, error), 0.03, "here").holds is holds


@pytest.mark.parametrize("name", METRICS)
def test_worst_condition_is_judged(name):
    """The worst condition is most certainly outside; its number need not be the largest."""
    bad, worse = measured(10.0, **{name: Estimate(0.9, 0.1)}), measured(20.0)
    worse.estimates[name] = Estimate(0.8, 0.01)
    judged = {number.name: number for number in judge([bad, measured(), worse], TARGETS)}
    assert judged[name].place == "20.00 degrees, 100.0 m/s"
    assert [number.name for number in judged.values() if not number.holds] == [name]


def test_advice_is_a_limit_a_preset_and_a_range():
    numbers = judge([measured(7.0, ks=Estimate(0.0354, 0.001))], TARGETS)
    numbers += judge([measured()], SPIN, "spin_")
    numbers.append(Judged("spin_chain_ks", Estimate(0.061, 0.001), 0.04, "hit 3"))
    declare, without = advice(numbers).split("; or ")
    assert "ks = 0.036 in [accuracy] and chain_ks = 0.061 in [spin_accuracy]" in declare
    assert "7.00 degrees, 100.0 m/s" in without
    numbers[-1] = numbers[-1]._replace(allowed=0.1)
    assert advice(numbers).split("; or ")[1] == 'set preset = "compact"'


def test_far_above_a_limit_the_advice_is_to_change_the_table():
    numbers = judge([measured(53.0, ks=Estimate(0.38, 0.001))], TARGETS)
    numbers += judge([measured()], SPIN, "spin_")
    text = advice(numbers)
    assert "declare" not in text
    assert text.startswith("ks 0.3800 at 53.00 degrees, 100.0 m/s is 13 times its limit")
    assert "alpha_nodes_deg or speed_nodes" in text
    numbers.append(Judged("spin_chain_energy", Estimate(0.8, 0.001), 0.01, "hits 3 to 6, prisms"))
    first, chains = advice(numbers).split(" spin_chain")
    assert first == text
    assert "at hits 3 to 6, prisms" in chains
    assert "spin_leaves" in chains
    assert "spin = false" in chains
    numbers[0] = numbers[0]._replace(estimate=Estimate(float("nan"), 0.0))
    assert "is not a number." in advice(numbers)
