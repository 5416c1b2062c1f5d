"""Binary tables: what is written is in the file, where the layout says."""

import hashlib
import math

import numpy as np
import pytest
from binary_reader import read_binary
from spin_tables import with_spin_law

from sampler.errors import TableError
from sampler.formats.binary_layout import ALIGNMENT, ARRAYS, HEADER_DTYPE, field_offset
from sampler.formats.image import expert_records, header_of, table_image, write_binary_table
from sampler.table import load

pytestmark = pytest.mark.processor


@pytest.fixture(scope="module")
def written(contents, tmp_path_factory):
    path = tmp_path_factory.mktemp("image") / "t.rbt"
    write_binary_table(path, contents)
    return path.read_bytes()


def test_quantiles_are_those_of_the_nodes_to_half_a_step(contents, written):
    """Steps of a cell, at its first corner, beside the quantiles of that node."""
    header = header_of(np.frombuffer(written, np.uint8))
    quantiles = contents["marginals/quantiles"]
    shape = (2, 2, *quantiles.shape[2:4])
    spans = np.frombuffer(written, "<f8", 2 * math.prod(shape), header["at_spans"])
    spans = spans.reshape(*shape, 1, 2)
    steps = np.frombuffer(written, "<u2", 4 * 65 * math.prod(shape), header["at_quantiles"])
    steps = steps.reshape(*shape, 65, 4)
    found = spans[..., 0] + spans[..., 1] * steps[..., 0]
    assert (np.abs(found - quantiles[:2, :2]) <= 0.51 * spans[..., 1]).all()


def test_a_spin_law_is_in_the_file(contents, tmp_path):
    """Of three shapes one is in nobody's population: its tree stays, and no grain leads there."""
    spinning = with_spin_law(contents, codes=(0, 3, 6))
    spinning.datasets["spin/shape_weights"][:] = 0.25, 0.0, 0.75
    write_binary_table(tmp_path / "t.rbt", spinning)
    with pytest.raises(TableError, match="binary table"):
        load(tmp_path / "t.rbt")
    header, arrays = read_binary(tmp_path / "t.rbt")
    assert (header["n_shapes"], header["n_nodes"]) == (2, spinning["spin/node_axis"].size)
    assert arrays["shape_codes"].tolist() == [0, 6]
    assert arrays["shape_shares"].tolist() == [0.25, 1.0]
    assert arrays["shape_ratios"].tolist() == [0.0, 0.0, *spinning["spin/ratio_range"][2, :, 0]]
    assert arrays["roots"].tolist() == spinning["spin/roots"][[0, 2]].tolist()
    for name, path in (("node_cut", "node_cut"), ("node_child", "node_child"), ("gates", "gate")):
        np.testing.assert_array_equal(arrays[name], spinning[f"spin/{path}"].ravel(), name)
    experts = expert_records(spinning["spin/mean"], spinning["spin/factor"])
    np.testing.assert_array_equal(arrays["experts"], experts)
    assert header["valid_speed"].tolist() == [50.0, 300.0]
    assert header["spin_speed"].tolist() == spinning["spin/speed_range"].tolist()
    assert header["aspect"].tolist() == spinning["spin/aspect"].ravel().tolist()
    assert header["spin_size"].tolist() == [0.0, 10.0]
    assert header["least_inertia"] == spinning.least_inertia
    held = spinning["spin/shape_inertia"][[0, 2]]
    assert arrays["shape_inertia"].tolist() == held.ravel().tolist()


def test_equal_tables_give_equal_bytes_but_for_the_checksum_of_a_file(contents, written):
    image, at = table_image(contents).tobytes(), field_offset("sha256")
    assert image == written[:at] + bytes(32) + written[at + 32 :]


def test_layout_of_the_file(written):
    header = np.frombuffer(written[: HEADER_DTYPE.itemsize], HEADER_DTYPE)[0]
    assert written[:8] == b"\x89RBT\r\n\x1a\n"
    assert header["file_bytes"] == len(written)
    assert all(header[f"at_{array.name}"] % ALIGNMENT == 0 for array in ARRAYS)
    at = field_offset("sha256")
    outside = written[:at] + written[at + 32 :]
    assert hashlib.sha256(outside).digest() == written[at : at + 32]
