"""The benchmark of spinning impacts times what it says: the same impacts in every way."""

import bench_spin
import numpy as np
import one_by_one
import pytest
from bench_spin import DIRECT, FIRST, SPINNING
from spin_tables import with_spin_law, without_spin_law

import sampler
from sampler.table import Table
from tablegen.config.config import stored_config
from tablegen.simulation.direct import DirectModel
from tablegen.simulation.impact_chains import occurring_impacts, simulated


@pytest.fixture(scope="module")
def table():
    return Table(with_spin_law(sampler.load("corundum-steel").contents))


# half a minute of compilation
@pytest.mark.study
def test_every_way_is_measured(table):
    found = bench_spin.measured(table, 100, 1)
    assert set(found) == {DIRECT, FIRST, SPINNING}
    assert len(bench_spin.ratios(found)) == 4
    plain = bench_spin.measured(Table(without_spin_law(table.contents)), 100, 1)
    assert set(plain) == {DIRECT, FIRST}
    assert bench_spin.ratios(plain) == {}


# as long, and tests/sampler and tests/tablegen compare one by one with batches
@pytest.mark.study
def test_one_by_one_is_the_same_as_in_batches(table):
    config = stored_config(table.config, "config")
    model = DirectModel(config)
    impacts = occurring_impacts(config, model, 1, np.arange(50, dtype=np.uint64))
    keys = {"seed": 1, "index": impacts.index, "hit": impacts.hit}
    last, state, key = slice(-1, None), np.empty(6), np.uint64(1)
    args = impacts.alpha1[last], impacts.speed[last]
    spin, who = impacts.spin[last], (key, impacts.index[last], impacts.hit[last])
    one_by_one.draw_first_hits(table.arrays, *args, *who, state)
    np.testing.assert_array_equal(state, table.sample(impacts.alpha1, impacts.speed, **keys)[-1])
    one_by_one.draw_spinning(table.arrays, *args, spin, *who, state)
    drawn = table.sample(impacts.alpha1, impacts.speed, spin=impacts.spin, **keys)
    np.testing.assert_array_equal(state, drawn[-1])
    work = np.empty(model.work_size)
    one_by_one.simulate_spinning(model.arrays, *args, spin, *who, work, state)
    np.testing.assert_array_equal(state, simulated(model, impacts, 1)[-1])
