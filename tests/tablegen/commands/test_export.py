"""``tablegen export``: the image of a table, and one line for what cannot be exported."""

from pathlib import Path

import pytest
from command_line import DONE

from sampler.formats.binary import read_image
from sampler.formats.hdf5 import read_table

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
    written = read_image(output)
    assert written.content_sha256 == read_table(VECTORS / f"{name}.h5").content_sha256
    assert [path.name for path in tmp_path.iterdir()] == ["t.rbt"]


def test_an_older_image_is_replaced(run, tmp_path):
    output = tmp_path / "t.rbt"
    for name in ("plane", "full"):
        assert run("export", VECTORS / f"{name}.h5", "--output", output).status == DONE
    assert len(read_image(output).arrays.channels) == 6


def test_no_table(refused, tmp_path):
    assert "none.h5" in refused("export", "none.h5", "--output", tmp_path / "t.rbt")
    image = VECTORS / "full.rbt"
    assert "cannot be read as HDF5" in refused("export", image, "--output", tmp_path / "t.rbt")


def test_no_folder(refused, tmp_path):
    words = refused("export", VECTORS / "full.h5", "--output", tmp_path / "none" / "t.rbt")
    assert "a file in a folder that exists" in words
