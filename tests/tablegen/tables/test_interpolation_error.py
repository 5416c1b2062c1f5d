"""Interpolation errors: in units of what is allowed, and of right and of wrong nodes."""

import sys

import numpy as np
import pytest
from tiny_tables import ROUGH, TINY

from tablegen.config.config import AccuracyTargets
from tablegen.config.metric_table import METRICS, worst_share
from tablegen.fitting.node import fit_node
from tablegen.tables.interpolation_error import CHEAP, interpolation_errors
from tablegen.tables.intervals import Place

MODULE = sys.modules[interpolation_errors.__module__]
HERE = Place((35.0,), (150.0,))
TARGETS = AccuracyTargets(ks=0.1, sliced_wasserstein=0.1, correlation_error=0.2, auc=0.7)


@pytest.fixture(autouse=True)
def few_states(monkeypatch):
    monkeypatch.setattr(MODULE, "sample_size", lambda targets, smallest=0: 5000)


def worst(distances):
    largest = {name: float(np.max(values)) for name, values in distances.items()}
    return worst_share(largest, TARGETS.model_dump())


@pytest.mark.parametrize("name", METRICS)
def test_error_is_in_units_of_what_is_allowed(name):
    least = METRICS[name].least
    equal_laws = {name: metric.least for name, metric in METRICS.items()}
    half = {name: least + 0.5 * (getattr(TARGETS, name) - least)}
    assert worst(equal_laws | half) == (pytest.approx(0.5), name)


class TestNodes:
    """Of 6,000 simulated states; 5,000 are compared, so KS noise is 0.03 and AUC noise 0.01."""

    def test_interpolation_is_tried_in_the_middle(self):
        """Nodes ten degrees apart are good enough half-way, and not the wrong way round."""
        nodes = [fit_node(TINY, alpha, 150.0) for alpha in (35.0, 45.0)]
        place = Place((35.0, 45.0), (150.0,))
        straight = interpolation_errors(TINY, place, (39.9, 150.0), nodes)
        assert worst(straight)[0] < 1.0
        # Refused: a condition near the other end of the cell, with the nodes exchanged.
        crossed = interpolation_errors(TINY, place, (36.0, 150.0), nodes[::-1])
        assert worst(crossed)[0] > 1.0

    def test_only_the_metrics_that_are_named_are_measured(self):
        node = fit_node(ROUGH, 60.0, 150.0)
        bad = interpolation_errors(ROUGH, HERE, (35.0, 150.0), [node], CHEAP)
        assert tuple(bad) == CHEAP
        assert worst(bad)[0] > 1.0


@pytest.mark.parametrize(
    ("share", "counts"),
    [(0.8, [1250]), (0.9, [1250, 5000]), (1.5, [1250, 5000]), (1.7, [1250])],
)
def test_all_states_are_compared_only_if_few_leave_it_open(monkeypatch, share, counts):
    """Few states decide whether an error is small enough, or far too large."""
    node, compared = fit_node(ROUGH, 60.0, 150.0), []

    def compare(config, table, condition, states, names):
        compared.append(states)
        return {name: np.array(share * getattr(config.accuracy, name)) for name in names}

    monkeypatch.setattr(MODULE, "_compare", compare)
    errors = interpolation_errors(ROUGH, HERE, (35.0, 150.0), [node], CHEAP)
    assert compared == counts
    assert errors["ks"] == share * ROUGH.accuracy.ks


def test_classifier_gets_the_states_that_it_learns_from(monkeypatch):
    node, compared = fit_node(ROUGH, 60.0, 150.0), []

    def compare(config, table, condition, states, names):
        compared.append(states)
        return {}

    monkeypatch.setattr(MODULE, "_compare", compare)
    monkeypatch.setattr(MODULE, "sample_size", lambda targets, smallest=0: 10**6)
    interpolation_errors(ROUGH, HERE, (35.0, 150.0), [node], ("auc",))
    assert compared == [METRICS["auc"].trial_states]
