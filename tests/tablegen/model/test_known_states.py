"""Direct simulation gives the committed states to the last bit, on every processor."""

import sys
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).resolve().parents[2] / "vectors"))
from make_direct import CONDITIONS, COUNT, FOLDER, PAIRS, lines

pytestmark = pytest.mark.processor


def words_of(line):
    *given, index, collisions = line.split()[:7]
    return given, int(index), int(collisions), line.split()[7:]


@pytest.mark.parametrize("name", PAIRS)
def test_states_have_the_bits_of_the_file(name):
    known = (FOLDER / name).read_text(encoding="ascii").splitlines()
    assert len(known) == len(CONDITIONS) * COUNT
    for found, expected in zip(lines(name), known, strict=True):
        assert words_of(found) == words_of(expected)
