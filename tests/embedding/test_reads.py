"""A draw reads a table so many times, whatever the table's size, the condition and the keys."""

from pathlib import Path

import pytest
import small_tables
import toolchain
from sampler.formats.image import write_binary_table

import sampler

SOURCE = Path(__file__).resolve().with_name("reads.c")
#: Callbacks at every load, in code that keeps each of them.
FLAGS = ("-O1", "-fno-vectorize", "-fno-slp-vectorize", "-fsanitize-coverage=edge,trace-loads")


@pytest.fixture(scope="module")
def reads(tmp_path_factory):
    """Function from contents to least and largest number of reads, and of bytes, of a draw."""
    folder = tmp_path_factory.mktemp("reads")
    program = toolchain.build("clang", [SOURCE], folder / "reads", FLAGS)

    def counted(contents):
        write_binary_table(folder / "t.rbt", contents)
        return tuple(map(int, toolchain.run(program, folder / "t.rbt", 5000).split()))

    return counted


def test_large_and_small_tables_are_read_alike(reads):
    standard = reads(sampler.load("corundum-steel").contents)
    compact = reads(sampler.load("corundum-steel-compact").contents)
    assert standard == compact
    least, most, least_bytes, most_bytes = standard
    assert (least, least_bytes) == (most, most_bytes)
    # six channels of 16 bytes, a record and six cubics, and some for axes, alias, class and spans
    assert 6 * 16 < most_bytes < 600


def test_what_a_table_leaves_out_is_not_read(reads):
    full = reads(small_tables.full())
    plane = reads(small_tables.scene(("u", "v", "omega_z")))
    assert plane[1] < 0.6 * full[1]
    assert plane[3] < 0.6 * full[3]
