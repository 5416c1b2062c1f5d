"""``sampler export`` and ``tablegen export``: a table for C, C++ and Fortran."""

from pathlib import Path

import pytest

from sampler.formats.binary_layout import field_offset

VECTORS = Path(__file__).resolve().parents[2] / "vectors"

pytestmark = pytest.mark.parametrize("program", ["sampler", "tablegen"])


@pytest.mark.processor
@pytest.mark.parametrize("name", ["full", "plane"])
def test_the_file_has_the_known_bytes_and_replaces_an_older_one(call, tmp_path, program, name):
    output = tmp_path / "t.rbt"
    output.write_bytes(b"older")
    ended = call(program, "export", VECTORS / f"{name}.h5", "--output", output)
    assert (ended.status, ended.err) == (0, "")
    assert ended.out == f"{output}: {output.stat().st_size / 1e6:.2f} MB, made-up\n"
    # the very bytes, whatever the processor
    assert output.read_bytes() == (VECTORS / f"{name}.rbt").read_bytes()
    assert [path.name for path in tmp_path.iterdir()] == ["t.rbt"]


def test_a_shipped_table_by_name(call, tmp_path, program):
    image = tmp_path / "t.rbt"
    assert call(program, "export", "corundum-steel-compact", "--output", image).status == 0
    assert image.read_bytes()[field_offset("pair") :].startswith(b"corundum-steel\0")


@pytest.mark.parametrize(
    ("table", "output", "named"),
    [
        ("quartz", "t.rbt", "table: got 'quartz'"),
        ("none.h5", "t.rbt", "table: got none.h5"),
        (VECTORS / "full.rbt", "t.rbt", "full.rbt: cannot be read as HDF5"),
        (VECTORS / "full.h5", "none/t.rbt", "'--output': got none/t.rbt"),
    ],
)
def test_bad_input_is_one_line(refuse, tmp_path, monkeypatch, program, table, output, named):
    monkeypatch.chdir(tmp_path)
    assert named in refuse(program, "export", table, "--output", output)
