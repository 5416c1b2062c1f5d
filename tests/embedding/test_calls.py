"""The two calls with records of any kind, by strict compilers and under sanitizers."""

from pathlib import Path

import pytest
import toolchain
from known_vectors import TABLES, VECTORS

from sampler.files import find_table
from sampler.formats.hdf5 import read_table
from sampler.formats.image import write_binary_table

SOURCE = Path(__file__).resolve().with_name("fuzz_calls.c")
IMAGES = [VECTORS / f"{name}.rbt" for name in TABLES]
STRICT = ["-Wdouble-promotion", "-O1", "-DRBT_API=static"]


@pytest.mark.parametrize(
    ("compiler", "flags"),
    [("gcc", []), ("clang", []), ("g++", ["-std=c++11"]), ("clang++", ["-std=c++11"])],
)
def test_strict_compilers_have_no_warning(compiler, flags, tmp_path):
    program = toolchain.build(compiler, [SOURCE], tmp_path / "calls", [*STRICT, *flags])
    drawn, refused = map(int, toolchain.run(program, 300, *IMAGES).split())
    assert min(drawn, refused) > 1000


def test_sanitizers_find_nothing_in_20000_records(tmp_path):
    """And each row has a finite result, or NaN and the code of an error."""
    flags = ["-O0", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
    program = toolchain.build("gcc", [SOURCE], tmp_path / "calls", flags)
    spheres = tmp_path / "spheres.rbt"
    write_binary_table(spheres, read_table(find_table("kharaz-2001")))
    toolchain.run(program, 20_000 // len(IMAGES), *IMAGES, spheres)
