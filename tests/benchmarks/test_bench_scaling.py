"""The benchmark of sizes times tables that have them."""

import bench_scaling
import pytest
from bench_scaling import Size


# fits a table of some size
@pytest.mark.study
def test_tables_have_the_sizes_that_are_said():
    table = bench_scaling.make_table(Size("knots", (3, 2), 32, 33))
    assert (len(table.alpha_nodes_deg), len(table.speed_nodes)) == (3, 2)
    assert (table.arrays.n_components, table.arrays.n_knots) == (32, 33)


def test_every_size_is_measured_and_plotted(monkeypatch, tmp_path):
    monkeypatch.setattr(bench_scaling, "SAMPLES", 4000)
    chosen = [Size(name, (2, 2), 4, 17) for name in ("nodes", "components", "knots")]
    rows = bench_scaling.measure(chosen, 100, 1)
    assert [row["value"] for row in rows] == [4, 4, 17]
    assert all(row["random_ns"] > 0.0 and row["one_condition_ns"] > 0.0 for row in rows)
    pytest.importorskip("matplotlib")
    bench_scaling.plot(rows, tmp_path / "scaling.png")
    assert (tmp_path / "scaling.png").stat().st_size > 10_000
