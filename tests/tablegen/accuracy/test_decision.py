"""Holds, missed or undecided, at the stated rates; and the accuracy that a user asks for."""

import numpy as np
import pytest
from refusals import refused
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
    judge,
    limits,
)
from tablegen.accuracy.noise_corrected import Estimate
from tablegen.config.config import AccuracyTargets
from tablegen.config.metric_table import METRICS, PRESETS, SPIN_PRESETS
from tablegen.config.targets import SpinTargets, asked_accuracy

TARGETS = AccuracyTargets(ks=0.03, sliced_wasserstein=0.02, correlation_error=0.05, auc=0.7)
SPIN = SpinTargets(**SPIN_PRESETS["compact"])


def exact(value, error=0.0):
    return Estimate(value, error, value, error, 0.0)


def measured(alpha_deg=40.0, speed=100.0, **estimates):
    good = {name: exact(getattr(TARGETS, name)) for name in METRICS}
    return Measured(alpha_deg, speed, {**good, **estimates})


class TestRates:
    @pytest.mark.parametrize("comparisons", [1, 12, 28])
    def test_of_false_alarms_and_false_holds(self, comparisons):
        """Half of the alarms belongs to the nodes; distances, looks and comparisons share it."""
        low, high = limits("sliced_wasserstein", exact(20.0, 1.0), comparisons)
        alarms = norm.sf(20.0 - low) * len(METRICS) * LOOKS * comparisons
        assert alarms == pytest.approx(FALSE_ALARMS / 2)
        assert norm.sf(high - 20.0) * LOOKS == pytest.approx(FALSE_HOLDS)

    def test_by_repetition(self):
        """A table at the very limit is rarely called either; 20,000 repetitions."""
        noise = np.random.default_rng(1).standard_normal((20_000, 2)) * 0.001
        said = [
            decide("ks", Estimate(0.03 + a, 0.001, 0.03 + b, 0.001, 0.0), 0.03, 1) for a, b in noise
        ]
        assert said.count(HOLDS) / len(said) == pytest.approx(FALSE_HOLDS / LOOKS, rel=0.4)
        assert said.count(MISSED) / len(said) < 2.0 * FALSE_ALARMS / 2 / len(METRICS) / LOOKS + 4e-4


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
def test_decision(estimate, said):
    assert decide("ks", estimate, 0.03, 1) == said


class TestJudge:
    @pytest.mark.parametrize("name", METRICS)
    def test_worst_condition_is_named_and_the_others_counted(self, name):
        bad, worse = measured(10.0, **{name: exact(0.9)}), measured(20.0, **{name: exact(0.95)})
        # the middle one is at its limits, and holds
        verdict = judge([bad, measured(), worse], TARGETS)
        (line,) = verdict.missed
        assert line.startswith(f"{name}: 0.9500 at 20.00 degrees, 100.0 m/s and 1 more, where ")
        assert f"where {getattr(TARGETS, name):g} is allowed" in line
        assert verdict.undecided == []

    def test_undecided_is_neither(self):
        verdict = judge([measured(ks=exact(0.031, 0.001))], TARGETS)
        assert verdict.missed == []
        assert len(verdict.undecided) == 1


class TestAskedFor:
    """A preset counts for both laws; limits with spin_ hold for the spin law alone."""

    @pytest.mark.parametrize(
        ("text", "expected", "spin"),
        [
            (None, {}, {}),
            ("fine", PRESETS["fine"], SPIN_PRESETS["fine"]),
            ("ks=0.01, auc = 0.56", {"ks": 0.01, "auc": 0.56}, {}),
            ("fine,auc=0.6", {**PRESETS["fine"], "auc": 0.6}, SPIN_PRESETS["fine"]),
            ("spin_ks=0.01, ks=0.2", {"ks": 0.2}, {"ks": 0.01}),
            ("spin_joint_auc=0.6", {}, {"joint_auc": 0.6}),
        ],
    )
    def test_changes_the_declared_limits(self, text, expected, spin):
        kept = {"exclude": {"preset"}}
        asked, asked_spin = asked_accuracy(TARGETS, text), asked_accuracy(SPIN, text)
        assert asked.model_dump(**kept) == TARGETS.model_dump(**kept) | expected
        assert asked_spin.model_dump(**kept) == SPIN.model_dump(**kept) | spin

    def test_anything_else_is_refused(self):
        for text in ("", "best", "ks", "ks=", "ks=small", "standard=1", "ks=1;auc=1", "speed=3"):
            assert "compact, standard" in refused("accuracy", asked_accuracy, TARGETS, text)
        refused("accuracy: ks", asked_accuracy, TARGETS, "ks=2")
        refused("accuracy: spin_ks", asked_accuracy, SPIN, "spin_ks=2")
