"""The Fortran module gives the states of the known-answer vectors."""

from pathlib import Path

import pytest
import toolchain

HERE = Path(__file__).resolve().parent
VECTORS = HERE.parent / "vectors"
MODULE = toolchain.INCLUDE / "rebound_sampler.f90"
IMPLEMENTATION = '#define REBOUND_SAMPLER_IMPLEMENTATION\n#include "rebound_sampler.h"\n'


@pytest.fixture(scope="module")
def build(tmp_path_factory):
    """Build a Fortran program with the module; -Wno-error=... for texts in the C library's way."""

    def runner(source, level):
        folder = tmp_path_factory.mktemp("fortran")
        (folder / "library.c").write_text(IMPLEMENTATION)
        library = folder / "library.o"
        toolchain.compile_with("gcc", [level, "-c", folder / "library.c", "-o", library])
        flags = [level, "-fcheck=all", f"-J{folder}"]
        return toolchain.build("gfortran", [MODULE, source, library], folder / "program", flags)

    return runner


@pytest.mark.parametrize("level", ["-O0", pytest.param("-O2", marks=pytest.mark.processor), "-O3"])
def test_vectors(build, level):
    program = build(HERE / "vectors.f90", level)
    for image in sorted(VECTORS.glob("*.rbt")):
        vectors = image.with_suffix(".txt")
        cases = len(vectors.read_text(encoding="ascii").splitlines())
        assert toolchain.run(program, image, vectors) == f"{cases} cases\n"


def test_a_wrong_vector_and_a_missing_table(build, tmp_path):
    program = build(HERE / "vectors.f90", "-O0")
    wrong = tmp_path / "wrong.txt"
    first = (VECTORS / "full.txt").read_text(encoding="ascii").splitlines()[0]
    wrong.write_text(first.replace(" 0 0 0 0 ", " 0 1 0 0 ") + "\n", encoding="ascii")
    assert "case 1 fails" in toolchain.run(program, VECTORS / "full.rbt", wrong, status=1)
    missing = toolchain.run(program, tmp_path / "none.rbt", wrong, status=1)
    assert missing == "file: cannot be opened, allowed: a file that exists\n"
