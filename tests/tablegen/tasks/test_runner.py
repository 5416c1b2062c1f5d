"""Tasks with keys: order, checkpoints, interruption, time."""

import re
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from threadpoolctl import ThreadpoolController, threadpool_limits

from sampler.errors import InputError
from tablegen.tasks.checkpoint import CheckpointStore
from tablegen.tasks.runner import SECONDS, STAGES, Stopwatch, Task, TaskRunner, stable_number


def square(number, seconds=(1.0, 2.0, 4.0)):
    return {"square": np.array(number**2), SECONDS: np.array(seconds)}


def squares(*numbers):
    return {f"square {n}": Task(square, (n,)) for n in numbers}


def failing(number):
    raise ZeroDivisionError(number)


@pytest.fixture
def store(tmp_path):
    return CheckpointStore(tmp_path / "t.h5", "fingerprint")


class TestNumbers:
    def test_are_those_of_the_key_alone(self):
        # the first digits of: printf 'node 1.0 2.0' | sha256sum
        assert f"{stable_number('node 1.0 2.0', 48):012x}" == "861291e38d17"

    @pytest.mark.parametrize("bits", [1, 31, 48])
    def test_stay_below_their_size(self, bits):
        numbers = [stable_number(f"{k}", bits) for k in range(200)]
        assert max(numbers) < 2**bits
        assert max(numbers) >= 0.9 * 2**bits or bits == 1
        assert len(set(numbers)) == (2 if bits == 1 else 200)


class TestRun:
    def test_results_come_in_the_order_of_the_tasks(self):
        def slow(number):
            time.sleep(0.02 * (3 - number))
            return square(number)

        tasks = {f"{n}": Task(slow, (n,)) for n in range(3)}
        with ThreadPoolExecutor(3) as pool:
            found = TaskRunner(executor=pool).run("squares", tasks)
        assert [int(arrays["square"]) for arrays in found.values()] == [0, 1, 4]
        assert list(found) == ["0", "1", "2"]

    def test_without_tasks(self):
        assert TaskRunner().run("nothing", {}) == {}

    def test_checkpoints_are_found_again(self, store):
        TaskRunner(store).run("squares", squares(2, 3))
        changed = {key: Task(failing, (0,)) for key in squares(2, 3)}
        found = TaskRunner(store).run("squares", changed)
        assert [int(arrays["square"]) for arrays in found.values()] == [4, 9]
        with pytest.raises(ZeroDivisionError):
            TaskRunner(store).run("squares", {"square 4": Task(failing, (0,))})

    def test_a_failure_keeps_what_was_finished(self, store):
        tasks = squares(2, 3) | {"bad": Task(failing, (0,))}
        with ThreadPoolExecutor(1) as pool, pytest.raises(ZeroDivisionError):
            TaskRunner(store, pool).run("squares", tasks)
        found = TaskRunner(store).run("squares", {k: Task(failing, (0,)) for k in squares(2, 3)})
        assert len(found) == 2

    def test_progress_shows_what_is_done_and_the_note(self, terminal, capsys):
        runner = TaskRunner(progress=True)
        runner.note = "worst error 1.25"
        runner.run("squares", squares(2, 3))
        shown = capsys.readouterr().err
        assert "squares" in shown
        assert "2/2" in shown
        assert "worst error 1.25" in shown

    def test_progress_shows_the_time_that_is_left(self, terminal, capsys):
        def slow(number):
            time.sleep(0.06)
            return square(number)

        with ThreadPoolExecutor(1) as pool:
            tasks = {f"{n}": Task(slow, (n,)) for n in range(4)}
            TaskRunner(executor=pool, progress=True).run("squares", tasks)
        # done of all, time passed < time left
        assert re.search(r" [123]/4 \[\d\d:\d\d<\d\d:\d\d,", capsys.readouterr().err)

    def test_results_are_reported_as_they_come_and_move_the_note(self, terminal, store, capsys):
        runner = TaskRunner(store, progress=True)
        seen = []

        def on_result(key, arrays):
            seen.append((key, int(arrays["square"])))
            runner.note = f"largest {arrays['square']}"

        runner.run("squares", squares(2), on_result)
        # found again, then made
        runner.run("squares", squares(2, 3), on_result)
        assert seen == [("square 2", 4), ("square 2", 4), ("square 3", 9)]
        assert "largest 9" in capsys.readouterr().err

    def test_checkpoint_that_cannot_be_written_ends_the_run_and_cancels_the_others(
        self, store, monkeypatch
    ):
        def full(key, arrays):
            raise InputError("output: cannot write")

        monkeypatch.setattr(store, "save", full)
        begun, go_on = [], threading.Event()

        def waiting(number):
            begun.append(number)
            if len(begun) > 1:
                go_on.wait(60.0)
            return square(number)

        tasks = {f"{n}": Task(waiting, (n,)) for n in range(5)}
        with ThreadPoolExecutor(1) as pool:
            with pytest.raises(InputError):
                TaskRunner(store, pool).run("squares", tasks)
            go_on.set()
        assert begun in ([0], [0, 1])


def test_linear_algebra_keeps_to_one_thread_while_tasks_overlap():
    """The first task to end must not give the other its threads back, which may change sums."""
    blas = ThreadpoolController().select(user_api="blas")
    one_in, two_in, one_out = (threading.Event() for _ in range(3))
    seen = []

    def first():
        with threadpool_limits(limits=1, user_api="blas"):
            one_in.set()
            assert two_in.wait(60.0)
        one_out.set()
        return square(1)

    def second():
        assert one_in.wait(60.0)
        with threadpool_limits(limits=1, user_api="blas"):
            two_in.set()
            assert one_out.wait(60.0)
            seen.extend(library["num_threads"] for library in blas.info())
        return square(2)

    with ThreadPoolExecutor(2) as pool:
        tasks = {"1": Task(first, ()), "2": Task(second, ())}
        TaskRunner(executor=pool).run("squares", tasks)
    assert set(seen) == {1}


class TestTime:
    def test_adds_up_by_stage(self, store):
        runner = TaskRunner(store)
        runner.run("squares", squares(2, 3))
        runner.run("squares", squares(4))
        assert runner.seconds == {"simulation": 3.0, "fit": 6.0, "check": 12.0}
        # work that was found again was done as well, once
        resumed = TaskRunner(store)
        resumed.run("squares", squares(2))
        assert sum(resumed.seconds.values()) == 7.0

    def test_stopwatch_gives_each_stage_its_time(self):
        watch = Stopwatch()
        time.sleep(0.02)
        watch.stage("fit")
        time.sleep(0.05)
        watch.stage("check")
        watch.stage("fit")
        seconds = dict(zip(STAGES, watch.seconds, strict=True))
        assert seconds["simulation"] == 0.0
        assert seconds["fit"] >= 0.02
        assert seconds["check"] >= 0.05
        assert seconds["check"] > seconds["fit"]
