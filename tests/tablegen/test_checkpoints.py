"""Checkpoints of tasks are kept, used again or refused; results do not depend on the order."""

import shutil
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from threadpoolctl import ThreadpoolController, threadpool_limits

import sampler
import tablegen
from sampler.errors import InputError
from tablegen.checkpoints import (
    SECONDS,
    CheckpointStore,
    Task,
    TaskRunner,
    software,
    stable_number,
)

KEY = "node 1.0 2.0"
ARRAYS = {
    "quantiles": np.linspace(0.0, 1.0, 12, dtype=np.float32).reshape(3, 4),
    "alias_index": np.array([2, 0, 65535], dtype=np.uint16),
}


@pytest.fixture
def output(tmp_path):
    return tmp_path / "t.h5"


@pytest.fixture
def store(output):
    return CheckpointStore(output, "fingerprint", resume=True)


class TestStore:
    def test_returns_the_saved_arrays(self, store):
        store.save(KEY, ARRAYS)
        loaded = store.load(KEY)
        assert loaded.keys() == ARRAYS.keys()
        for name, values in ARRAYS.items():
            np.testing.assert_array_equal(loaded[name], values)
            assert loaded[name].dtype == values.dtype
        assert store.load("another key") is None

    def test_lies_next_to_the_output_until_it_is_removed(self, store, output):
        assert list(output.parent.iterdir()) == []
        store.save(KEY, ARRAYS)
        assert store.folder == output.with_name("t.h5.parts")
        store.remove()
        assert list(output.parent.iterdir()) == []

    def test_every_damaged_byte_makes_a_piece_count_as_missing(self, store):
        store.save(KEY, ARRAYS)
        whole = store.path(KEY).read_bytes()
        places = range(len(whole))
        flipped = (whole[:k] + bytes([whole[k] ^ 0x55]) + whole[k + 1 :] for k in places)
        for content in (whole[:-40], b"", b"no", whole[:32], whole + b"x", *flipped):
            store.path(KEY).write_bytes(content)
            assert store.load(KEY) is None
            assert store.seconds() == 0.0

    def test_pieces_of_another_configuration_or_version_are_not_used(self, store, output):
        store.save(KEY, ARRAYS)
        other = CheckpointStore(output, "another", resume=True)
        assert other.load(KEY) is None
        assert other.pieces() == []
        other.save(KEY, {"x": np.ones(1)})
        assert store.load(KEY).keys() == ARRAYS.keys()
        assert CheckpointStore(output, "fingerprint").load(KEY) is None  # not asked for

    def test_files_of_the_user_stay(self, store):
        store.save(KEY, ARRAYS)
        notes = store.folder / "my-notes.txt"
        notes.write_text("precious")
        store.remove()
        assert [path.name for path in store.folder.iterdir()] == ["my-notes.txt"]

    def test_folder_that_cannot_be_made_is_one_line(self, store, output):
        output.with_name("t.h5.parts").write_text("a file of the user's")
        with pytest.raises(InputError, match=r"^output: cannot make [^\n]*$"):
            store.save(KEY, ARRAYS)


def square(number):
    return {"square": np.array(number**2)}


def squares(*numbers):
    return {f"square {n}": Task(square, (n,)) for n in numbers}


def failing(number):
    raise ZeroDivisionError(number)


class TestRun:
    def test_results_come_in_the_order_of_the_tasks(self):
        def slow(number):
            time.sleep(0.02 * (3 - number))
            return square(number)

        tasks = {f"{n}": Task(slow, (n,)) for n in range(3)}
        with ThreadPoolExecutor(3) as pool:
            loaded = TaskRunner(executor=pool).run("squares", tasks)
        assert [int(arrays["square"]) for arrays in loaded.values()] == [0, 1, 4]
        assert TaskRunner().run("nothing", {}) == {}

    def test_a_failure_keeps_the_finished_results(self, store):
        tasks = squares(2, 3) | {"bad": Task(failing, (0,))}
        with ThreadPoolExecutor(1) as pool, pytest.raises(ZeroDivisionError):
            TaskRunner(store, pool).run("squares", tasks)
        runner = TaskRunner(store)
        loaded = runner.run("squares", {k: Task(failing, (0,)) for k in squares(2, 3)})
        assert [int(arrays["square"]) for arrays in loaded.values()] == [4, 9]
        # the time of finished pieces counts
        assert runner.seconds == sum(float(arrays[SECONDS]) for arrays in loaded.values()) > 0.0

    def test_results_are_stored_unless_they_need_not_be(self, store):
        runner = TaskRunner(store)
        runner.run("squares", squares(2), stored=False)
        runner.run("squares", squares(3))
        assert [store.load(key) is None for key in squares(2, 3)] == [True, False]

    def test_results_are_reported_and_change_the_note(self, terminal, store, capsys):
        runner = TaskRunner(store, progress=True)
        seen = []

        def on_result(key, arrays):
            seen.append(key)
            runner.note = f"largest {arrays['square']}"

        runner.run("squares", squares(2), on_result)
        runner.run("squares", squares(2, 3), on_result)
        assert seen == ["square 2", "square 2", "square 3"]
        shown = capsys.readouterr().err
        assert "2/2" in shown
        assert "largest 9" in shown

    def test_worker_with_other_software_is_refused(self, monkeypatch):
        versions = iter(["rebound-tables 0.1", "rebound-tables 0.2"])
        monkeypatch.setattr("tablegen.checkpoints.software", lambda: next(versions))
        with pytest.raises(InputError, match=r"runs rebound-tables 0\.2, .*0\.1"):
            TaskRunner().run("squares", squares(2))


def test_linear_algebra_keeps_to_one_thread_while_tasks_overlap():
    """When the first task ends, the other must stay on one thread: more threads change sums."""
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
        TaskRunner(executor=pool).run("squares", {"1": Task(first, ()), "2": Task(second, ())})
    assert set(seen) == {1}


def test_stable_numbers_are_the_first_bits_of_the_digest():
    # printf 'node 1.0 2.0' | sha256sum
    assert f"{stable_number('node 1.0 2.0', 48):012x}" == "861291e38d17"
    assert max(stable_number(f"{k}", 31) for k in range(200)) < 2**31


@pytest.mark.parametrize(
    "source", ["tablegen/parallel.py", "sampler/c/src/nodes.h", "sampler/formats/normal_cubics.npy"]
)
def test_an_edit_of_a_source_is_other_software(tmp_path, monkeypatch, source):
    """Of the C draw and of the numbers that it reads, too."""
    for package in (sampler, tablegen):
        root = Path(package.__file__).parent
        shutil.copytree(root, tmp_path / root.name, ignore=shutil.ignore_patterns("*.so"))
    monkeypatch.setattr("sampler.__file__", str(tmp_path / "sampler/__init__.py"))
    monkeypatch.setattr("tablegen.checkpoints.__file__", str(tmp_path / "tablegen/checkpoints.py"))
    before = software.__wrapped__()
    assert software.__wrapped__() == before
    with (tmp_path / source).open("ab") as file:
        file.write(b"\n")
    assert software.__wrapped__() != before
