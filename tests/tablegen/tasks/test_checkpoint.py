"""Pieces of a run on disk: kept, found again, refused, remade."""

import errno
import os

import numpy as np
import pytest
from tiny_tables import PLAN, ROUGH

from sampler.errors import InputError
from tablegen.fitting.node import fit_node
from tablegen.fitting.resolution import resolution
from tablegen.refinement.axes import first_grid
from tablegen.refinement.refine import fit_nodes, node_key
from tablegen.tasks.checkpoint import PieceStore
from tablegen.tasks.runner import Workshop

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
    return PieceStore(output, "recipe", resume=False)


@pytest.fixture
def fitted(monkeypatch):
    """Conditions of the nodes that are really fitted."""
    conditions = []

    def counting(config, alpha_deg, speed, *rest):
        conditions.append((alpha_deg, speed))
        return fit_node(config, alpha_deg, speed, *rest)

    monkeypatch.setattr(PLAN, "fit_node", counting)
    return conditions


def fit_all(store):
    return fit_nodes(ROUGH, first_grid(ROUGH), Workshop(store))


def piece_of(store, alpha_deg, speed):
    """File of the piece that is a node."""
    return store.path(node_key(alpha_deg, speed, resolution(ROUGH)))


class TestStore:
    def test_returns_what_was_saved(self, store):
        store.save(KEY, ARRAYS)
        found = store.load(KEY)
        assert found.keys() == ARRAYS.keys()
        for name, values in ARRAYS.items():
            np.testing.assert_array_equal(found[name], values)
            assert found[name].dtype == values.dtype
        assert store.load("another key") is None

    def test_lies_beside_the_output(self, store, output):
        store.save(KEY, ARRAYS)
        assert store.folder == output.with_name("t.h5.parts")
        assert sorted(p.name for p in store.folder.iterdir()) == [
            store.path(KEY).name,
            "recipe.sha256",
        ]
        assert not output.exists()

    def test_resume_keeps_pieces_and_a_fresh_start_does_not(self, store, output):
        store.save(KEY, ARRAYS)
        assert PieceStore(output, "recipe", resume=True).load(KEY) is not None
        assert PieceStore(output, "recipe", resume=False).load(KEY) is None

    def test_resume_without_an_earlier_run_starts(self, output):
        store = PieceStore(output, "recipe", resume=True)
        store.save(KEY, ARRAYS)
        assert PieceStore(output, "recipe", resume=True).load(KEY) is not None

    def test_pieces_of_another_recipe_are_refused_in_one_line(self, store, output):
        store.save(KEY, ARRAYS)
        with pytest.raises(InputError) as caught:
            PieceStore(output, "another recipe", resume=True)
        line = str(caught.value)
        assert "\n" not in line
        assert line.startswith(f"resume: got {store.folder}, ")
        assert "allowed: " in line
        # ... and left alone.
        assert store.load(KEY) is not None

    def test_folder_of_unknown_origin_is_refused(self, store, output):
        store.save(KEY, ARRAYS)
        (store.folder / "recipe.sha256").unlink()
        with pytest.raises(InputError, match="resume: got"):
            PieceStore(output, "recipe", resume=True)

    def test_folder_that_cannot_be_made_is_refused_in_one_line(self, output):
        output.with_name("t.h5.parts").write_text("a file of the user's")
        with pytest.raises(InputError) as caught:
            PieceStore(output, "recipe", resume=False)
        assert str(caught.value).startswith("output: cannot make ")
        assert "\n" not in str(caught.value)
        assert output.with_name("t.h5.parts").read_text() == "a file of the user's"

    def test_discard_removes_everything(self, store, output):
        store.save(KEY, ARRAYS)
        store.discard()
        assert list(output.parent.iterdir()) == []

    def test_failed_save_leaves_no_piece_and_the_others(self, store, monkeypatch):
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

    def test_folder_without_anything_is_a_start(self, output):
        """What a full disk leaves of a run that could not begin."""
        output.with_name("t.h5.parts").mkdir()
        store = PieceStore(output, "recipe", resume=True)
        store.save(KEY, ARRAYS)
        assert PieceStore(output, "recipe", resume=True).load(KEY) is not None

    def test_folder_that_cannot_be_written_is_refused_at_the_start(
        self, store, output, monkeypatch
    ):
        monkeypatch.setattr(os, "access", lambda path, _: path != store.folder)
        with pytest.raises(InputError, match="allowed: a folder that can be written"):
            PieceStore(output, "recipe", resume=True)


class TestDamage:
    @pytest.fixture
    def piece(self, store):
        store.save(KEY, ARRAYS)
        return store.path(KEY)

    def test_cut_short_anywhere(self, store, piece):
        whole = piece.read_bytes()
        for length in range(len(whole)):
            piece.write_bytes(whole[:length])
            assert store.load(KEY) is None, length
        piece.write_bytes(whole)
        assert store.load(KEY) is not None

    def test_any_bit(self, store, piece):
        whole = piece.read_bytes()
        for k in range(len(whole)):
            piece.write_bytes(whole[:k] + bytes([whole[k] ^ 1 << k % 8]) + whole[k + 1 :])
            assert store.load(KEY) is None, k

    def test_piece_of_another_key(self, store, piece):
        store.save("another key", {"quantiles": np.zeros(3)})
        store.path("another key").replace(piece)
        assert store.load(KEY) is None

    def test_piece_of_another_recipe(self, store, piece, tmp_path):
        other = PieceStore(tmp_path / "other.h5", "another recipe", resume=False)
        other.save(KEY, ARRAYS)
        other.path(KEY).replace(piece)
        assert store.load(KEY) is None

    def test_archive_without_a_seal(self, store, piece):
        np.savez(piece, **ARRAYS)
        assert store.load(KEY) is None

    def test_numpy_reads_a_piece_as_it_is(self, piece):
        """For a look into an unfinished run; nothing here depends on it."""
        with np.load(piece) as file:
            np.testing.assert_array_equal(file["quantiles"], ARRAYS["quantiles"])

    def test_another_file(self, store, piece):
        piece.write_bytes(b"not an archive at all")
        assert store.load(KEY) is None


class TestResumedNodes:
    def test_only_missing_nodes_are_fitted(self, store, fitted):
        fresh = fit_all(store)
        assert sorted(fitted) == [(35.0, 60.0), (35.0, 300.0), (45.0, 60.0), (45.0, 300.0)]
        piece_of(store, 45.0, 60.0).unlink()
        fitted.clear()
        resumed = fit_all(store)
        assert fitted == [(45.0, 60.0)]
        for a, b in zip(fresh, resumed, strict=True):
            for x, y in zip(a, b, strict=True):
                np.testing.assert_array_equal(x, y)
                assert x.dtype == y.dtype

    @pytest.mark.parametrize("spoil", ["truncate", "flip", "foreign"])
    def test_bad_node_is_remade_and_kept_again(self, store, fitted, spoil):
        fit_all(store)
        piece = piece_of(store, 35.0, 300.0)
        whole = piece.read_bytes()
        half = len(whole) // 2
        piece.write_bytes(
            {
                "truncate": whole[:half],
                "flip": whole[:half] + bytes([whole[half] ^ 4]) + whole[half + 1 :],
                "foreign": piece_of(store, 45.0, 300.0).read_bytes(),
            }[spoil]
        )
        fitted.clear()
        fit_all(store)
        assert fitted == [(35.0, 300.0)]
        with np.load(piece) as again:
            expected = fit_node(ROUGH, 35.0, 300.0).quantiles
            np.testing.assert_array_equal(again["quantiles"], expected)
