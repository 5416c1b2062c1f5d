"""Accuracy that a table declares by presets, and that a user asks for."""

from itertools import pairwise

import pytest
from refusals import refused

from tablegen.config.config import load_config
from tablegen.config.metric_table import CHAIN_LIMITS, PRESETS, SPIN_PRESETS
from tablegen.config.targets import AccuracyTargets, SpinTargets, asked_accuracy

CORUNDUM = load_config("corundum-steel")
TARGETS = AccuracyTargets(ks=0.03, sliced_wasserstein=0.02, correlation_error=0.05, auc=0.6)
SPIN = SpinTargets(**SPIN_PRESETS["compact"], **CHAIN_LIMITS)


@pytest.mark.parametrize("name", PRESETS)
def test_name_of_a_preset_stands_for_its_numbers(name):
    accuracy = AccuracyTargets.model_validate({"preset": name})
    assert accuracy.model_dump() == {"preset": name, **PRESETS[name]}
    own = AccuracyTargets.model_validate({"preset": name, "ks": 0.007})
    assert (own.ks, own.auc) == (0.007, PRESETS[name]["auc"])


def test_finer_presets_allow_less_and_standard_is_the_default():
    for coarse, fine in pairwise(("compact", "standard", "fine")):
        for metric, allowed in PRESETS[fine].items():
            assert allowed < PRESETS[coarse][metric], metric
    assert AccuracyTargets.model_validate({}).preset == "standard"


def test_limits_of_the_spin_law_change_the_preset_of_the_table():
    changes = {"accuracy": {"preset": "compact"}, "spin_accuracy": {"chain_spin": 0.2}}
    limits = {**SPIN_PRESETS["compact"], **CHAIN_LIMITS, "chain_spin": 0.2}
    targets = CORUNDUM.with_changes(changes).spin_targets
    assert targets.model_dump() == {"preset": "compact", **limits}


@pytest.mark.parametrize(
    ("text", "expected", "spin"),
    [
        (None, {}, {}),
        ("fine", PRESETS["fine"], SPIN_PRESETS["fine"]),
        ("ks=0.01, auc = 0.56", {"ks": 0.01, "auc": 0.56}, {}),
        ("fine,auc=0.6", {**PRESETS["fine"], "auc": 0.6}, SPIN_PRESETS["fine"]),
        ("spin_ks=0.01, spin_chain_ks=0.2, ks=0.2", {"ks": 0.2}, {"ks": 0.01, "chain_ks": 0.2}),
    ],
)
def test_a_text_changes_the_declared_limits(text, expected, spin):
    """A preset sets the limits of both laws; limits with spin_ are those of the spin law."""
    kept = {"exclude": {"preset"}}
    asked, asked_spin = asked_accuracy(TARGETS, text), asked_accuracy(SPIN, text)
    assert asked.model_dump(**kept) == TARGETS.model_dump(**kept) | expected
    assert asked_spin.model_dump(**kept) == SPIN.model_dump(**kept) | spin


def test_any_other_text_is_refused():
    for text in ("", "best", "ks", "ks=", "ks=small", "standard=1", "ks=1;auc=1", "speed=3"):
        refused("accuracy", asked_accuracy, TARGETS, text)
    refused("accuracy: ks", asked_accuracy, TARGETS, "ks=2")
    refused("accuracy: spin_ks", asked_accuracy, SPIN, "spin_ks=2")
