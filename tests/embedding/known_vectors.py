"""Known-answer vectors: their files, and how Python and other programs answer them."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
import toolchain

import sampler.numba
from sampler.errors import NOT_APPROACHING
from sampler.formats.channels import VARIABLES

VECTORS = Path(__file__).resolve().parents[1] / "vectors"
TABLES = sorted(path.stem for path in VECTORS.glob("*.rbt"))

#: Numbers of a case before its keys, by kind.
GIVEN = {
    **{"draw": 2, "rebound": 10, "rough-rebound": 11},
    **{"spin-draw": 6, "spin-rebound": 14, "spin-rough": 15},
}


class Case(NamedTuple):
    """A line of a file: what is given, and the code and the numbers that are expected.

    With a spin the last number of either is the inertia about it.
    """

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
    """Give the code of a case, its numbers, the inertia after a spin; or zeros after an error."""
    seed, index, hit = np.uint64(keys[0]), np.uint64(keys[1]), np.uint32(keys[2])
    keywords, given = {"index": index, "hit": hit, "seed": seed}, [float(x) for x in given]
    spins = kind.startswith("spin")
    keywords |= {"inertia": given.pop()} if spins else {}
    spin, given = (given[-3:], given[:-3]) if spins else ([], given)
    every, after = np.zeros(len(VARIABLES)), np.zeros(1)
    if kind in ("draw", "spin-draw"):
        out = np.zeros(len(table.columns))
        places = [VARIABLES.index(name) for name in table.columns]
        keywords |= {"spin": tuple(spin), "inertia_after": after} if spins else {}
        code = sampler.numba.sample(table.handle, *given, **keywords, out=out)
        out, kept = np.append(out, after), None
    else:
        out, places = np.zeros(7), range(6)
        keywords |= {"roughness": given.pop()} if "rough" in kind else {}
        keywords |= {"omega": tuple(spin)} if spins else {"fresh": not table.has_spin}
        impact = tuple(given[:3]), tuple(given[3:6]), given[6], tuple(given[7:])
        code = sampler.numba.rebound(table.handle, *impact, **keywords, out=out)
        kept = [*given[:3], *(spin or [0.0] * 3), keywords.get("inertia", 0.0)]
    if code == NOT_APPROACHING and kept:
        np.testing.assert_array_equal(out, kept)
    else:
        assert np.isnan(out[: -1 if not spins else None]).all() == (code < 0)
    if code < 0:
        return code, every, 0.0
    every[places] = out[:-1]
    return code, every, out[-1] if spins else 0.0


def write_cases(path, cases):
    """Write cases as numbers, as C and Fortran read them; keys as signed integers.

    Draws, rough, spins, given*11, spin*3, inertia, seed, index, hit, code, expected*10, inertia.
    """
    lines = []
    for case in cases:
        flags = [word in case.kind for word in ("draw", "rough", "spin")]
        given, spin, after = [*case.given], [0.0] * 4, 0.0
        expected = [*case.expected]
        if flags[2]:
            given, spin, after = given[:-4], given[-4:], expected.pop()
        keys = np.array(case.keys[:2], np.uint64).view(np.int64), np.int32(np.uint32(case.keys[2]))
        numbers = [*given, *[0.0] * (11 - len(given)), *spin]
        expected += [0.0] * (10 - len(expected))
        row = [*map(int, flags), *numbers, *keys[0].tolist(), int(keys[1]), case.code]
        lines.append(" ".join(map(repr, [*row, *expected, after])) + "\n")
    path.write_text("".join(lines), encoding="ascii")


def check_vectors(program, folder, *tolerance, keep=lambda case: True):
    """Run a program like vectors.c on the kept cases of every table, written to a folder."""
    for name in TABLES:
        cases = list(filter(keep, read_cases(name)))
        write_cases(folder / f"{name}.txt", cases)
        files = VECTORS / f"{name}.rbt", folder / f"{name}.txt"
        assert toolchain.run(program, *files, *tolerance) == f"{len(cases)} cases\n"
