"""Draws a second on a GPU, beside kernels that gather as many bytes from as many places.

    python tests/benchmarks/bench_device.py
    python tests/benchmarks/bench_device.py --table corundum-steel --count 10000000 --dtype float32

Needs CuPy and a GPU, and ends with one line where they are missing. All draws are at random angles
and speeds, at random spins too where the table has a spin law; rebounds are of the same impacts.
The arrays live on the device. A gather reads what a draw reads of the table, in runs of as many
bytes at random places of the same arrays, and writes what a draw writes: what the memory system
allows. Times are of whole calls, which end when the device has; all take turns in every round, and
a share is the median of those of a round. The tests run all this on the host; it was never run on a
GPU.
"""

import argparse
import statistics
import sys
import time
from collections.abc import Callable
from typing import Any

import checkout  # noqa: F401  (before the imports that it makes possible)
import numpy as np

import sampler
from sampler.device.program import REALS, cupy_with_gpu
from sampler.errors import InputError
from sampler.formats.binary_layout import HEADER_DTYPE
from sampler.formats.bounds import (
    EXPERT_STRIDE,
    GROUP_SIZE,
    N_FEATURES,
    N_GROUPS,
    N_INPUTS,
    N_OUTCOMES,
)
from sampler.formats.image import binary_table

PIECE = 16  # bytes of one read

#: Runs of pieces, one behind the other, at a random place each.
GATHER = """
struct alignas(16) piece { unsigned long long low, high; };

extern "C" __global__ void gather(const piece *memory, unsigned long long pieces,
                                  unsigned long long n, const int *runs, int n_runs, int numbers,
                                  RBT_REAL *out)
{
    for (unsigned long long k = (unsigned long long)blockIdx.x * blockDim.x + threadIdx.x; k < n;
         k += (unsigned long long)gridDim.x * blockDim.x) {
        unsigned long long state = k * 0x9e3779b97f4a7c15ull + 1, sum = 0;
        for (int run = 0; run < n_runs; run++) {
            state = state * 6364136223846793005ull + 1442695040888963407ull;
            const unsigned long long first = (state >> 32) * (pieces - (unsigned)runs[run]) >> 32;
            for (unsigned j = 0; j < (unsigned)runs[run]; j++)
                sum += memory[first + j].low ^ memory[first + j].high;
        }
        for (unsigned c = 0; c < (unsigned)numbers; c++)
            out[(unsigned)numbers * k + c] = (RBT_REAL)(sum >> c);
    }
}
"""

Call = Callable[[], Any]


def pieces_of(numbers: int, size: int) -> int:
    """Pieces that hold some numbers of a size in bytes."""
    return -(-numbers * size // PIECE)


def runs_of_a_draw(table: sampler.Table) -> list[int]:
    """Runs that a draw without spin reads: alias, record, spans, and quantiles of each channel."""
    arrays = table.arrays
    quantiles = [1] * arrays.n_marginals
    return [1, pieces_of(arrays.stride, 2), pieces_of(2 * arrays.n_marginals, 8), *quantiles]


def runs_of_a_spin_draw() -> list[int]:
    """Runs that a draw with spin reads: inputs, gates of groups and experts, expert, outcomes."""
    gates = [pieces_of(N_FEATURES * count, 2) for count in (N_GROUPS, GROUP_SIZE)]
    numbers = [pieces_of(2 * N_INPUTS, 4), *gates, pieces_of(EXPERT_STRIDE, 2)]
    return [*numbers, pieces_of(2 * N_OUTCOMES, 4), *[1] * N_OUTCOMES]


def calls(table: sampler.Table, cupy: Any, count: int, dtype: str) -> dict[str, tuple[Call, str]]:
    """What is timed, and with which gather it is compared ("" for a gather itself)."""
    device, rng = table.to_device(dtype), np.random.default_rng(1)
    alpha1 = rng.uniform(*table.alpha_range, count)
    speed = rng.uniform(*table.speed_range, count)
    velocity = np.stack([speed * np.cos(alpha1), -speed * np.sin(alpha1), np.zeros(count)], axis=1)
    alpha, v, moving = (cupy.asarray(x.astype(dtype)) for x in (alpha1, speed, velocity))
    spin = cupy.asarray(rng.standard_normal((count, 3)).astype(dtype))
    up, at_rest = cupy.asarray(np.array([0.0, 1.0, 0.0], dtype)), cupy.asarray(np.zeros(3, dtype))
    keys = {"seed": 7, "index": cupy.asarray(np.arange(count, dtype=np.uint64))}
    keys["hit"] = cupy.asarray(np.zeros(count, np.uint32))
    image = binary_table(table.contents, table.arrays)
    end = int(np.frombuffer(image, HEADER_DTYPE, 1)["at_shape_codes"][0]) or len(image)
    of_draws = gather(cupy, image[:end], runs_of_a_draw(table), len(table.columns), count, dtype)
    found: dict[str, tuple[Call, str]] = {
        "gather, as a draw": (of_draws, ""),
        "draw": (lambda: device.sample(alpha, v, **keys), "gather, as a draw"),
        "rebound": (lambda: device.rebound(moving, up, 1e-5, **keys), "gather, as a draw"),
    }
    if table.has_spin:
        name, columns = "gather, as a draw with spin", len(table.columns)
        of_spins = gather(cupy, image[end:], runs_of_a_spin_draw(), columns, count, dtype)
        found |= {
            name: (of_spins, ""),
            "draw with spin": (lambda: device.sample(alpha, v, spin=spin, **keys), name),
            "rebound with spin": (
                lambda: device.rebound(moving, up, 1e-5, omega=at_rest, **keys),
                name,
            ),
        }
    return found


def gather(cupy: Any, memory: bytes, runs: list[int], numbers: int, count: int, dtype: str) -> Call:
    """Launch of a gather kernel, which ends when the device has."""
    options = ("-fmad=false", f"-DRBT_REAL={REALS[dtype]}")
    kernel = cupy.RawModule(code=GATHER, options=options).get_function("gather")
    device = cupy.cuda.Device()
    blocks = min(-(-count // 128), 32 * device.attributes["MultiProcessorCount"])
    given = cupy.asarray(np.frombuffer(memory, np.uint8)), np.uint64(len(memory) // PIECE)
    lengths = cupy.asarray(np.array(runs, np.int32))

    def call() -> Any:
        out = cupy.empty((count, numbers), dtype)
        sizes = np.uint64(count), lengths, np.int32(len(runs)), np.int32(numbers)
        kernel((blocks,), (128,), (*given, *sizes, out))
        device.synchronize()
        return out

    return call


def measure(timed: dict[str, tuple[Call, str]], count: int, rounds: int) -> list[dict[str, Any]]:
    """Rows a second of each call, and the share of what its gather reaches; None for a gather."""
    rates: dict[str, list[float]] = {name: [] for name in timed}
    for call, _ in timed.values():
        call()
    for turn in range(rounds):
        names = list(timed)
        for name in names[turn % len(names) :] + names[: turn % len(names)]:
            start = time.perf_counter()
            timed[name][0]()
            rates[name].append(count / (time.perf_counter() - start))
    return [
        {
            "name": name,
            "most": max(rates[name]),
            "median": statistics.median(rates[name]),
            "share": statistics.median(
                rate / most for rate, most in zip(rates[name], rates[base], strict=True)
            )
            if base
            else None,
        }
        for name, (_, base) in timed.items()
    ]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--table", default="corundum-steel")
    parser.add_argument("--count", type=int, default=10**7)
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--dtype", choices=[*REALS], default="float64")
    arguments = parser.parse_args()
    try:
        cupy, table = cupy_with_gpu(), sampler.load(arguments.table)
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    found = measure(
        calls(table, cupy, arguments.count, arguments.dtype), arguments.count, arguments.rounds
    )
    print(f"{arguments.dtype}, rows a second {'most':>14} {'median':>10} {'/ gather':>9}")
    for row in found:
        share = "" if row["share"] is None else f"{row['share']:9.2f}"
        print(f"{row['name']:32} {row['most']:10.3g} {row['median']:10.3g} {share:>9}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
