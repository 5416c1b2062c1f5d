"""`tablegen.parallel`: order of results, errors, and how far ahead pieces are started."""

import threading
import time

import numpy as np  # noqa: F401  (loads the library of linear algebra)
import pytest
from threadpoolctl import threadpool_info

from tablegen.parallel import in_slices, in_threads


@pytest.mark.parametrize("threads", [1, 2, None])
def test_results_are_in_the_order_of_the_pieces(threads):
    def work(number):
        time.sleep(0.01 * (number % 3))  # later pieces end earlier
        return number**2

    ticks = []
    assert in_threads(work, iter(range(20)), ticks.append, threads) == [n**2 for n in range(20)]
    assert ticks == [1] * 20


def test_pieces_run_side_by_side():
    barrier = threading.Barrier(2, timeout=10.0)
    in_threads(lambda _: barrier.wait(), range(2), threads=2)


def test_linear_algebra_keeps_to_one_thread():
    def threads_of_blas(_):
        return {x["num_threads"] for x in threadpool_info() if x["user_api"] == "blas"}

    assert in_threads(threads_of_blas, range(2), threads=2) == [{1}, {1}]


@pytest.mark.parametrize("threads", [1, 2])
def test_an_error_ends_the_work(threads):
    begun = []

    def work(number):
        begun.append(number)
        if number == 3:
            raise ValueError("piece 3")
        time.sleep(0.01)

    with pytest.raises(ValueError, match="piece 3"):
        in_threads(work, range(1000), threads=threads)
    time.sleep(0.05)
    assert len(begun) <= 3 + 2 * threads + 1


@pytest.mark.parametrize("threads", [1, 3])
def test_slices_cover_all_particles_once_and_in_order(threads):
    slices = [part for part, _ in in_slices(lambda part: None, 12_345, threads)]
    assert [number for part in slices for number in range(part.start, part.stop)] == [
        *range(12_345)
    ]


def test_pieces_are_taken_only_a_little_ahead():
    taken, ahead, ticks = 0, [], []

    def pieces():
        nonlocal taken
        for number in range(100):
            taken += 1
            ahead.append(taken - len(ticks))
            yield number

    in_threads(lambda number: number, pieces(), ticks.append, threads=2)
    assert max(ahead) == 4
