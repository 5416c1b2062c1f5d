"""Known-answer vectors: their files, and how Python and other programs answer them."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
import toolchain

import sampler

VECTORS = Path(__file__).resolve().parents[1] / "vectors"
TABLES = sorted(path.stem for path in VECTORS.glob("*.rbt"))

#: Numbers of a case before its keys, by kind.
GIVEN = {
    **{"draw": 2, "rebound": 10, "rough-rebound": 11},
    **{"spin-draw": 5, "spin-rebound": 13, "spin-rough": 14},
}


class Case(NamedTuple):
    """A line of a file: what is given, and the code and the numbers that are expected."""

    kind: str
    given: tuple[float, ...]
    keys: tuple[int, int, int]
    code: int
    expected: tuple[float, ...]


def read_cases(name):
    """Read the cases of a table."""
    for line in (VECTORS / f"{name}.txt").read_text(encoding="ascii").splitlines():
        kind, *words = line.split()
        n = GIVEN[kind]
        seed, index, hit, code = map(int, words[n : n + 4])
        given, expected = (tuple(map(float.fromhex, w)) for w in (words[:n], words[n + 4 :]))
        yield Case(kind, given, (seed, index, hit), code, expected)


def answer(table, kind, given, keys):
    """Give the code of a case, and its numbers or zeros, by the functions for compiled code."""
    keys = np.uint64(keys[0]), np.uint64(keys[1]), np.uint32(keys[2])
    given = [float(x) for x in given]
    if kind in ("draw", "spin-draw"):
        out, spin = np.zeros(10), tuple(given[2:]) or None
        return sampler.draw(table.handle, *given[:2], spin, *keys, out), out
    out, (half_size, *others) = np.zeros(6), given[6:]
    velocity, normal, wall = tuple(given[:3]), tuple(given[3:6]), tuple(others[:3])
    roughness = others.pop(3) if "rough" in kind else 0.0
    omega = tuple(others[3:]) or None
    impact = velocity, normal, half_size, wall, roughness, omega
    return sampler.rough_rebound(table.handle, *impact, *keys, out), out


def check_vectors(program, *tolerance, vectors=VECTORS):
    """Run a program like vectors.c on the vectors of every table, those of a folder."""
    for name in TABLES:
        files = VECTORS / f"{name}.rbt", vectors / f"{name}.txt"
        cases = len(files[1].read_text(encoding="ascii").splitlines())
        assert toolchain.run(program, *files, *tolerance) == f"{cases} cases\n"
