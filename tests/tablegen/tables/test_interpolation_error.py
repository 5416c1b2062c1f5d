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
