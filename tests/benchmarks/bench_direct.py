"""Microseconds a rebound by direct simulation: `DirectModel`, and the object in C.

    python tests/benchmarks/bench_direct.py

Random particles of the pair hit a wall in the lab frame, at 2 to 90 degrees and 20 to 250 m/s:
first without spin, then a second wall with the spin and the inertia that the first has given them.
The same rebounds are simulated in calls of many rows, of 512, and one by one. Times are processor
time of one thread, the least of several rounds. The table in C is timed beside them.
"""

import argparse
import ctypes
import tempfile
from collections.abc import Callable
from pathlib import Path

from harness import HERE, in_turns  # isort: skip
import numpy as np
import toolchain

from sampler.files import find_table
from sampler.formats.hdf5 import read_table
from sampler.formats.image import write_binary_table
from sampler.library import Impacts, Rebounds
from tablegen.config.config import load_config
from tablegen.simulation.direct import DirectModel, silent_model
from tablegen.simulation.direct_law import DirectParts
from tablegen.simulation.exported_law import Target, direct_files

#: Half-size of the particles [m], name of the pair, and rows of a call.
HALF_SIZE, PAIR = 1e-5, "corundum-steel"
BATCHES = (16_384, 512, 1)

#: Rebounds all particles once.
Run = Callable[[], object]


def arrivals(model: DirectModel, n: int, spinning: bool) -> dict[str, np.ndarray]:
    """Impacts of n particles, on a first or on a second wall."""
    rng = np.random.default_rng(1)
    index, normal = np.arange(n, dtype=np.uint64), np.tile([0.0, 1.0, 0.0], (n, 1))

    def towards(speed: np.ndarray) -> np.ndarray:
        alpha = np.radians(rng.uniform(2.0, 90.0, n))
        return speed[:, None] * np.column_stack([np.cos(alpha), -np.sin(alpha), 0.0 * alpha])

    velocity = towards(rng.uniform(20.0, 250.0, n))
    given = {"omega": np.zeros((n, 3)), "inertia": np.zeros(n)}
    if spinning:
        after = model.rebound(velocity, normal, HALF_SIZE, seed=1, index=index, hit=0)
        velocity = towards(np.linalg.norm(after.velocity, axis=1))
        given = {"omega": after.omega, "inertia": after.inertia}
    given |= {"velocity": velocity, "normal": normal, "half_size": np.full(n, HALF_SIZE)}
    return given | {"index": index, "hit": np.full(n, spinning, np.uint32)}


def python_runs(model: DirectModel, given: dict[str, np.ndarray]) -> dict[str, Run]:
    """Rebounds by `DirectModel`, in calls of some rows."""
    n = len(given["index"])

    def in_calls(batch: int) -> Run:
        def run() -> None:
            for k in range(0, n, batch):
                part = {name: array[k : k + batch] for name, array in given.items()}
                model.rebound(**part, seed=1, threads=1)

        return run

    return {f"DirectModel, {batch} a call": in_calls(batch) for batch in BATCHES}


def c_runs(folder: Path, given: dict[str, np.ndarray]) -> dict[str, Run]:
    """Rebounds in C, from the object and from the table, in calls of some rows."""
    for name, data in direct_files(
        DirectParts.from_config(load_config(PAIR)), Target.of_this_machine()
    ).items():
        (folder / name).write_bytes(data)
    source = folder / "loops.c"
    source.write_text((HERE / "direct_loops.c").read_text())
    library = toolchain.load_library(source, ("-O2", f"-I{folder}", folder / "rebound_direct.o"))
    write_binary_table(folder / "t.rbt", read_table(find_table(PAIR)))
    impacts = Impacts(**{name: array.ctypes.data for name, array in given.items()})
    n, runs = len(given["index"]), {}
    results = {name: np.empty_like(given[name]) for name in ("velocity", "omega", "inertia")}
    after = Rebounds(**{name: array.ctypes.data for name, array in results.items()})
    for label in ("object", "table"):
        _, table = toolchain.open_code(library, folder / "t.rbt")
        if label == "object":
            assert library.use_direct(table) == 0
        for batch in BATCHES:
            words = table, n, batch, ctypes.byref(impacts), 1, ctypes.byref(after)
            function = library.rebound_in_batches
            function.argtypes = [ctypes.c_void_p, *2 * [ctypes.c_size_t], ctypes.c_void_p]
            function.argtypes += [ctypes.c_uint64, ctypes.c_void_p]
            # the arrays stay alive with the function that uses them
            run = lambda f=function, w=words, kept=(given, results): f(*w)  # noqa: E731
            runs[f"C, {label}, {batch} a call"] = run
    return runs


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--count", type=int, default=16_384)
    parser.add_argument("--rounds", type=int, default=7)
    options = parser.parse_args()
    model = silent_model(load_config(PAIR))
    for spinning in (False, True):
        given = arrivals(model, options.count, spinning)
        timed = python_runs(model, given)
        with tempfile.TemporaryDirectory() as folder:
            if toolchain.find("gcc"):
                timed |= c_runs(Path(folder), given)
            print("second wall, with spin" if spinning else "first wall, without spin")
            for name, times in in_turns(timed, options.rounds).items():
                print(f"  {name:28} {1e6 * min(times) / options.count:7.3f} us")


if __name__ == "__main__":
    main()
