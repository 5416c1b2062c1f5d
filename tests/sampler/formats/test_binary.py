"""Binary tables: what is written is in the file, where the layout says."""

import hashlib

import numpy as np
import pytest
from binary_reader import read_binary
from sampler.formats.image import binary_table, table_arrays, write_binary_table
from spin_tables import with_spin_law
from synthetic_table import make_contents

from sampler.formats.binary_layout import ALIGNMENT, ARRAYS, HEADER_DTYPE, field_offset
from sampler.formats.spin_buffer import law_in

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


def test_a_spin_law_is_in_the_file(contents, tmp_path):
    """Of three shapes one is in nobody's population: its tree stays, and no grain leads there."""
    spinning = with_spin_law(contents, codes=(0, 3, 6))
    weights = np.array([0.25, 0.0, 0.75])
    spinning.datasets["spin/shape_weights"][:] = weights
    write_binary_table(tmp_path / "t.rbt", spinning)
    header, arrays = read_binary(tmp_path / "t.rbt")
    made = law_in(table_arrays(spinning))
    assert (header["n_shapes"], header["n_nodes"]) == (2, made.node_axis.size)
    assert arrays["shape_codes"].tolist() == [0, 6]
    assert arrays["shape_shares"].tolist() == [0.25, 1.0]
    assert arrays["shape_ratios"].tolist() == [0.0, 0.0, *spinning["spin/ratio_range"][2, :, 0]]
    assert arrays["roots"].tolist() == made.roots[[0, 2]].tolist()
    for name, values in arrays.items():
        own = name.removeprefix("spin_")
        if name.startswith("spin_") or name in ("node_cut", "node_child", "gates", "experts"):
            np.testing.assert_array_equal(values, getattr(made, own), name)
    assert header["valid_speed"].tolist() == [50.0, 300.0]
    assert header["spin_coordinate"].tolist() == [made.speed_scale, made.speed_exponent]
    assert header["spin_speed"].tolist() == [made.speed_first, made.speed_last]
    assert header["aspect"].tolist() == made.grains.aspect.ravel().tolist()


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
