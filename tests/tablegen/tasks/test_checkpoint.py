"""Checkpoints of a run: written, found again, refused, and recognised where they are damaged."""

import errno
import os

import numpy as np
import pytest

from sampler.errors import InputError
from tablegen.tasks.checkpoint import CheckpointStore

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
    with CheckpointStore(output, "fingerprint") as store:
        yield store


@pytest.fixture
def left(output):
    """Folder with one checkpoint of an interrupted run."""
    with CheckpointStore(output, "fingerprint") as store:
        store.save(KEY, ARRAYS)
    return store.folder


def resumed(output):
    return CheckpointStore(output, "fingerprint", resume=True)


class TestStore:
    def test_returns_what_was_saved(self, store):
        store.save(KEY, ARRAYS)
        found = store.load(KEY)
        assert found.keys() == ARRAYS.keys()
        for name, values in ARRAYS.items():
            np.testing.assert_array_equal(found[name], values)
            assert found[name].dtype == values.dtype
        assert store.load("another key") is None
        # for a look into an unfinished run; nothing here depends on it
        with np.load(store.path(KEY)) as file:
            np.testing.assert_array_equal(file["quantiles"], ARRAYS["quantiles"])

    def test_lies_next_to_the_output_until_it_is_removed(self, store, output):
        store.save(KEY, ARRAYS)
        assert store.folder == output.with_name("t.h5.parts")
        names = sorted(path.name for path in store.folder.iterdir())
        assert names == [store.path(KEY).name, "recipe.sha256"]
        store.remove()
        assert list(output.parent.iterdir()) == []

    def test_leaves_nothing_without_checkpoints(self, output):
        with CheckpointStore(output, "fingerprint") as store:
            assert store.folder.is_dir()
        assert list(output.parent.iterdir()) == []

    @pytest.mark.parametrize("empty_folder", [False, True])
    def test_resume_without_checkpoints_starts(self, output, empty_folder):
        """A full disk leaves an empty folder of a run that could not begin."""
        if empty_folder:
            output.with_name("t.h5.parts").mkdir()
        with resumed(output) as store:
            store.save(KEY, ARRAYS)
        with resumed(output) as store:
            assert store.load(KEY) is not None

    def test_failed_save_leaves_no_checkpoint_and_the_others(self, store, monkeypatch):
        store.save("earlier", ARRAYS)

        def full(path, data):
            with open(path, "wb") as file:
                file.write(data[:10])
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

        monkeypatch.setattr("pathlib.Path.write_bytes", full)
        with pytest.raises(InputError, match=r"No space left.* kept for --resume"):
            store.save(KEY, ARRAYS)
        assert store.load(KEY) is None
        assert store.load("earlier") is not None
        assert len(list(store.folder.iterdir())) == 2


class TestEarlierCheckpoints:
    """What an interrupted run left is used, removed or refused, as the user says."""

    def test_are_used_to_resume(self, left, output):
        with resumed(output) as store:
            assert store.load(KEY) is not None
        assert left.is_dir()

    def test_are_removed_if_asked(self, left, output):
        with CheckpointStore(output, "another", discard=True) as store:
            assert store.load(KEY) is None
            store.save(KEY, ARRAYS)
        with CheckpointStore(output, "another", resume=True) as store:
            assert store.load(KEY) is not None

    @pytest.mark.parametrize(
        ("fingerprint", "flags", "said"),
        [
            (
                "fingerprint",
                {},
                "with 1 piece of an unfinished run, "
                "allowed: --resume, which uses them, or --discard, which removes them",
            ),
            (
                "another",
                {},
                "with 1 piece of an unfinished run, made from another configuration or version, "
                "allowed: another output, or --discard, which removes them",
            ),
            (
                "another",
                {"resume": True},
                "with 1 piece of an unfinished run, made from another configuration or version, "
                "allowed: another output, or --discard, which removes them",
            ),
        ],
    )
    def test_are_refused_otherwise_and_stay(self, left, output, fingerprint, flags, said):
        before = {path: path.stat().st_mtime_ns for path in output.parent.rglob("*")}
        with pytest.raises(InputError) as caught:
            CheckpointStore(output, fingerprint, **flags)
        assert str(caught.value) == f"output: got {left} {said}"
        assert {path: path.stat().st_mtime_ns for path in output.parent.rglob("*")} == before
        with resumed(output) as store:
            assert store.load(KEY) is not None

    def test_of_unknown_origin_are_refused(self, left, output):
        (left / "recipe.sha256").unlink()
        with pytest.raises(InputError, match="made from another configuration"):
            resumed(output)

    def test_cannot_be_both_used_and_removed(self, left, output):
        with pytest.raises(InputError, match=r"^--discard: got it with --resume, allowed: one"):
            CheckpointStore(output, "fingerprint", resume=True, discard=True)


class TestDamage:
    @pytest.fixture
    def file(self, store):
        store.save(KEY, ARRAYS)
        return store.path(KEY)

    def test_cut_short_anywhere_or_any_bit(self, store, file):
        whole = file.read_bytes()
        for k in range(len(whole)):
            for damaged in (whole[:k], whole[:k] + bytes([whole[k] ^ 1 << k % 8]) + whole[k + 1 :]):
                file.write_bytes(damaged)
                assert store.load(KEY) is None, k
        file.write_bytes(whole)
        assert store.load(KEY) is not None

    def test_checkpoint_of_another_key(self, store, file):
        store.save("another key", {"quantiles": np.zeros(3)})
        store.path("another key").replace(file)
        assert store.load(KEY) is None

    def test_checkpoint_of_another_fingerprint(self, store, file, tmp_path):
        with CheckpointStore(tmp_path / "other.h5", "another") as other:
            other.save(KEY, ARRAYS)
            other.path(KEY).replace(file)
        assert store.load(KEY) is None

    def test_archive_without_a_digest_and_another_file(self, store, file):
        np.savez(file, **ARRAYS)
        assert store.load(KEY) is None
        file.write_bytes(b"not an archive at all")
        assert store.load(KEY) is None
