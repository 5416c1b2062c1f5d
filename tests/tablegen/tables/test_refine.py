"""Plans: sizes and nodes that follow the accuracy, with the same result whoever computes them."""

import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from tiny_tables import REFINE, ROUGH

from tablegen.checkpoints import CheckpointStore, TaskRunner
from tablegen.config.config import Config
from tablegen.config.metric_table import METRICS
from tablegen.fitting.resolution import LADDER
from tablegen.tables.interpolation_error import CHEAP, interpolation_errors
from tablegen.tables.intervals import Grid
from tablegen.tables.plan import make_plan
from tablegen.tables.refine import NodeCache
from tablegen.tables.refine import refine_grid as refine_nodes

MODULE = sys.modules[interpolation_errors.__module__]
ACCURACY = {"ks": 0.3, "sliced_wasserstein": 1.0, "correlation_error": 1.0, "auc": 0.9}


def open_config(accuracy=ACCURACY, **table):
    """The rough scene with nodes left to the generator."""
    tree = ROUGH.model_dump(mode="json", by_alias=True, exclude_none=True)
    tree["table"] = {"seed": 5, "samples_per_node": 2000, "quantile_knots": 33, **table}
    return Config.from_tree({**tree, "accuracy": accuracy})


def refine_grid(config, runner):
    return refine_nodes(make_plan(config), NodeCache(config, runner))


@pytest.fixture(autouse=True)
def few_states(monkeypatch):
    monkeypatch.setattr(MODULE, "sample_size", lambda targets, smallest=0: 2000)


def mixture_error(components):
    return 0.4 * (components / 26.0) ** -0.75


@pytest.fixture
def errors(monkeypatch):
    """Trials by a known law instead of by simulation: quadratic in the steps of the angle."""

    def trial(config, place, condition, nodes, names):
        error = 0.05 * np.ptp(place.alpha_deg) ** 2 * config.accuracy.ks
        distances = {name: np.array(metric.least) for name, metric in METRICS.items()}
        auc = np.array(0.5 + mixture_error(nodes[0].mean.shape[0]))
        distances |= {"ks": np.array([error]), "auc": auc}
        return {name: distances[name] for name in names}

    monkeypatch.setattr(REFINE, "interpolation_errors", trial)


@pytest.mark.usefixtures("errors")
class TestLaw:
    """The mixture may use up 0.66 of the 0.4 that the AUC is allowed above 0.5."""

    def test_smallest_mixture_that_leaves_room_is_chosen(self):
        refined = refine_grid(open_config(), TaskRunner())
        assert refined.size.components == next(k for k in LADDER if mixture_error(k) <= 0.66 * 0.4)
        largest = make_plan(open_config()).sizes[-1].components
        assert LADDER[0] < refined.size.components < largest < LADDER[-1]

    def test_mixture_is_never_larger_than_planned(self, monkeypatch):
        monkeypatch.setattr(sys.modules[__name__], "mixture_error", lambda components: 0.4)
        config = open_config()
        assert refine_grid(config, TaskRunner()).size == make_plan(config).sizes[-1]

    def test_nodes_are_placed_by_the_error(self):
        refined = refine_grid(open_config(components=200), TaskRunner())
        steps = np.diff(refined.placement.grid.alpha_deg)
        # ten degrees would be wrong by 5, five by 1.25, two and a half by 0.3
        assert refined.placement.reached
        assert 2.0 < steps.min() <= steps.max() < 4.2
        assert len(refined.nodes) == np.prod([len(axis) for axis in refined.placement.grid])

    def test_named_nodes_are_not_tried(self, monkeypatch):
        monkeypatch.setattr(REFINE, "interpolation_errors", None)
        nodes = {"alpha_nodes_deg": (35.0, 45.0), "speed_nodes": (60.0, 300.0)}
        refined = refine_grid(open_config(components=4, **nodes), TaskRunner())
        assert refined.placement.grid == Grid((35.0, 45.0), (60.0, 300.0))

    def test_one_named_axis_is_left_alone(self):
        refined = refine_grid(
            open_config(components=200, alpha_nodes_deg=(35.0, 45.0)), TaskRunner()
        )
        assert refined.placement.grid.alpha_deg == (35.0, 45.0)
        assert not refined.placement.reached


def test_classifier_is_asked_in_the_worst_cell_between_two_angles(monkeypatch):
    asked = []

    def trial(config, place, condition, nodes, names):
        asked.append((place, tuple(names)))
        distances = {name: np.array(METRICS[name].least) for name in names}
        if "ks" in names:
            distances["ks"] = config.accuracy.ks * 1e-3 * np.array([condition[1]])
        return distances

    monkeypatch.setattr(REFINE, "interpolation_errors", trial)
    config = open_config(components=4, alpha_nodes_deg=(35.0, 40.0, 45.0))
    grid = refine_grid(config, TaskRunner()).placement.grid
    classified = [place for place, names in asked if "auc" in names]
    assert {names for place, names in asked if place not in classified} == {CHEAP}
    fastest = grid.speed[-2:]
    assert len(grid.speed) > 2
    assert sorted({*classified}) == [((35.0, 40.0), fastest), ((40.0, 45.0), fastest)]


class TestSimulated:
    def test_same_plan_on_any_number_of_workers_and_when_resumed(self, tmp_path):
        config = open_config(components=8).with_changes({"domain": {"speed": [150.0, 150.0]}})
        grids = []
        for workers in (1, 3):
            with ThreadPoolExecutor(workers) as pool:
                grids.append(refine_grid(config, TaskRunner(executor=pool)))
        store = CheckpointStore(tmp_path / "t.h5", "fingerprint", resume=True)
        refine_grid(config, TaskRunner(store))
        pieces = sorted(store.folder.glob("piece-*"))
        for piece in pieces[::2]:
            piece.unlink()
        grids.append(refine_grid(config, TaskRunner(store)))
        first = grids[0]
        for refined in grids[1:]:
            assert refined[:2] == first[:2]
            for a, b in zip(refined.nodes, first.nodes, strict=True):
                for x, y in zip(a, b, strict=True):
                    np.testing.assert_array_equal(x, y)
