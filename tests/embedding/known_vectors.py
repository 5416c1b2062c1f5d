"""Known-answer vectors: their files, and how Python and other programs answer them."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
import toolchain

import sampler.numba
from sampler.formats.channels import VARIABLES

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
    for line in (VECTORS / f"{name}.txt").read_text(encoding="ascii").splitlines():
        kind, *words = line.split()
        n = GIVEN[kind]
        seed, index, hit, code = map(int, words[n : n + 4])
        given, expected = (tuple(map(float.fromhex, w)) for w in (words[:n], words[n + 4 :]))
        yield Case(kind, given, (seed, index, hit), code, expected)


def answer(table, kind, given, keys):
    """Give the code of a case, and its numbers or zeros, by the functions for compiled code."""
    seed, index, hit = np.uint64(keys[0]), np.uint64(keys[1]), np.uint32(keys[2])
    how, given = {"index": index, "hit": hit, "seed": seed}, [float(x) for x in given]
    if kind in ("draw", "spin-draw"):
        out, places = (
            np.zeros(len(table.columns)),
            [VARIABLES.index(name) for name in table.columns],
        )
        how |= {"spin": tuple(given[2:])} if given[2:] else {}
        code = sampler.numba.sample(table.handle, *given[:2], **how, out=out)
    else:
        out, places = np.zeros(6), range(6)
        (half_size, *others), wall = given[6:], tuple(given[7:10])
        how |= {"roughness": others.pop(3)} if "rough" in kind else {}
        how |= {"omega": tuple(others[3:])} if others[3:] else {"fresh": not table.has_spin}
        impact = tuple(given[:3]), tuple(given[3:6]), half_size, wall
        code = sampler.numba.rebound(table.handle, *impact, **how, out=out)
    assert np.isnan(out).all() == (code < 0)
    every = np.zeros(len(VARIABLES))
    every[places] = out if code >= 0 else 0.0
    return code, every


def write_cases(path, cases):
    """Write cases as numbers, as C and Fortran read them; keys as signed integers.

    Draws, rough, spins, given*11, spin*3, seed, index, hit, code, expected*10.
    """
    lines = []
    for case in cases:
        flags = [word in case.kind for word in ("draw", "rough", "spin")]
        given = case.given[:-3] if flags[2] else case.given
        spin = case.given[-3:] if flags[2] else (0.0,) * 3
        keys = np.array(case.keys[:2], np.uint64).view(np.int64), np.int32(np.uint32(case.keys[2]))
        numbers = [*given, *[0.0] * (11 - len(given)), *spin]
        expected = [*case.expected, *[0.0] * (10 - len(case.expected))]
        row = [*map(int, flags), *numbers, *keys[0].tolist(), int(keys[1]), case.code, *expected]
        lines.append(" ".join(map(repr, row)) + "\n")
    path.write_text("".join(lines), encoding="ascii")


def check_vectors(program, folder, *tolerance, keep=lambda case: True):
    """Run a program like vectors.c on the kept cases of every table, written to a folder."""
    for name in TABLES:
        cases = list(filter(keep, read_cases(name)))
        write_cases(folder / f"{name}.txt", cases)
        files = VECTORS / f"{name}.rbt", folder / f"{name}.txt"
        assert toolchain.run(program, *files, *tolerance) == f"{len(cases)} cases\n"
