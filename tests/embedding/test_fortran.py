"""The Fortran module gives the states of the known-answer vectors."""

from pathlib import Path

import pytest
import toolchain
from spin_vectors import write_spin_vectors

HERE = Path(__file__).resolve().parent
VECTORS = HERE.parent / "vectors"


@pytest.mark.parametrize("level", ["-O0", pytest.param("-O2", marks=pytest.mark.processor), "-O3"])
def test_vectors(level, tmp_path):
    program = toolchain.build_fortran([HERE / "vectors.f90"], tmp_path, [level, "-fcheck=all"])
    for image in sorted(VECTORS.glob("*.rbt")):
        vectors = image.with_suffix(".txt")
        cases = len(vectors.read_text(encoding="ascii").splitlines())
        assert toolchain.run(program, image, vectors) == f"{cases} cases\n"


@pytest.mark.processor
def test_particles_that_arrive_spinning(tmp_path):
    program = toolchain.build_fortran([HERE / "vectors.f90"], tmp_path, ["-O2", "-fcheck=all"])
    image, vectors, cases = write_spin_vectors(tmp_path)
    assert toolchain.run(program, image, vectors) == f"{cases} cases\n"
    lines = vectors.read_text(encoding="ascii").splitlines()
    wrong = tmp_path / "wrong.txt"
    wrong.write_text(lines[10].replace(" 0x1.3333333333333p-2 ", " 0x1.4p-2 ") + "\n")
    assert lines[10] not in wrong.read_text()
    assert "case 1 fails" in toolchain.run(program, image, wrong, status=1)


def test_a_wrong_vector_and_a_missing_table(tmp_path):
    program = toolchain.build_fortran([HERE / "vectors.f90"], tmp_path)
    wrong = tmp_path / "wrong.txt"
    first = (VECTORS / "full.txt").read_text(encoding="ascii").splitlines()[0]
    wrong.write_text(first.replace(" 0 0 0 0 ", " 0 1 0 0 ") + "\n", encoding="ascii")
    assert "case 1 fails" in toolchain.run(program, VECTORS / "full.rbt", wrong, status=1)
    missing = toolchain.run(program, tmp_path / "none.rbt", wrong, status=1)
    assert (
        missing == "file: cannot be opened, allowed: a regular file that exists and may be read\n"
    )
