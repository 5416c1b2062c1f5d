"""Binary tables: what is written is in the file, where the layout says."""

import hashlib

import numpy as np
import pytest
from binary_reader import read_binary
from synthetic_table import make_contents

from sampler.formats.binary import binary_table, write_binary_table
from sampler.formats.binary_layout import ALIGNMENT, ARRAYS, HEADER_DTYPE, field_offset

pytestmark = pytest.mark.processor


@pytest.fixture(scope="module")
def written(contents):
    return binary_table(contents)


def test_what_is_written_is_in_the_file(contents, table, tmp_path):
    path = tmp_path / "t.rbt"
    write_binary_table(path, contents)
    header, arrays = read_binary(path)
    assert bytes(header["pair"]).decode() == contents.pair
    assert header["content_sha256"].tobytes().hex() == contents.content_sha256
    assert [p.name for p in tmp_path.iterdir()] == ["t.rbt"]
    made = table.arrays._asdict()
    made |= {f"{name}_coordinate": made[name].coordinate for name in ("alpha", "speed")}
    for name, values in arrays.items():
        np.testing.assert_array_equal(values, made[name].ravel(), name)
    for name in ("n_knots", "n_components", "n_classes", "n_marginals", "stride", "variate_max"):
        assert header[name] == made[name]
    for name in ("alpha", "speed"):
        parts = ("first", "last", "origin", "scale", "offset")
        found = [header[f"{name}_{part}"] for part in parts]
        assert found == [getattr(made[name], part) for part in parts]
        assert header[f"n_{name}"] == made[name].nodes


def test_equal_tables_give_equal_bytes(contents, written):
    assert binary_table(contents) == written


def test_layout_of_the_file(written):
    header = np.frombuffer(written[: HEADER_DTYPE.itemsize], HEADER_DTYPE)[0]
    assert written[:8] == b"\x89RBT\r\n\x1a\n"
    assert header["file_bytes"] == len(written)
    assert all(header[f"at_{array.name}"] % ALIGNMENT == 0 for array in ARRAYS)
    at = field_offset("sha256")
    outside = written[:at] + written[at + 32 :]
    assert hashlib.sha256(outside).digest() == written[at : at + 32]


def test_the_longest_name(tmp_path):
    write_binary_table(tmp_path / "t.rbt", make_contents(pair="ä" * 63))
    assert bytes(read_binary(tmp_path / "t.rbt")[0]["pair"]).decode() == "ä" * 63
