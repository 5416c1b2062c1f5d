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
    return CheckpointStore(output, "fingerprint", resume=False)


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

    def test_lies_next_to_the_output_until_it_is_discarded(self, store, output):
        store.save(KEY, ARRAYS)
        assert store.folder == output.with_name("t.h5.parts")
        names = sorted(path.name for path in store.folder.iterdir())
        assert names == [store.path(KEY).name, "recipe.sha256"]
        store.discard()
        assert list(output.parent.iterdir()) == []

    def test_resume_keeps_checkpoints_and_a_new_start_does_not(self, store, output):
        store.save(KEY, ARRAYS)
        assert resumed(output).load(KEY) is not None
        assert CheckpointStore(output, "fingerprint", resume=False).load(KEY) is None

    @pytest.mark.parametrize("empty_folder", [False, True])
    def test_resume_without_checkpoints_starts(self, output, empty_folder):
        """A full disk leaves an empty folder of a run that could not begin."""
        if empty_folder:
            output.with_name("t.h5.parts").mkdir()
        resumed(output).save(KEY, ARRAYS)
        assert resumed(output).load(KEY) is not None

    def test_another_fingerprint_is_refused_in_one_line(self, store, output):
        store.save(KEY, ARRAYS)
        with pytest.raises(InputError, match=r"^resume: got .*t\.h5\.parts, .*allowed: [^\n]*$"):
            CheckpointStore(output, "another", resume=True)
        assert store.load(KEY) is not None
        # so is a folder of unknown origin
        (store.folder / "recipe.sha256").unlink()
        with pytest.raises(InputError, match="resume: got"):
            resumed(output)

    def test_folder_that_cannot_be_made_is_refused_in_one_line(self, output):
        output.with_name("t.h5.parts").write_text("a file of the user's")
        with pytest.raises(InputError, match=r"^output: cannot make [^\n]*$"):
            CheckpointStore(output, "fingerprint", resume=False)
        assert output.with_name("t.h5.parts").read_text() == "a file of the user's"

    def test_folder_that_cannot_be_written_is_refused(self, store, output, monkeypatch):
        monkeypatch.setattr(os, "access", lambda path, _: path != store.folder)
        with pytest.raises(InputError, match="allowed: a folder that can be written"):
            resumed(output)

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
        other = CheckpointStore(tmp_path / "other.h5", "another", resume=False)
        other.save(KEY, ARRAYS)
        other.path(KEY).replace(file)
        assert store.load(KEY) is None

    def test_archive_without_a_digest_and_another_file(self, store, file):
        np.savez(file, **ARRAYS)
        assert store.load(KEY) is None
        file.write_bytes(b"not an archive at all")
        assert store.load(KEY) is None
