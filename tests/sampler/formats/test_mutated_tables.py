"""Mutated tables: nothing wrong is accepted, and no file keeps a reader longer than 30 s.

Files whose bytes were damaged are refused or read with the contents of the whole file, and so draw
the same bits. Files that were altered with their checksum made right are refused or draw finite
states within bounds.
"""

from collections import Counter
from pathlib import Path

import altered_tables
import damaged_tables
import numpy as np
import pytest
from altered_tables import alter, judge, problem_of
from damaged_tables import read_damaged

from sampler.formats.hdf5 import read_table

TABLES = sorted((Path(__file__).resolve().parents[2] / "vectors").glob("*.h5"))

#: Seconds that a reader may take for a file.
LIMIT = 30.0

#: Damaged and altered files of the study; in all ten thousand.
DAMAGED, ALTERED = 7_000, 3_000


def tried(seeds, acceptable, **options):
    """Have mutated tables read; how often each outcome came."""
    kinds = Counter()
    for outcome in read_damaged(TABLES, seeds, limit=LIMIT, **options):
        assert outcome.kind in acceptable, outcome
        assert outcome.seconds < LIMIT, outcome
        kinds[outcome.kind] += 1
    assert kinds.total() == len(seeds)
    return kinds


@pytest.mark.study
def test_damaged_tables_are_refused_or_the_same(capsys):
    kinds = tried(range(2 * 10**8, 2 * 10**8 + DAMAGED), damaged_tables.ACCEPTABLE)
    with capsys.disabled():
        print(f"\ndamaged: {dict(kinds)}")
    assert kinds["refused"] > DAMAGED / 4


@pytest.mark.study
def test_altered_tables_are_refused_or_draw_within_bounds(capsys):
    program = altered_tables.__file__
    kinds = tried(range(ALTERED), altered_tables.ACCEPTABLE, program=program)
    with capsys.disabled():
        print(f"\naltered: {dict(kinds)}")
    assert min(kinds.values()) > ALTERED / 10


@pytest.mark.parametrize("seed", range(60))
def test_some_altered_tables_in_this_process(tmp_path, seed):
    path = tmp_path / "t.h5"
    path.write_bytes(TABLES[seed % len(TABLES)].read_bytes())
    alter(path, seed)
    kind, detail = judge(path)
    assert kind in altered_tables.ACCEPTABLE, detail


def test_wrong_draws_would_be_seen(tmp_path):
    path = tmp_path / "t.h5"
    path.write_bytes(TABLES[0].read_bytes())
    assert judge(path)[0] == "drawn"
    table = read_table(path)
    columns = table.variables
    states = np.tile(np.full(len(columns), 0.5), (3, 1))
    for value in (np.nan, np.inf, 1.5):
        wrong = states.copy()
        wrong[1, columns.index("u")] = value
        assert problem_of(wrong, columns)
    wrong = states.copy()
    wrong[2, columns.index("v")] = 0.0
    assert problem_of(wrong, columns) == "a particle does not leave"
    assert not problem_of(states, columns)
