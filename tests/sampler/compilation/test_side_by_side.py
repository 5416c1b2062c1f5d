"""Work on threads: results in order, few at a time, and an end when nobody wants them any more."""

import threading
import time
from itertools import count

import pytest
from interruption import interrupted
from sampler.compilation.side_by_side import GivenUpError, ThreadPool, go_on, side_by_side


def in_thread(function):
    """Result of a call in a thread that is not the main one."""
    with ThreadPool(1) as pool:
        return pool.submit(function).result()


def eventually(condition):
    """Whether a condition comes to hold within some seconds."""
    deadline = time.monotonic() + 5.0
    while not condition() and time.monotonic() < deadline:
        time.sleep(0.005)
    return condition()


@pytest.mark.parametrize("threads", [1, 2, 7])
@pytest.mark.parametrize("ahead", [None, 1, 3])
@pytest.mark.parametrize("caller", [lambda call: call(), in_thread], ids=["main", "thread"])
def test_results_are_in_the_order_of_the_pieces(threads, ahead, caller):
    def work(piece):
        time.sleep(0.003 * (piece % 3))
        return piece**2

    found = caller(lambda: list(side_by_side(work, range(9), threads, ahead)))
    assert found == [piece**2 for piece in range(9)]


def test_pieces_without_end_are_begun_when_they_are_wanted():
    begun = []
    results = side_by_side(begun.append, count(), 2, ahead=4)
    for _ in range(10):
        next(results)
    results.close()
    assert len(begun) <= 14


def test_a_single_thread_is_the_callers_own_unless_ctrl_c_reaches_it():
    own = in_thread(lambda: {threading.get_ident(), *_identities()})
    assert len(own) == 1
    assert threading.get_ident() not in _identities()


def _identities():
    return set(side_by_side(lambda _: threading.get_ident(), range(3), 1))


class TestInterruption:
    """Ctrl-C."""

    @pytest.mark.parametrize("threads", [1, 2])
    def test_pieces_that_ask_end_at_once(self, threads):
        begun, ended = threading.Event(), []

        def work(piece):
            begun.set()
            try:
                while True:
                    go_on()
                    time.sleep(0.005)
            except GivenUpError:
                ended.append(piece)
                raise

        with interrupted(within=1.0, begun=begun):
            list(side_by_side(work, range(100), threads))
        assert sorted(ended) == list(range(threads))

    def test_a_piece_that_does_not_ask_is_left_alone(self, monkeypatch):
        monkeypatch.setattr("sampler.compilation.side_by_side._PATIENCE", 0.1)
        begun, release, done = threading.Event(), threading.Event(), []

        def work(piece):
            begun.set()
            release.wait(30.0)
            done.append(piece)

        with interrupted(within=5.0, begun=begun):
            list(side_by_side(work, range(100), 1))
        release.set()
        assert eventually(lambda: done == [0])  # and no other is begun

    @pytest.mark.parametrize("inner", [1, 2])
    def test_work_within_work_ends_too(self, inner):
        begun, ended = threading.Event(), threading.Event()

        def steps(_):
            begun.set()
            while True:
                go_on()
                time.sleep(0.005)

        def work(_):
            try:
                list(side_by_side(steps, range(2), inner))
            finally:
                ended.set()

        with interrupted(within=1.0, begun=begun):
            list(side_by_side(work, range(3), 2))
        assert ended.wait(5.0)


def test_an_error_of_a_piece_ends_the_others():
    begun = []

    def work(piece):
        begun.append(piece)
        if piece == 1:
            raise ZeroDivisionError
        time.sleep(0.02)

    with pytest.raises(ZeroDivisionError):
        list(side_by_side(work, range(100), 2))
    assert len(begun) < 10


def test_what_nobody_waits_for_any_more_ends():
    begun = []

    def work(piece):
        begun.append(piece)
        time.sleep(0.01)

    for _ in side_by_side(work, range(100), 2):
        break
    reached = len(begun)
    time.sleep(0.05)
    assert len(begun) == reached < 10


def test_elsewhere_nothing_is_given_up():
    go_on()
    assert in_thread(go_on) is None
