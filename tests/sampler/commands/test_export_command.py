"""``sampler export``: the image of a table, without the generator."""

from pathlib import Path

import pytest

from sampler.commands.main import main
from sampler.formats.binary import binary_table
from sampler.formats.binary_layout import field_offset
from sampler.formats.hdf5 import read_table
from tablegen.commands.main import main as tablegen_main

VECTORS = Path(__file__).resolve().parents[2] / "vectors"


@pytest.mark.parametrize("name", ["full", "plane"])
def test_the_image_is_that_of_the_generator(tmp_path, capsys, name):
    table, ours, theirs = VECTORS / f"{name}.h5", tmp_path / "a.rbt", tmp_path / "b.rbt"
    assert main(["export", str(table), "--output", str(ours)]) == 0
    assert capsys.readouterr().out == f"{ours}: {ours.stat().st_size / 1e6:.2f} MB, made-up\n"
    assert tablegen_main(["export", str(table), "--output", str(theirs)]) == 0
    assert ours.read_bytes() == theirs.read_bytes() == bytes(binary_table(read_table(table)))


def test_a_shipped_table_by_name(tmp_path):
    image = tmp_path / "t.rbt"
    assert main(["export", "corundum-steel-compact", "--output", str(image)]) == 0
    at = field_offset("pair")
    assert image.read_bytes()[at:].startswith(b"corundum-steel\0")


@pytest.mark.parametrize(
    ("table", "output", "message"),
    [
        ("quartz", "t.rbt", "table: got 'quartz', allowed: a name (corundum-steel, "),
        ("none.h5", "t.rbt", "table: got none.h5, allowed: a file that exists"),
        (VECTORS / "full.rbt", "t.rbt", "full.rbt: cannot be read as HDF5"),
        (
            VECTORS / "full.h5",
            "none/t.rbt",
            "argument --output: got none/t.rbt, allowed",
        ),
    ],
)
def test_bad_input_is_one_line(tmp_path, monkeypatch, capsys, table, output, message):
    monkeypatch.chdir(tmp_path)
    assert main(["export", str(table), "--output", output]) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert err.startswith("sampler: error: ")
    assert message in err
    assert list(tmp_path.iterdir()) == []
