"""Where accuracy is measured, with which random numbers, and how a miss is reported."""

import sys
from dataclasses import replace

import numpy as np
import pytest
from tiny_tables import ROUGH, TINY

import sampler
from sampler.table import Table
from tablegen.accuracy import compare
from tablegen.assembly import assemble
from tablegen.config import AccuracyTargets
from tablegen.fitting import node
from tablegen.fitting.axes import first_grid, make_axes
from tablegen.fitting.node import fit_node, node_stream
from tablegen.measure import FIRST_STREAM, measure, missed_targets, pick_conditions
from tablegen.plan import fit_nodes
from tablegen.simulate import make_condition, simulate, simulate_condition
from tablegen.workshop import Workshop

MEASURE = sys.modules[measure.__module__]
SIMULATE = sys.modules[simulate.__module__]


def grid_table(alpha_nodes_deg, speed_nodes):
    """Table on a grid with the same rough node everywhere."""
    config = ROUGH.with_changes(
        {
            "domain": {
                "alpha_deg": [alpha_nodes_deg[0], alpha_nodes_deg[-1]],
                "speed": [speed_nodes[0], speed_nodes[-1]],
            },
            "table": {
                "alpha_nodes_deg": alpha_nodes_deg,
                "speed_nodes": speed_nodes,
                "samples_per_node": 200,
            },
        }
    )
    nodes = [fit_node(config, 35.0, 60.0)] * (len(alpha_nodes_deg) * len(speed_nodes))
    return Table(assemble(config, make_axes(config), nodes))


def node_index(table, alpha_deg, speed):
    """Fractional node index of conditions, straight from its definition."""
    alpha_nodes, speed_nodes = table.contents["axes/alpha_deg"], table.contents["axes/speed"]
    abscissa = -ROUGH.speed_coordinate(speed_nodes)
    return (
        np.interp(np.sqrt(alpha_deg), np.sqrt(alpha_nodes), np.arange(len(alpha_nodes))),
        np.interp(-ROUGH.speed_coordinate(speed), abscissa, np.arange(len(speed_nodes))),
    )


@pytest.fixture(scope="module")
def table():
    return grid_table([1.0, 2.0, 30.0, 90.0], [50.0, 90.0, 100.0, 200.0, 300.0])


class TestConditions:
    @pytest.mark.parametrize("count", [1, 7, 500])
    def test_lie_well_between_nodes(self, table, count):
        alpha, speed = np.array(pick_conditions(table, count, seed=1)).T
        assert len(alpha) == count
        for index in node_index(table, alpha, speed):
            # a fifth of a cell away from any node; 0.005 for the entries of the look-up
            assert np.abs(index - np.round(index)).min() > 0.195
        assert not np.isin(alpha, table.contents["axes/alpha_deg"]).any()
        assert not np.isin(speed, table.contents["axes/speed"]).any()

    def test_reach_every_cell_evenly(self, table):
        alpha, speed = np.array(pick_conditions(table, 60, seed=2)).T
        cells = [np.floor(index).astype(int) for index in node_index(table, alpha, speed)]
        np.testing.assert_array_equal(np.bincount(cells[0]), [20, 20, 20])
        np.testing.assert_array_equal(np.bincount(cells[1]), [15, 15, 15, 15])
        # ... and not along a diagonal of the grid.
        assert len(set(zip(*map(tuple, cells), strict=True))) > 8

    def test_are_a_function_of_the_seed(self, table):
        first = pick_conditions(table, 5, seed=1)
        assert first == pick_conditions(table, 5, seed=1)
        assert first != pick_conditions(table, 5, seed=2)
        assert all(type(value) is float for pair in first for value in pair)

    def test_axis_of_one_node_has_only_that(self):
        table = grid_table([40.0], [50.0, 300.0])
        conditions = pick_conditions(table, 4, seed=1)
        assert [alpha for alpha, _ in conditions] == [40.0] * 4
        assert len({speed for _, speed in conditions}) == 4


class TestStreams:
    """A node and a measurement never see the same particle, nor do two conditions."""

    @pytest.fixture
    def streams(self, monkeypatch):
        """(module, seed, stream) of every simulation."""
        seen = []

        def recording(module):
            def record(*arguments, seed, stream, **options):
                seen.append((module, seed, stream))
                return simulate(*arguments, seed=seed, stream=stream, **options)

            return record

        monkeypatch.setattr(node, "simulate", recording("node"))
        monkeypatch.setattr(MEASURE, "simulate", recording("measure"))
        return seen

    def test_of_nodes_and_of_measurements_are_apart(self, streams):
        nodes = fit_nodes(ROUGH, first_grid(ROUGH), Workshop())
        table = Table(assemble(ROUGH, make_axes(ROUGH), nodes))
        # the seed of the nodes: only the streams keep the two apart
        conditions = [(40.0, 100.0), (41.0, 120.0), (42.0, 140.0)]
        measure(table, ROUGH, conditions, seed=ROUGH.table.seed, samples=200)
        assert {seed for _, seed, _ in streams} == {ROUGH.table.seed}
        of_nodes = {stream for module, _, stream in streams if module == "node"}
        measured = [stream for module, _, stream in streams if module == "measure"]
        assert of_nodes == {node_stream(a, v) for a in (35.0, 45.0) for v in (60.0, 300.0)}
        assert len(of_nodes) == 4
        assert max(of_nodes) < FIRST_STREAM
        assert measured == [FIRST_STREAM, FIRST_STREAM + 1, FIRST_STREAM + 2]

    def test_hold_other_particles(self):
        condition = make_condition(0.7, 100.0)
        keys = {"seed": ROUGH.table.seed, "threads": 1}
        a, b = (
            simulate_condition(
                ROUGH.pair, ROUGH.population, condition, 100, stream=stream, **keys
            ).state
            for stream in (0, FIRST_STREAM)
        )
        assert not np.isin(a, b).any()


class TestMeasure:
    CONDITIONS = ((40.0, 100.0), (38.0, 250.0))

    def test_is_the_comparison_of_draws_with_simulation(self, tiny):
        table = tiny.generated.table
        found = measure(table, TINY, self.CONDITIONS, seed=9, samples=500)
        for k, (alpha_deg, speed) in enumerate(self.CONDITIONS):
            alpha1 = np.radians(alpha_deg)
            direct = simulate_condition(
                TINY.pair,
                TINY.population,
                make_condition(alpha1, speed),
                500,
                seed=9,
                stream=FIRST_STREAM + k,
            )
            drawn = table.sample(alpha1, speed, seed=9, hit=k, index=range(500))
            assert found[k] == compare(drawn, direct.state, alpha_deg, speed, seed=9)

    def test_simulates_what_the_configuration_says(self, tiny, monkeypatch):
        """Another resolution of sustained contact, tolerance and population reach the model."""
        seen = []

        def recording(pair, population, condition, *arguments, **options):
            seen.append((pair, population, condition))
            return simulate_condition(pair, population, condition, *arguments, **options)

        monkeypatch.setattr(SIMULATE, "simulate_condition", recording)
        config = TINY.with_changes(
            {
                "model": {"contact_resolution": 0.01, "tolerance": 1e-8},
                "population": {"shapes": {"prism": 0.0}},
            }
        )
        measure(tiny.generated.table, config, self.CONDITIONS[:1], seed=1, samples=100)
        ((pair, population, condition),) = seen
        assert (pair, population) == (config.pair, config.population)
        expected = make_condition(np.radians(40.0), 100.0, resolution=0.01, tolerance=1e-8)
        assert condition == expected != make_condition(np.radians(40.0), 100.0)

    def test_takes_any_seed(self, tiny):
        first, second = (
            measure(tiny.generated.table, TINY, self.CONDITIONS[:1], seed=seed, samples=200)
            for seed in (2**64 - 1, 2**32 - 1)
        )
        assert first != second


class TestMissedTargets:
    TARGETS = AccuracyTargets(ks=0.03, sliced_wasserstein=0.02, correlation_error=0.05, auc=0.7)

    @pytest.fixture
    def good(self, tiny):
        table = sampler.load(tiny.path)
        (comparison,) = measure(table, TINY, [(40.0, 100.0)], seed=1, samples=200)
        return replace(
            comparison,
            ks=(0.01, 0.03, 0.0, 0.02, 0.01, 0.01),
            sliced_wasserstein=0.02,
            correlation_error=0.05,
            auc=0.7,
        )

    def test_limits_themselves_hold(self, good):
        assert missed_targets([good, good], self.TARGETS) == []

    @pytest.mark.parametrize(
        ("change", "line"),
        [
            (
                {"ks": (0.01, 0.01, 0.0, 0.0, 0.031, 0.0)},
                "ks: 0.0310 at 77.50 degrees, 222.0 m/s, declared at most 0.03",
            ),
            (
                {"sliced_wasserstein": 0.021},
                "sliced_wasserstein: 0.0210 at 77.50 degrees, 222.0 m/s, declared at most 0.02",
            ),
            (
                {"correlation_error": 0.5},
                "correlation_error: 0.5000 at 77.50 degrees, 222.0 m/s, declared at most 0.05",
            ),
            ({"auc": 0.75}, "auc: 0.7500 at 77.50 degrees, 222.0 m/s, declared at most 0.7"),
        ],
    )
    def test_each_says_what_where_and_how_much(self, good, change, line):
        bad = replace(good, alpha_deg=77.5, speed=222.0, **change)
        assert missed_targets([good, bad, good], self.TARGETS) == [line]

    def test_worst_condition_is_named_once(self, good):
        bad = replace(good, auc=0.8, alpha_deg=10.0)
        worse = replace(good, auc=0.9, alpha_deg=20.0, sliced_wasserstein=1.0)
        lines = missed_targets([bad, worse], self.TARGETS)
        assert [line.split(":")[0] for line in lines] == ["sliced_wasserstein", "auc"]
        assert all("20.00 degrees" in line for line in lines)

    def test_not_a_number_is_a_miss(self, good):
        nan = replace(good, auc=float("nan"))
        assert len(missed_targets([nan], self.TARGETS)) == 1
