"""Measuring the accuracy: random numbers, numbers of states, and datasets of a table."""

import sys
import tracemalloc
from itertools import product

import numpy as np
import pytest
from direct_table import DirectTable
from tiny_tables import ROUGH, TINY

from sampler.formats.channels import STATE
from sampler.formats.layout import ACCURACY, SPIN_DATASETS
from sampler.table import Table
from tablegen.accuracy.comparison import compare
from tablegen.accuracy.conditions import ComparedCondition
from tablegen.accuracy.descriptive import profile
from tablegen.accuracy.measure import (
    FIRST_OWN,
    FIRST_STREAM,
    compare_condition,
    measure,
    measure_chains,
    sample_size,
    spin_accuracy_datasets,
)
from tablegen.accuracy.metrics import ESTIMATES
from tablegen.checkpoints import TaskRunner
from tablegen.config.config import load_config
from tablegen.config.metric_table import CHAINS, METRICS, PRESETS, worst_stored
from tablegen.fitting import node
from tablegen.fitting.node import node_stream
from tablegen.fitting.resolution import resolution
from tablegen.simulation.simulate import simulate
from tablegen.tables.assembly import assemble
from tablegen.tables.axes import first_grid, make_axes
from tablegen.tables.refine import NodeCache

MEASURE = sys.modules[measure.__module__]
PLACES = (ComparedCondition(40.0, 100.0), ComparedCondition(38.0, 250.0))


pytestmark = pytest.mark.usefixtures("quick_classifier")


@pytest.fixture
def streams(monkeypatch):
    """Record module, seed, stream and spin of every simulation."""
    seen = []

    def recording(module):
        def record(*arguments, seed, stream, **options):
            seen.append((module, seed, stream, options.get("spin")))
            return simulate(*arguments, seed=seed, stream=stream, **options)

        return record

    monkeypatch.setattr(node, "simulate", recording("node"))
    monkeypatch.setattr(MEASURE, "simulate", recording("measure"))
    return seen


def test_nodes_and_measurements_never_see_the_same_particles(streams):
    nodes = NodeCache(ROUGH, TaskRunner()).fit(resolution(ROUGH), product(*first_grid(ROUGH)))
    table = Table(assemble(ROUGH, make_axes(ROUGH), nodes))
    # the seed of the nodes: only the streams differ
    seed = ROUGH.table.seed
    measure(table, ROUGH, PLACES, seed=seed, samples=200)
    assert {used for _, used, _, _ in streams} == {seed}
    of_nodes = {stream for module, _, stream, _ in streams if module == "node"}
    measured = [stream for module, _, stream, _ in streams if module == "measure"]
    assert of_nodes == {node_stream(a, v) for a in (35.0, 45.0) for v in (60.0, 300.0)}
    assert max(of_nodes) < FIRST_STREAM
    assert sorted(measured) == [FIRST_STREAM, FIRST_STREAM + 1]
    run = ROUGH, 0.7, 100.0, 100
    a, b = (simulate(*run, seed=seed, stream=stream).state for stream in (0, FIRST_STREAM))
    assert not np.isin(a, b).any()


def test_compares_draws_with_simulation(tiny):
    table = tiny.generated.table
    comparisons = measure(table, TINY, PLACES, seed=9, samples=500)
    for k, (alpha_deg, speed, _) in enumerate(PLACES):
        alpha1 = np.radians(alpha_deg)
        direct = simulate(TINY, alpha1, speed, 500, seed=9, stream=FIRST_STREAM + k)
        drawn = table.sample(alpha1, speed, seed=9, hit=k, index=range(500))
        assert comparisons[k] == compare(drawn, direct.state, alpha_deg, speed, seed=9)


def test_a_comparison_holds_few_copies_of_the_states(tiny, monkeypatch):
    """At any time, all arrays together take at most 5.5 times the memory of one sample."""
    monkeypatch.delitem(ESTIMATES, "auc")  # takes memory for trees, and few of the states
    count = 20_000
    condition = tiny.generated.table, TINY, 9, count, (0, PLACES[0])
    compare_condition(*condition)  # loads the kernels
    tracemalloc.start()
    compare_condition(*condition)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 5.5 * count * len(STATE) * 8


def test_sample_size_grows_with_the_accuracy():
    accuracies = [TINY.with_changes({"accuracy": PRESETS[name]}).accuracy for name in PRESETS]
    assert [sample_size(accuracy) for accuracy in accuracies] == [100_000, 400_000, 1_600_000]


CONFIG = load_config("corundum-steel")
OWN = (ComparedCondition(40.0, 100.0, own=True), ComparedCondition(86.0, 250.0, own=True))


@pytest.fixture(scope="module")
def right():
    return DirectTable(CONFIG)


def test_conditions_with_own_grain_have_streams_of_their_own(right, streams):
    (comparison, _) = measure(right, CONFIG, OWN, seed=5, samples=200)
    assert {stream for _, _, stream, _ in streams} == {
        FIRST_STREAM + FIRST_OWN + k for k in range(2)
    }
    keys = {"seed": 5, "index": range(200), "hit": FIRST_OWN}
    expected = right.sample(np.radians(40.0), 100.0, spin=np.zeros(3), **keys)
    assert comparison.table == profile(expected)


def test_is_stored_as_the_layout_says(right):
    hits = measure_chains(right, CONFIG, seed=5, samples=100)
    for measured, lengths in (
        ((measure(right, CONFIG, OWN, seed=5, samples=1000), hits), (2, 60)),
        ((), (0, 0)),
    ):
        stored = spin_accuracy_datasets(*measured)
        named = dict(zip(("n_spin_conditions", "n_chained"), lengths, strict=True))
        layout = [d for d in SPIN_DATASETS if d.path.startswith(ACCURACY)]
        assert set(stored) == {d.path for d in layout}
        for dataset in layout:
            shape = tuple((named | {"n_spin_columns": 6}).get(dim, dim) for dim in dataset.dims)
            assert stored[dataset.path].shape == shape
        kept = {name for name, metric in CHAINS.items() if metric.stored}
        limits = {*METRICS, *kept} if measured else set()
        assert set(worst_stored(stored, "spin_accuracy")) == limits
