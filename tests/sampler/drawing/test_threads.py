"""Rows shared among threads: all of them once, in slices that are short enough for Ctrl-C."""

import threading
import time
from itertools import pairwise

import pytest
from interruption import interrupted
from sampler.drawing import threads as module
from sampler.drawing.threads import run_rows

from sampler.errors import NOT_FINITE, OK


@pytest.fixture
def slices(monkeypatch):
    """Kernel that notes its slices; a slice has at most 100 rows."""
    monkeypatch.setattr(module, "_SLICE", 100)
    seen = []

    def batch(start, stop):
        seen.append((start, stop))
        return -1, OK, -1, 0, 0

    batch.seen = seen
    return batch


@pytest.mark.parametrize("threads", [1, 2, 3, 8])
@pytest.mark.parametrize("n", [0, 1, 100, 101, 999])
def test_every_row_is_drawn_once(slices, threads, n):
    run_rows(slices, (), n, threads)
    parts = sorted(part for part in slices.seen if part[1] > part[0])
    assert [start for start, _ in parts[:1]] == [0] * (n > 0)
    assert all(one[1] == next_one[0] for one, next_one in pairwise(parts))
    assert sum(stop - start for start, stop in parts) == n
    assert all(stop - start <= 100 for start, stop in parts)


@pytest.mark.parametrize("threads", [1, 2])
def test_nothing_is_drawn_long_after_an_error(monkeypatch, threads):
    monkeypatch.setattr(module, "_SLICE", 100)
    begun = []

    def batch(start, stop):
        begun.append(start)
        time.sleep(0.002)
        return (start, NOT_FINITE, -1, 0, 0) if start else (-1, OK, -1, 0, 0)

    reports = run_rows(batch, (), 100_000, threads)
    assert [report.code for report in reports] == [OK, NOT_FINITE]
    assert len(begun) < 100


@pytest.mark.parametrize("threads", [1, 2])
def test_ctrl_c_ends_a_run_between_slices(threads):
    begun = threading.Event()

    def batch(start, stop):
        begun.set()
        time.sleep(0.01)
        return -1, OK, -1, 0, 0

    with interrupted(within=1.0, begun=begun):
        run_rows(batch, (), 1000 * module._SLICE, threads)
