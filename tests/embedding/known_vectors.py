"""Files of known-answer vectors, and programs like vectors.c that check themselves against them."""

from pathlib import Path

import toolchain

VECTORS = Path(__file__).resolve().parents[1] / "vectors"
TABLES = sorted(path.stem for path in VECTORS.glob("*.rbt"))


def check_vectors(program, tolerance, vectors=VECTORS):
    """Run a program on the vectors of every table, those of a folder."""
    for name in TABLES:
        files = VECTORS / f"{name}.rbt", vectors / f"{name}.txt"
        cases = len(files[1].read_text(encoding="ascii").splitlines())
        assert toolchain.run(program, *files, tolerance) == f"{cases} cases\n"
