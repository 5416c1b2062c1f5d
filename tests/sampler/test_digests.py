"""States and rebounds of the shipped tables: those of the first draw, in numba, in every build.

    python tests/sampler/test_digests.py > tests/data/digests.json

writes the digests again, of other tables.
"""

import hashlib
import json
import math
import shutil
import warnings
from pathlib import Path

import numpy as np
import pytest

import sampler

KNOWN = Path(__file__).resolve().parents[1] / "data" / "digests.json"
N = 100_000


def digest(*arrays):
    return hashlib.sha256(b"".join(array.tobytes() for array in arrays)).hexdigest()[:16]


def c_library():
    """Digest of values of the C library's functions that rebounds call."""
    functions = math.atan, math.sin, math.cos, math.tan, math.exp, math.log, math.erfc
    return digest(np.array([f(k / 1024) for f in functions for k in range(1, 1024)]))


def digests(name):
    """Digests of a table, by what was drawn."""
    table, rng = sampler.load(name), np.random.default_rng(20)
    alpha, speed = np.radians(rng.uniform(0.3, 90.0, N)), rng.uniform(3.0, 320.0, N)
    spin, index = rng.standard_normal((N, 3)), rng.integers(0, 2**64, N, dtype=np.uint64)
    keys = {"seed": 7, "index": index, "hit": rng.integers(0, 9, N).astype(np.uint32)}
    given, single = table.grains(3, index), np.empty((N, 6), np.float32)
    draws = {"": {}, " spin": {"spin": spin}, " spin fresh": {"spin": spin, "grain": "fresh"}}
    draws |= {" spin given": {"spin": spin, "grain": given}, " float32": {"out": single}}
    found = {f"sample{k}": table.sample(alpha, speed, **keys, **v) for k, v in draws.items()}
    found = {kind: digest(states) for kind, states in found.items()} | {"grains": digest(given)}
    v, normal = rng.standard_normal((N, 3)) * 60.0, rng.standard_normal((N, 3))
    wall = rng.standard_normal((N, 3)) * 5.0
    normal *= -np.sign(((v - wall) * normal).sum(1))[:, None]
    omega, half_size = rng.standard_normal((N, 3)) * 1e6, rng.uniform(5e-6, 5e-5, N)
    roughness, spins = rng.uniform(0.0, 0.3, N), {"omega": omega}
    bounces = {
        "": {},
        " fresh": {"grain": "fresh"},
        " spin": spins,
        " spin fresh": spins | {"grain": "fresh"},
    }
    bounces |= {" given": spins | {"grain": given}, " rough": {"roughness": roughness}}
    for kind in (" spin", " given"):
        bounces[f" rough{kind}"] = bounces[" rough"] | bounces[kind]
    for kind, more in bounces.items():
        after = table.rebound(v, normal, half_size, wall_velocity=wall, **keys, **more)
        found[f"rebound{kind}"] = digest(*after)
    return {f"{name} {kind}": value for kind, value in found.items()}


def all_digests():
    with warnings.catch_warnings(action="ignore"):
        return digests("corundum-steel") | digests("corundum-steel-compact")


@pytest.fixture(scope="module")
def found():
    return all_digests()


@pytest.mark.processor
def test_states_and_rebounds_are_those_of_the_first_draw(found):
    known = json.loads(KNOWN.read_text())
    if known.pop("C library") != c_library():
        known = {name: value for name, value in known.items() if " rebound" not in name}
    if shutil.which("gcc") is None:  # other compilers round the tilts of facets their own way
        known = {name: value for name, value in known.items() if " rough" not in name}
    assert {name: found[name] for name in known} == known
    assert len(known) in (12, 22, 28)


if __name__ == "__main__":
    print(json.dumps(all_digests() | {"C library": c_library()}, indent=1))
