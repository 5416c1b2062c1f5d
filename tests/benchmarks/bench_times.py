"""Time of a rebound, from tables and by direct simulation, in C, numba and Python.

    python tests/benchmarks/bench_times.py
    python tests/benchmarks/bench_times.py --write

prints the table of times, or writes it into sampler/EMBEDDING.md as well. Random particles hit a
wall in the lab frame, at 2 to 90 degrees and 20 to 250 m/s: fresh grains that do not spin, then
grains that meet a second wall with the spin and the inertia that the first has given them. All rows
of the table rebound the same particles, in calls of one, of 512 and of all. Times are processor
time of one thread, the least of several rounds, in which the order of the measurements changes.
C is compiled with gcc -O2; it takes a few minutes, most of them for Python one by one.
"""

import argparse
import ctypes
import math
import platform
import re
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from harness import HERE, ROOT, in_turns  # isort: skip
import numba
import numpy as np
import toolchain
from marked_parts import filled

import sampler
import sampler.numba
from sampler.files import find_table
from sampler.formats.hdf5 import read_table
from sampler.formats.image import write_binary_table
from sampler.library import Impacts, Rebounds
from tablegen.config.config import load_config
from tablegen.simulation.direct import DirectModel, model_without_warnings
from tablegen.simulation.direct_law import DirectParts
from tablegen.simulation.exported_law import Target, direct_files

PAGE = ROOT / "sampler" / "EMBEDDING.md"

#: Half-size of the particles [m], the name of the pair, and that of its compact table.
HALF_SIZE, PAIR, COMPACT = 1e-5, "corundum-steel", "corundum-steel-compact"

#: Name of direct simulation among the laws.
DIRECT = "direct simulation"

#: Particles, those that Python rebounds one by one, and rows of a batch.
COUNT, FEW, BATCH = 65_536, 1_000, 512

#: Rebounds particles once, and how many these are.
Run = tuple[Callable[[], object], int]

#: Arguments of a rebound by name, of which `omega` and `inertia` may be left out.
Particles = dict[str, np.ndarray]


def arrivals(model: DirectModel, spinning: bool) -> Particles:
    """Impacts of particles that do not spin, or of those that have met another wall."""
    rng = np.random.default_rng(1)
    index, normal = np.arange(COUNT, dtype=np.uint64), np.tile([0.0, 1.0, 0.0], (COUNT, 1))

    def towards(speed: np.ndarray) -> np.ndarray:
        alpha = np.radians(rng.uniform(2.0, 90.0, COUNT))
        return speed[:, None] * np.column_stack([np.cos(alpha), -np.sin(alpha), 0.0 * alpha])

    velocity, spin = towards(rng.uniform(20.0, 250.0, COUNT)), {}
    if spinning:
        after = model.rebound(velocity, normal, HALF_SIZE, seed=1, index=index, hit=0)
        velocity = towards(np.linalg.norm(after.velocity, axis=1))
        spin = {"omega": after.omega, "inertia": after.inertia}
    given = {"velocity": velocity, "normal": normal, "half_size": np.full(COUNT, HALF_SIZE)}
    return given | spin | {"index": index, "hit": np.full(COUNT, spinning, np.uint32)}


def python_runs(law: Any, given: Particles) -> dict[str, Run]:
    """Rebounds by a table or a `DirectModel`, in calls of some rows."""
    grain = "own" if "omega" in given else "fresh"

    def in_calls(batch: int, count: int) -> Run:
        def run() -> None:
            for k in range(0, count, batch):
                part = {name: array[k : k + batch] for name, array in given.items()}
                law.rebound(**part, seed=1, threads=1, grain=grain)

        return run, count

    sizes = ("1", 1, FEW), (f"{BATCH}", BATCH, COUNT), (f"{COUNT:,}", COUNT, COUNT)
    return {f"Python, {name} a call": in_calls(batch, count) for name, batch, count in sizes}


@numba.njit
def one_by_one(handle, velocity, normal, half_size, omega, inertia, index, hit, out):
    for k in range(len(index)):
        v, n, w = velocity[k], normal[k], omega[k]
        sampler.numba.rebound(
            handle,
            (v[0], v[1], v[2]),
            (n[0], n[1], n[2]),
            half_size[k],
            omega=(w[0], w[1], w[2]),
            inertia=inertia[k],
            index=index[k],
            hit=hit[k],
            seed=1,
            out=out,
        )


@numba.njit
def fresh_one_by_one(handle, velocity, normal, half_size, index, hit, out):
    for k in range(len(index)):
        v, n = velocity[k], normal[k]
        sampler.numba.rebound(
            handle,
            (v[0], v[1], v[2]),
            (n[0], n[1], n[2]),
            half_size[k],
            index=index[k],
            hit=hit[k],
            fresh=True,
            seed=1,
            out=out,
        )


def numba_run(law: Any, given: Particles) -> Run:
    """Rebounds one by one, from a loop that numba has compiled."""
    function = one_by_one if "omega" in given else fresh_one_by_one
    return lambda: function(law.handle, *given.values(), np.empty(7)), COUNT


class CLoops:
    """Loops in C over the tables and direct simulation, compiled in a folder."""

    def __init__(self, folder: Path) -> None:
        parts = DirectParts.from_config(load_config(PAIR))
        for name, data in direct_files(parts, Target.of_this_machine()).items():
            (folder / name).write_bytes(data)
        source = folder / "loops.c"
        source.write_text((HERE / "rebound_loops.c").read_text())
        # with versions for wide vectors, which tests leave out
        flags = "-O2", "-URBT_NO_CLONES", f"-I{folder}", folder / "rebound_direct.o"
        self.library = toolchain.load_library(source, flags)
        self.rebound = self.library.rebound_in_batches
        self.rebound.argtypes = [ctypes.c_void_p, *2 * [ctypes.c_size_t], ctypes.c_void_p]
        self.rebound.argtypes += [ctypes.c_uint64, ctypes.c_void_p]
        self.tables = {}
        for name, table in ((PAIR, PAIR), (COMPACT, COMPACT), (DIRECT, PAIR)):
            path = folder / f"{name}.rbt"
            write_binary_table(path, read_table(find_table(table)))
            _, self.tables[name] = toolchain.open_code(self.library, path)
        assert self.library.use_direct(self.tables[DIRECT]) == 0

    def runs(self, law: str, given: Particles) -> dict[str, Run]:
        """Rebounds in calls of some rows."""
        addresses = {name: array.ctypes.data for name, array in given.items()}
        impacts = Impacts(**addresses, fresh="omega" not in given)
        results = {"velocity": np.empty((COUNT, 3)), "omega": np.empty((COUNT, 3))}
        results["inertia"] = np.empty(COUNT)
        after = Rebounds(**{name: array.ctypes.data for name, array in results.items()})

        def in_calls(batch: int) -> Run:
            def run(kept: tuple = (given, results)) -> None:  # arrays that the addresses are of
                code = self.rebound(
                    self.tables[law], COUNT, batch, ctypes.byref(impacts), 1, ctypes.byref(after)
                )
                assert code >= 0

            return run, COUNT

        sizes = ("1", 1), (f"{BATCH}", BATCH), (f"{COUNT:,}", COUNT)
        return {f"C, {name} a call": in_calls(batch) for name, batch in sizes}

    def stack(self, law: str, given: Particles, n: int) -> int:
        """Bytes of the stack that a call of n rows needs."""
        impacts = Impacts(**{name: array.ctypes.data for name, array in given.items()})
        velocity = np.empty((n, 3))
        after = Rebounds(velocity=velocity.ctypes.data)
        function = self.library.stack_of_a_call
        function.restype = ctypes.c_size_t
        function.argtypes = [ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p, ctypes.c_void_p]
        size = function(self.tables[law], n, ctypes.byref(impacts), ctypes.byref(after))
        assert size > 0
        return size


def processor() -> str:
    """Name the processor, and its widest vectors."""
    try:
        text = Path("/proc/cpuinfo").read_text()
    except OSError:
        return platform.processor() or platform.machine()
    name = re.search(r"^model name\s*: (.*)$", text, re.M)
    wide = [vectors for vectors in ("avx512f", "avx2") if re.search(rf"\b{vectors}\b", text)]
    with_vectors = f" with {wide[0].upper()}" if wide else ""
    return (name[1] if name else platform.machine()) + with_vectors


def two_digits(number: float) -> str:
    """Write a positive number in two digits, such as 130, 2.0 or 0.24."""
    power = math.floor(math.log10(float(f"{number:.1e}")))
    return f"{round(number, 1 - power):.{max(0, 1 - power)}f}"


def times_text(measured: dict[tuple[str, str], dict[str, float]]) -> str:
    """Write the table in Markdown: a row for each law, a column for each program."""
    columns = list(next(iter(measured.values())))
    head = f"| µs a rebound, one thread of an {processor()} | {' | '.join(columns)} |"
    lines = [head, "|---" * (len(columns) + 1) + "|"]
    for (hit, law), times in measured.items():
        cells = (two_digits(times[column]) for column in columns)
        lines.append(f"| {hit}, {law} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def stack_text(loops: CLoops, given: Particles) -> str:
    """Say what a call in C needs of the stack."""
    sizes = [
        f"{loops.stack(law, given, 1) / 1e3:.0f} and {loops.stack(law, given, BATCH) / 1e3:.0f} kB"
        for law in (PAIR, DIRECT)
    ]
    text = f"A call in C with one row and with {BATCH} needs {sizes[0]} of stack with a table"
    return f"{text}, {sizes[1]} with direct simulation.\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--rounds", type=int, default=11)
    parser.add_argument("--write", action="store_true", help="write the table into EMBEDDING.md")
    options = parser.parse_args()
    model = model_without_warnings(load_config(PAIR))
    laws = {PAIR: sampler.load(PAIR), COMPACT: sampler.load(COMPACT), DIRECT: model}
    measured = {}
    with tempfile.TemporaryDirectory() as folder:
        loops = CLoops(Path(folder))
        for hit, spinning in (("fresh grain, no spin", False), ("later hit, spinning", True)):
            given = arrivals(model, spinning)
            runs = {}
            for name, law in laws.items():
                columns = loops.runs(name, given) | {"numba, 1 a call": numba_run(law, given)}
                columns |= python_runs(law, given)
                runs |= {(name, column): run for column, run in columns.items()}
            times = in_turns({key: run for key, (run, _) in runs.items()}, options.rounds)
            for name in laws:
                measured[hit, f"`{name}`" if name != DIRECT else name] = {
                    column: 1e6 * min(times[of, column]) / runs[of, column][1]
                    for of, column in runs
                    if of == name
                }
        stack = stack_text(loops, given)
    text = f"{times_text(measured)}\n{stack}"
    if options.write:
        page = PAGE.read_text(encoding="utf-8")
        PAGE.write_text(filled(page, PAGE.name, {"times": lambda: text}), encoding="utf-8")
    print(text, end="")


if __name__ == "__main__":
    main()
