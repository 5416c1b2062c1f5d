"""Holds, missed or undecided: the rates that are stated, and the lines that are said."""

import numpy as np
import pytest
from scipy.stats import norm

from tablegen.accuracy.comparison import Measured
from tablegen.accuracy.decision import (
    FALSE_ALARMS,
    FALSE_HOLDS,
    HOLDS,
    LOOKS,
    MISSED,
    UNDECIDED,
    decide,
    deviations_down,
    deviations_up,
    judge,
    limits,
)
from tablegen.accuracy.noise_corrected import Estimate
from tablegen.accuracy.verdict import verdict_words
from tablegen.config.config import AccuracyTargets
from tablegen.config.metric_table import METRICS

TARGETS = AccuracyTargets(ks=0.03, sliced_wasserstein=0.02, correlation_error=0.05, auc=0.7)


def exact(value, error=0.0):
    return Estimate(value, error, value, error, 0.0)


def measured(alpha_deg=40.0, speed=100.0, **estimates):
    good = {"ks": exact(0.03), "sliced_wasserstein": exact(0.02), "auc": exact(0.7)}
    good |= {"correlation_error": exact(0.05)}
    return Measured(alpha_deg, speed, {**good, **estimates})


class TestRates:
    @pytest.mark.parametrize("comparisons", [1, 12, 28])
    def test_of_false_alarms_over_all_comparisons(self, comparisons):
        """Half belongs to the nodes; distances, looks and comparisons share the rest."""
        each = norm.sf(deviations_down(comparisons))
        assert each * len(METRICS) * LOOKS * comparisons == pytest.approx(FALSE_ALARMS / 2)

    def test_of_a_table_that_misses_at_a_condition(self):
        assert norm.sf(deviations_up()) * LOOKS == pytest.approx(FALSE_HOLDS)

    def test_by_repetition(self):
        """A table at the very limit is rarely called either; 20,000 repetitions."""
        noise = np.random.default_rng(1).standard_normal((20_000, 2)) * 0.001
        said = [
            decide("ks", Estimate(0.03 + a, 0.001, 0.03 + b, 0.001, 0.0), 0.03, 1) for a, b in noise
        ]
        assert said.count(HOLDS) / len(said) == pytest.approx(FALSE_HOLDS / LOOKS, rel=0.4)
        assert said.count(MISSED) / len(said) < 2.0 * FALSE_ALARMS / 2 / len(METRICS) / LOOKS + 4e-4


class TestDecide:
    @pytest.mark.parametrize(
        ("estimate", "said"),
        [
            (exact(0.03), HOLDS),
            (exact(0.0301), MISSED),
            (exact(0.02, 0.001), HOLDS),
            (exact(0.028, 0.001), UNDECIDED),
            (exact(0.032, 0.001), UNDECIDED),
            (exact(0.04, 0.001), MISSED),
            # the place that looked worst does not look bad on other states
            (Estimate(0.06, 0.01, 0.01, 0.01, 0.05), UNDECIDED),
            (exact(float("nan")), MISSED),
        ],
    )
    def test_outcome(self, estimate, said):
        assert decide("ks", estimate, 0.03, 1) == said

    @pytest.mark.parametrize("name", ["ks", "correlation_error", "auc"])
    def test_largest_possible_distance_is_always_allowed(self, name):
        most = METRICS[name].most
        assert decide(name, exact(most, 0.1), most, 1) == HOLDS

    def test_an_exact_table_never_misses_an_auc_of_a_half(self):
        assert decide("auc", exact(0.51, 0.01), 0.5, 1) == UNDECIDED
        assert limits("auc", exact(0.49, 0.01), 1)[0] == 0.5

    def test_more_comparisons_need_more_evidence(self):
        estimate = exact(0.0335, 0.001)
        assert decide("ks", estimate, 0.03, 1) == MISSED
        assert decide("ks", estimate, 0.03, 1000) == UNDECIDED


class TestJudge:
    def test_limits_themselves_hold(self):
        verdict = judge([measured(), measured()], TARGETS)
        assert verdict.holds
        assert (verdict.missed, verdict.undecided) == ([], [])

    @pytest.mark.parametrize("name", METRICS)
    def test_says_what_where_and_how_much(self, name):
        value, allowed = 0.9, getattr(TARGETS, name)
        bad = measured(77.5, 222.0, **{name: exact(value)})
        verdict = judge([measured(), bad, measured()], TARGETS)
        assert not verdict.holds
        assert verdict.missed == [
            f"{name}: 0.9000, the error 0.9000 to 0.9000, where {allowed:g} is allowed, "
            "at 77.50 degrees, 222.0 m/s"
        ]
        assert verdict.undecided == []

    def test_worst_condition_is_named_and_the_others_counted(self):
        bad, worse = measured(10.0, auc=exact(0.8)), measured(20.0, auc=exact(0.9))
        (line,) = judge([bad, worse, measured()], TARGETS).missed
        assert "at 20.00 degrees" in line
        assert line.endswith(" and 1 more")

    def test_undecided_is_neither(self):
        verdict = judge([measured(ks=exact(0.031, 0.001))], TARGETS)
        assert not verdict.holds
        assert verdict.missed == []
        (line,) = verdict.undecided
        assert line.startswith("ks: 0.0310, the error 0.02")


def test_one_sentence_for_every_place():
    assert verdict_words([], [], "declared accuracy") == (
        "The declared accuracy holds at every condition."
    )
    assert verdict_words(["x"], ["y"], "accuracy asked for") == "The accuracy asked for is missed:"
    assert "leaves open" in verdict_words([], ["y"], "declared accuracy")
