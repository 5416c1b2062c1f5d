"""The two calls with records of any kind, by strict compilers and under sanitizers."""

from pathlib import Path

import pytest
import toolchain
from known_vectors import TABLES, VECTORS, check_vectors

from sampler.files import find_table
from sampler.formats.hdf5 import read_table
from sampler.formats.image import write_binary_table

SOURCE = Path(__file__).resolve().with_name("fuzz_calls.c")
IMAGES = [VECTORS / f"{name}.rbt" for name in TABLES]
STRICT = ["-Wdouble-promotion", "-DRBT_API=static"]


@pytest.mark.parametrize(
    ("compiler", "flags"),
    [
        ("gcc", toolchain.QUICK),  # optimised, which brings warnings of its own: `optimised`
        ("clang", ["-O0"]),
        ("g++", ["-std=c++11", *toolchain.QUICK]),
        ("clang++", ["-std=c++11", "-O0"]),
    ],
)
def test_strict_compilers_have_no_warning(compiler, flags, tmp_path):
    program = toolchain.build(compiler, [SOURCE], tmp_path / "calls", [*STRICT, *flags])
    drawn, refused = map(int, toolchain.run(program, 300, *IMAGES).split())
    assert min(drawn, refused) > 1000


def test_floating_point_traps_end_no_call(optimised, tmp_path):
    """Flow codes set traps: of divisions by zero, overflows and invalid operations."""
    sources = [SOURCE.with_name("traps.c"), optimised]
    traps = toolchain.build("gcc", sources, tmp_path / "traps", ["-O1", toolchain.LINKED])
    spheres = tmp_path / "spheres.rbt"
    write_binary_table(spheres, read_table(find_table("kharaz-2001")))
    for image in (*(VECTORS / f"{name}.rbt" for name in ("spin-works", "full")), spheres):
        assert int(toolchain.run(traps, image)) > 5000


@pytest.mark.apart
def test_sanitizers_find_nothing_in_the_vectors_and_in_20000_records(tmp_path):
    """And each row of a record has a finite result, or NaN and the code of an error."""
    flags = ["-O0", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
    library = toolchain.build_implementation(tmp_path / "library.o", flags)
    flags += [toolchain.LINKED]
    vectors = SOURCE.with_name("vectors.c")
    vectors = toolchain.build("gcc", [vectors, library], tmp_path / "vectors", flags)
    check_vectors(vectors, tmp_path, 0)
    program = toolchain.build("gcc", [SOURCE, library], tmp_path / "calls", flags)
    spheres = tmp_path / "spheres.rbt"
    write_binary_table(spheres, read_table(find_table("kharaz-2001")))
    toolchain.run(program, 20_000 // len(IMAGES), *IMAGES, spheres)
