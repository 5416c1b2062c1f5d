"""The benchmark of draws times what it says: all of them draw, and the C ones draw the same."""

import bench_draw
import numpy as np
import pytest
import toolchain

import sampler
from sampler.formats.image import write_binary_table


@pytest.fixture(scope="module")
def table():
    return sampler.load("corundum-steel")


# half a minute of compilation
@pytest.mark.study
def test_every_row_is_measured(table, tmp_path):
    conditions = bench_draw.Conditions(table, 200)
    draws = bench_draw.python_draws(table, conditions)
    if toolchain.find("gcc"):
        write_binary_table(tmp_path / "t.rbt", table.contents)
        draws |= bench_draw.c_draws(tmp_path / "t.rbt", conditions, tmp_path)
    rows = bench_draw.summarised(bench_draw.measure(draws, 200, 2))
    assert [row["name"] for row in rows] == list(draws)
    assert rows[0]["ratio"] == 1.0
    assert all(0.0 <= row["least_ns"] <= row["median_ns"] for row in rows)


# tests/embedding compares the same draws bit for bit
@pytest.mark.study
def test_python_and_c_draw_the_same(table, tmp_path):
    toolchain.require("gcc")
    conditions = bench_draw.Conditions(table, 200)
    write_binary_table(tmp_path / "t.rbt", table.contents)
    draws = bench_draw.c_draws(tmp_path / "t.rbt", conditions, tmp_path)
    bench_draw.python_draws(table, conditions)["Python, Table.sample"]()
    expected = conditions.states.copy()
    for name, draw in draws.items():
        if name != "C floor":
            conditions.states[:] = 0.0
            draw()
            np.testing.assert_array_equal(conditions.states, expected)
