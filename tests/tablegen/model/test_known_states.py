"""Direct simulation gives the committed states to the last bit, on every processor."""

import sys
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).resolve().parents[2] / "vectors"))
from make_direct import CONDITIONS, COUNT, FILE, lines

pytestmark = pytest.mark.processor


def words_of(line):
    *given, index, collisions = line.split()[:7]
    return given, int(index), int(collisions), line.split()[7:]


def test_states_have_the_bits_of_the_file():
    known = FILE.read_text(encoding="ascii").splitlines()
    assert len(known) == len(CONDITIONS) * COUNT
    for found, expected in zip(lines(), known, strict=True):
        assert words_of(found) == words_of(expected)


def test_the_file_has_chains_of_collisions():
    """Which would spread a difference in the last bit."""
    counts = [words_of(line)[2] for line in FILE.read_text(encoding="ascii").splitlines()]
    assert min(counts) == 1
    assert max(counts) >= 10
