"""JSON has no NaN, and one place writes it; nor do files of arrays."""

import json
import math
import re

import numpy as np
import pytest
from documents import ROOT

from sampler.files import json_text, write_arrays

#: Sources that write JSON for another purpose than a file of results: inputs of a checksum, and
#: a tree for pydantic, which says itself what is not finite.
OTHERS = {"sampler/formats/hdf5.py", "tablegen/config/field_types.py"}


def test_is_json_with_a_line_end():
    assert json_text({"a": [1, 0.5]}) == '{\n "a": [\n  1,\n  0.5\n ]\n}\n'
    assert json.loads(json_text([1], indent=None)) == [1]


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, np.float64("nan")])
def test_numbers_that_are_not_finite_are_errors(value, tmp_path):
    with pytest.raises(ValueError, match="not JSON compliant"):
        json_text({"a": [0.0, value]})
    path = tmp_path / "x.npz"
    with pytest.raises(ValueError, match=r"^state: holds a number that is not finite"):
        write_arrays(path, count=np.arange(3), state=np.array([0.0, value]), names=("u", "v"))
    assert not list(tmp_path.iterdir())


def test_nothing_else_writes_json():
    writers = re.compile(r"\bjson\.dumps?\(|from json import|\bjson\.JSONEncoder")
    found = {
        str(path.relative_to(ROOT))
        for package in ("sampler", "tablegen")
        for path in (ROOT / package).rglob("*.py")
        if writers.search(path.read_text(encoding="utf-8"))
    }
    assert found - OTHERS == {"sampler/files/json_text.py"}
