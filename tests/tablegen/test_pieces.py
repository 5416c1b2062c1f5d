"""Pieces of a run on disk: kept, found again, refused, remade."""

import os

import numpy as np
import pytest
from tiny_tables import PLAN, ROUGH

from sampler.errors import InputError
from tablegen.fitting.axes import first_grid
from tablegen.fitting.node import fit_node
from tablegen.fitting.resolution import resolution
from tablegen.pieces import PieceStore
from tablegen.plan import fit_nodes, node_key
from tablegen.workshop import Workshop, stable_number

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
    number = stable_number(node_key(alpha_deg, speed, resolution(ROUGH)), 48)
    return store.folder / f"piece-{number:05d}.npz"


class TestStore:
    def test_returns_what_was_saved(self, store):
        store.save(7, ARRAYS)
        found = store.load(7)
        assert found.keys() == ARRAYS.keys()
        for name, values in ARRAYS.items():
            np.testing.assert_array_equal(found[name], values)
            assert found[name].dtype == values.dtype
        assert store.load(6) is None

    def test_lies_beside_the_output(self, store, output):
        store.save(0, ARRAYS)
        assert store.folder == output.with_name("t.h5.parts")
        assert sorted(p.name for p in store.folder.iterdir()) == [
            "piece-00000.npz",
            "recipe.sha256",
        ]
        assert not output.exists()

    def test_resume_keeps_pieces_and_a_fresh_start_does_not(self, store, output):
        store.save(0, ARRAYS)
        assert PieceStore(output, "recipe", resume=True).load(0) is not None
        assert PieceStore(output, "recipe", resume=False).load(0) is None

    def test_resume_without_an_earlier_run_starts(self, output):
        store = PieceStore(output, "recipe", resume=True)
        store.save(0, ARRAYS)
        assert PieceStore(output, "recipe", resume=True).load(0) is not None

    def test_pieces_of_another_recipe_are_refused_in_one_line(self, store, output):
        store.save(0, ARRAYS)
        with pytest.raises(InputError) as caught:
            PieceStore(output, "another recipe", resume=True)
        line = str(caught.value)
        assert "\n" not in line
        assert line.startswith(f"resume: got {store.folder}, ")
        assert "allowed: " in line
        # ... and left alone.
        assert store.load(0) is not None

    def test_folder_of_unknown_origin_is_refused(self, store, output):
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
        store.save(0, ARRAYS)
        store.discard()
        assert list(output.parent.iterdir()) == []

    def test_failed_save_leaves_no_piece(self, store, monkeypatch):
        def full(file, **arrays):
            file.write(b"half of it")
            raise OSError(28, os.strerror(28))

        monkeypatch.setattr("tablegen.pieces._savez", full)
        with pytest.raises(InputError, match="No space left"):
            store.save(0, ARRAYS)
        assert [p.name for p in store.folder.iterdir()] == ["recipe.sha256"]


class TestDamage:
    @pytest.fixture
    def piece(self, store):
        store.save(0, ARRAYS)
        return store.folder / "piece-00000.npz"

    def test_cut_short_anywhere(self, store, piece):
        whole = piece.read_bytes()
        for length in range(len(whole)):
            piece.write_bytes(whole[:length])
            assert store.load(0) is None, length
        piece.write_bytes(whole)
        assert store.load(0) is not None

    def test_changed_values(self, store, piece):
        """Any byte of an array, or of the header that gives its shape."""
        whole = piece.read_bytes()
        start, stop = whole.index(b"\x93NUMPY"), whole.index(b"PK", 4)
        for k in range(start, stop):
            piece.write_bytes(whole[:k] + bytes([whole[k] ^ 0x01]) + whole[k + 1 :])
            assert store.load(0) is None, k

    def test_header_that_asks_for_half_of_a_large_array(self, store, piece):
        """Numpy reads no further than the shape says, and so not to the checksum at the end."""
        store.save(0, {"quantiles": np.ones((64, 512), dtype=np.float32)})
        whole = piece.read_bytes()
        assert whole.count(b"(64, 512)") == 1
        piece.write_bytes(whole.replace(b"(64, 512)", b"(32, 512)"))
        assert store.load(0) is None

    def test_another_file(self, store, piece):
        piece.write_bytes(b"not an archive at all")
        assert store.load(0) is None


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

    def test_damaged_node_is_remade_and_kept_again(self, store, fitted):
        fit_all(store)
        piece = piece_of(store, 35.0, 300.0)
        whole = piece.read_bytes()
        piece.write_bytes(whole[: len(whole) // 2])
        fitted.clear()
        fit_all(store)
        assert fitted == [(35.0, 300.0)]
        with np.load(piece) as again:
            expected = fit_node(ROUGH, 35.0, 300.0).quantiles
            np.testing.assert_array_equal(again["quantiles"], expected)
