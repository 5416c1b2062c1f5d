"""How accuracy is measured: with which random numbers, and with how many states."""

import sys

import numpy as np
import pytest
from tiny_tables import ROUGH, TINY

from sampler.table import Table
from tablegen.accuracy.comparison import compare
from tablegen.accuracy.measure import FIRST_STREAM, ComparedCondition, measure, sample_size
from tablegen.checkpoints import TaskRunner
from tablegen.config.metric_table import METRICS, PRESETS
from tablegen.fitting import node
from tablegen.fitting.node import node_stream
from tablegen.simulation.simulate import make_condition, simulate, simulate_condition
from tablegen.tables.assembly import assemble
from tablegen.tables.axes import first_grid, make_axes
from tablegen.tables.refine import fit_nodes

MEASURE = sys.modules[measure.__module__]
SIMULATE = sys.modules[simulate.__module__]


def lax():
    """An accuracy that any table has at the first look."""
    return ROUGH.accuracy


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
        nodes = fit_nodes(ROUGH, first_grid(ROUGH), TaskRunner())
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
        assert sorted(measured) == [FIRST_STREAM, FIRST_STREAM + 1, FIRST_STREAM + 2]

    def test_hold_other_particles(self):
        run = 0.7, 100.0, 100
        a, b = (
            simulate(ROUGH, *run, seed=ROUGH.table.seed, stream=stream).state
            for stream in (0, FIRST_STREAM)
        )
        assert not np.isin(a, b).any()


class TestMeasure:
    CONDITIONS = ((40.0, 100.0), (38.0, 250.0))

    def test_is_the_comparison_of_draws_with_simulation(self, tiny):
        table = tiny.generated.table
        found = measure(table, TINY, self.CONDITIONS, seed=9, samples=500, targets=lax())
        for k, (alpha_deg, speed) in enumerate(self.CONDITIONS):
            alpha1 = np.radians(alpha_deg)
            direct = simulate(TINY, alpha1, speed, 500, seed=9, stream=FIRST_STREAM + k)
            drawn = table.sample(alpha1, speed, seed=9, hit=k, index=range(500))
            assert found[k] == compare(drawn, direct.state, alpha_deg, speed, seed=9)

    def test_simulates_what_the_configuration_says(self, tiny, monkeypatch):
        """Another resolution of sustained contact, tolerance and population reach the model."""
        seen = []

        def recording(pair, population, condition, *arguments, **options):
            seen.append((pair, population, condition))
            return simulate_condition(pair, population, condition, *arguments, **options)

        monkeypatch.setattr(SIMULATE, "simulate_condition", recording)
        numerics = {"contact_resolution": 0.01, "tolerance": 1e-8}
        changes = {"model": numerics, "population": {"shapes": {"prism": 0.0}}}
        config, place = TINY.with_changes(changes), self.CONDITIONS[:1]
        measure(tiny.generated.table, config, place, seed=1, samples=100, targets=lax())
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


#: Holds for any table.
LAX = {name: min(metric.most, 9.0) for name, metric in METRICS.items()}


class TestLooks:
    """More states are taken where noise leaves the verdict open, and nowhere else."""

    PLACE = ((40.0, 100.0),)

    def found(self, tiny, samples=1000, **accuracy):
        targets = TINY.with_changes({"accuracy": accuracy}).accuracy
        (comparison,) = measure(
            tiny.generated.table, TINY, self.PLACE, seed=1, samples=samples, targets=targets
        )
        return comparison

    def test_first_look_is_enough_where_everything_is_clear(self, tiny):
        comparison = self.found(tiny, **LAX)
        assert comparison.states == 1000
        far = self.found(tiny, **{**LAX, "ks": 1e-3, "auc": 0.5})
        assert far.estimates["ks"] != comparison.estimates["ks"]

    @pytest.mark.parametrize("name", METRICS)
    def test_only_what_is_open_is_measured_again(self, tiny, name):
        first = self.found(tiny, **LAX)
        exact = max(METRICS[name].least, 1e-6)
        # an accuracy that noise neither grants nor refuses: the table is off by a little only
        open_ = self.found(tiny, **{**LAX, name: max(exact, first.estimates[name].value)})
        assert open_.states in (3000, 9000)
        assert open_.estimates[name].standard_error < first.estimates[name].standard_error
        assert open_.distances()[name] != first.distances()[name]
        for other in set(first.estimates) - {name}:
            assert open_.estimates[other] == first.estimates[other]

    def test_more_states_are_those_and_others(self, tiny):
        """The first states stay; ten thousand more change the distance by less than its noise."""
        place = ComparedCondition(tiny.generated.table, TINY, 40.0, 100.0, 1, 0)
        for few, many in zip(place.states(500), place.states(1500), strict=True):
            np.testing.assert_array_equal(few, many[:500])


class TestSampleSize:
    def test_is_larger_for_a_finer_accuracy(self):
        sizes = [
            sample_size(TINY.with_changes({"accuracy": PRESETS[name]}).accuracy)
            for name in ("compact", "standard", "fine")
        ]
        assert sizes == [100_000, 400_000, 1_600_000]
