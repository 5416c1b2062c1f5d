"""Binary tables: what is written is in the file, where the layout says."""

import hashlib
import math

import numpy as np
import pytest

from sampler.formats.binary_layout import ALIGNMENT, ARRAYS, HEADER_DTYPE, field_offset
from sampler.formats.image import header_of, write_binary_table

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
    unpacked = spans[..., 0] + spans[..., 1] * steps[..., 0]
    assert (np.abs(unpacked - quantiles[:2, :2]) <= 0.51 * spans[..., 1]).all()


def test_layout_of_the_file(written):
    header = np.frombuffer(written[: HEADER_DTYPE.itemsize], HEADER_DTYPE)[0]
    assert written[:8] == b"\x89RBT\r\n\x1a\n"
    assert header["file_bytes"] == len(written)
    assert all(header[f"at_{array.name}"] % ALIGNMENT == 0 for array in ARRAYS)
    at = field_offset("sha256")
    outside = written[:at] + written[at + 32 :]
    assert hashlib.sha256(outside).digest() == written[at : at + 32]
