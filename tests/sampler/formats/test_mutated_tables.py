"""Altered tables with a right checksum: refused, or finite states within the bounds of physics."""

from pathlib import Path

import altered_tables
import numpy as np
import pytest
from altered_tables import alter, judge

TABLES = sorted((Path(__file__).resolve().parents[2] / "vectors").glob("*.h5"))


@pytest.mark.parametrize("seed", range(40))
def test_is_refused_or_draws_within_bounds(tmp_path, seed):
    path = tmp_path / "t.h5"
    path.write_bytes(TABLES[seed % len(TABLES)].read_bytes())
    alter(path, seed)
    kind, detail = judge(path)
    assert kind in altered_tables.ACCEPTABLE, detail


@pytest.mark.study
def test_three_thousand_more(tmp_path):
    kinds = []
    for seed in range(1000, 4000):
        path = tmp_path / "t.h5"
        path.write_bytes(TABLES[seed % len(TABLES)].read_bytes())
        alter(path, seed)
        kind, detail = judge(path)
        assert kind in altered_tables.ACCEPTABLE, (seed, detail)
        kinds.append(kind)
    assert min(np.unique(kinds, return_counts=True)[1]) > 300
