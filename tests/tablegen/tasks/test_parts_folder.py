"""The folder of an unfinished run: nobody else's files are touched, and nobody else uses it."""

import errno
import multiprocessing
import os
import signal

import pytest

from sampler.errors import InputError
from sampler.files import atomic_output
from tablegen.tasks import file_lock
from tablegen.tasks.parts_folder import PartsFolder

LOCKED = r"^output: got .*t\.h5, which another run is making, allowed: [^\n]*$"


@pytest.fixture
def output(tmp_path):
    return tmp_path / "t.h5"


@pytest.fixture
def path(tmp_path):
    return tmp_path / "t.h5.parts"


def begun(output):
    folder = PartsFolder(output)
    folder.begin("f" * 64)
    folder.file("0" * 16).write_bytes(b"a piece")
    return folder


class TestForeignFiles:
    @pytest.mark.parametrize(
        "name", ["my-notes.txt", "piece-notes.npz", ".hidden", "piece-0123456789abcdef.npz/deeper"]
    )
    def test_are_refused_and_stay(self, output, path, name):
        foreign = path / name
        foreign.parent.mkdir(parents=True)
        foreign.write_text("precious")
        with pytest.raises(InputError, match=r"^output: got .*parts with \S+ in it, allowed: none"):
            PartsFolder(output)
        assert [p for p in path.rglob("*") if p.is_file()] == [foreign]
        assert foreign.read_text() == "precious"

    def test_that_come_during_the_run_stay(self, output, path):
        folder = begun(output)
        (path / "my-notes.txt").write_text("precious")
        folder.remove()
        assert [p.name for p in path.iterdir()] == ["my-notes.txt"]

    def test_behind_a_link_are_not_ours(self, output, path, tmp_path):
        (tmp_path / "mine").write_text("precious")
        path.mkdir()
        (path / "recipe.sha256").symlink_to(tmp_path / "mine")
        with pytest.raises(InputError, match=r"with recipe\.sha256 in it"):
            PartsFolder(output)
        assert (tmp_path / "mine").read_text() == "precious"


class TestOurs:
    def test_what_a_killed_process_left_goes_with_the_rest(self, output, path):
        folder = begun(output)
        # the name of a file that is being written
        with atomic_output(folder.file("1" * 16)) as temporary:
            temporary.write_bytes(b"half a piece")
            os.link(temporary, f"{temporary}.kept")
        os.rename(f"{temporary}.kept", temporary)
        folder.close()
        PartsFolder(output).remove()
        assert not path.exists()

    def test_folder_elsewhere_may_be_linked(self, output, path, tmp_path):
        (tmp_path / "scratch").mkdir()
        path.symlink_to(tmp_path / "scratch")
        begun(output).remove()
        assert list((tmp_path / "scratch").iterdir()) == []

    def test_linked_output_has_one_folder(self, tmp_path):
        (tmp_path / "real").mkdir()
        (tmp_path / "link.h5").symlink_to(tmp_path / "real" / "t.h5")
        assert PartsFolder(tmp_path / "link.h5").path == tmp_path / "real" / "t.h5.parts"

    def test_folder_that_cannot_be_made_is_refused_in_one_line(self, output, path):
        path.write_text("a file of the user's")
        with pytest.raises(InputError, match=r"^output: cannot make [^\n]*$"):
            PartsFolder(output)
        assert path.read_text() == "a file of the user's"

    def test_folder_that_cannot_be_written_is_refused(self, output, path, monkeypatch):
        begun(output).close()
        monkeypatch.setattr(os, "access", lambda where, _: where != path)
        with pytest.raises(InputError, match="allowed: a folder that can be written"):
            PartsFolder(output)


def hold(output, ready):
    """Hold the folder in another process until it is killed."""
    folder = begun(output)
    ready.set()
    signal.pause()
    folder.close()


class TestLock:
    def test_second_run_is_refused_and_the_first_goes_on(self, output, path):
        first = begun(output)
        for _ in range(2):
            with pytest.raises(InputError, match=LOCKED):
                PartsFolder(output)
        assert first.pieces == 1
        first.close()
        assert PartsFolder(output).fingerprint == "f" * 64

    def test_ends_with_a_killed_process(self, output):
        processes = multiprocessing.get_context("fork")
        ready = processes.Event()
        other = processes.Process(target=hold, args=(output, ready), daemon=True)
        other.start()
        assert ready.wait(30)
        with pytest.raises(InputError, match=LOCKED):
            PartsFolder(output)
        os.kill(other.pid, signal.SIGKILL)
        other.join()
        assert PartsFolder(output).pieces == 1

    def test_folder_that_a_run_takes_away_is_made_again(self, output, path, monkeypatch):
        """The first run ends between the second's look for the folder and its lock."""
        first, lock = begun(output), file_lock._lock
        ends = [first.remove]

        def late(file, where):
            if ends:
                ends.pop()()
            lock(file, where)

        monkeypatch.setattr(file_lock, "_lock", late)
        second = PartsFolder(output)
        second.begin("f" * 64)
        with pytest.raises(InputError, match=LOCKED):
            PartsFolder(output)
        assert [p.name for p in path.iterdir()] == ["recipe.sha256"]

    def test_file_system_without_locks_is_said_once(self, output, monkeypatch, caplog):
        def unsupported(*_):
            raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

        monkeypatch.setattr(file_lock.fcntl, "flock", unsupported)
        begun(output).remove()
        said = "is not locked (No locks available): see that no other run uses it"
        assert caplog.messages == [f"{output}.parts {said}"]
