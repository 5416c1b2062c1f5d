"""``tablegen export``: the image of a table, and one line for what cannot be exported."""

from pathlib import Path

import pytest
from command_line import DONE

VECTORS = Path(__file__).resolve().parents[2] / "vectors"


@pytest.mark.processor
@pytest.mark.parametrize("name", ["full", "plane"])
def test_an_image_of_the_table(run, tmp_path, name):
    output = tmp_path / "t.rbt"
    done = run("export", VECTORS / f"{name}.h5", "--output", output)
    assert (done.status, done.err) == (DONE, "")
    assert done.out == f"{output}: {output.stat().st_size / 1e6:.2f} MB, made-up\n"
    # the very bytes, whatever the processor
    assert output.read_bytes() == (VECTORS / f"{name}.rbt").read_bytes()
    assert [path.name for path in tmp_path.iterdir()] == ["t.rbt"]


def test_an_older_image_is_replaced(run, tmp_path):
    output = tmp_path / "t.rbt"
    for name in ("plane", "full"):
        assert run("export", VECTORS / f"{name}.h5", "--output", output).status == DONE
    assert output.read_bytes() == (VECTORS / "full.rbt").read_bytes()


def test_no_table(refused, tmp_path):
    assert "none.h5" in refused("export", "none.h5", "--output", tmp_path / "t.rbt")
    image = VECTORS / "full.rbt"
    assert "cannot be read as HDF5" in refused("export", image, "--output", tmp_path / "t.rbt")


def test_no_folder(refused, tmp_path):
    words = refused("export", VECTORS / "full.h5", "--output", tmp_path / "none" / "t.rbt")
    assert "a file in a folder that exists" in words
