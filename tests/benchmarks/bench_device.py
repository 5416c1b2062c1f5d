"""Draws a second on a GPU, beside kernels that read as many bytes from as many places.

    python tests/benchmarks/bench_device.py
    python tests/benchmarks/bench_device.py --table corundum-steel --count 10000000 --dtype float32

Needs CuPy and a GPU. Draws and rebounds are at random angles and speeds, and at random spins too if
the table has a spin law; all arrays live on the device. A gather kernel shows the limit of the
memory system: it reads the same number of bytes as a draw, in runs at random places of the same
table, and writes the same number. Times are of whole calls, which end when the device has; a share
is the median of the ratios of a round. It was never run on a GPU.
"""

import argparse
import sys
import time
from collections.abc import Callable
from typing import Any

from harness import in_turns, median_ratio  # isort: skip
import numpy as np

import sampler
from sampler.device.program import REALS, cupy_with_gpu
from sampler.errors import InputError
from sampler.formats.bounds import (
    GROUP_SIZE,
    N_FEATURES,
    N_GROUPS,
    N_INPUTS,
    N_OUTCOMES,
    expert_stride,
)
from sampler.formats.image import header_of, table_image

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


def runs_of_a_draw(header: Any) -> list[int]:
    """Runs that a draw without spin reads: alias, record, spans, and quantiles of each channel."""
    marginals = int(header["n_marginals"])
    return [1, pieces_of(int(header["stride"]), 2), pieces_of(2 * marginals, 8), *[1] * marginals]


def runs_of_a_spin_draw() -> list[int]:
    """Runs that a draw with spin reads: inputs, gates of groups and experts, expert, outcomes."""
    gates = [pieces_of(N_FEATURES * count, 2) for count in (N_GROUPS, GROUP_SIZE)]
    numbers = [pieces_of(2 * N_INPUTS, 4), *gates, pieces_of(expert_stride(N_OUTCOMES), 2)]
    return [*numbers, pieces_of(2 * N_OUTCOMES, 4), *[1] * N_OUTCOMES]


def calls(table: sampler.Table, cupy: Any, count: int, dtype: str) -> dict[str, dict[str, Call]]:
    """Gathers, draws and rebounds, without spin and with it."""
    device, rng = table.to_device(dtype), np.random.default_rng(1)
    alpha1 = rng.uniform(*table.alpha_range, count)
    speed = rng.uniform(*table.speed_range, count)
    velocity = np.stack([speed * np.cos(alpha1), -speed * np.sin(alpha1), np.zeros(count)], axis=1)
    alpha, v, moving = (cupy.asarray(x.astype(dtype)) for x in (alpha1, speed, velocity))
    spin = cupy.asarray(rng.standard_normal((count, 3)).astype(dtype))
    up, at_rest = cupy.asarray(np.array([0.0, 1.0, 0.0], dtype)), cupy.asarray(np.zeros(3, dtype))
    keys = {"seed": 7, "index": cupy.asarray(np.arange(count, dtype=np.uint64))}
    keys["hit"] = cupy.asarray(np.zeros(count, np.uint32))
    image, columns = table_image(table.contents), len(table.columns)
    header = header_of(image)
    end = int(header["at_shape_codes"]) or len(image)
    found = {
        "without spin": {
            "gather": gather(cupy, image[:end], runs_of_a_draw(header), columns, count, dtype),
            "draw": lambda: device.sample(alpha, v, **keys),
            "rebound": lambda: device.rebound(moving, up, 1e-5, **keys),
        }
    }
    if table.has_spin:
        found["with spin"] = {
            "gather": gather(cupy, image[end:], runs_of_a_spin_draw(), columns, count, dtype),
            "draw": lambda: device.sample(alpha, v, spin=spin, **keys),
            "rebound": lambda: device.rebound(moving, up, 1e-5, omega=at_rest, **keys),
        }
    return found


def gather(cupy: Any, memory: Any, runs: list[int], numbers: int, count: int, dtype: str) -> Call:
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


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--table", default="corundum-steel")
    parser.add_argument("--count", type=int, default=10**7)
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--dtype", choices=[*REALS], default="float64")
    options = parser.parse_args()
    try:
        cupy, table = cupy_with_gpu(), sampler.load(options.table)
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    print(f"{options.dtype}, rows a second {'most':>14} {'of gather':>9}")
    for kind, timed in calls(table, cupy, options.count, options.dtype).items():
        measured = in_turns(timed, options.rounds, time.perf_counter)
        for name, times in measured.items():
            share = median_ratio(measured["gather"], times)
            print(f"{name + ' ' + kind:32} {options.count / min(times):10.3g} {share:9.2f}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
