"""Draws a second on a GPU beside one thread of the host, and whether both give the same numbers.

    python tests/benchmarks/bench_device.py
    python tests/benchmarks/bench_device.py --table forder-1998 --rounds 21

Needs CuPy and a GPU. All arrays live on the device before a call, and a call is timed to its end.
The host draws the same rows, from numpy arrays. Equal are numbers of the same bits; the largest
difference is over the standard deviation of the host's numbers.
"""

import argparse
import statistics
import time
from collections.abc import Callable
from typing import Any

from harness import in_turns  # isort: skip
import numpy as np
from bench_draw import Conditions

import sampler

NAMES = ("alpha1", "speed", "velocity", "spin", "omega", "inertia", "index", "hit")
NORMAL, HALF_SIZE = (0.0, 1.0, 0.0), 2.0**-17  # the same in both types


def draws_of(
    table: Any, conditions: Conditions, as_array: Callable, **more: Any
) -> dict[str, Callable]:
    """Give the draws of a table or of a device, with arrays of its kind."""
    c = {name: as_array(getattr(conditions, name)) for name in NAMES}
    keys = {"seed": 7, "index": c["index"], "hit": c["hit"], **more}
    spin = {"spin": c["spin"], "inertia": c["inertia"]}
    omega = {"omega": c["omega"], "inertia": c["inertia"]}
    return {
        "sample": lambda: table.sample(c["alpha1"], c["speed"], **keys),
        "sample, spin": lambda: table.sample(c["alpha1"], c["speed"], **keys, **spin),
        "rebound, spin": lambda: (
            table.rebound(c["velocity"], NORMAL, HALF_SIZE, **keys, **omega).velocity
        ),
    }


def main() -> None:
    import cupy

    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--table", default="corundum-steel")
    parser.add_argument("--count", type=int, default=10**7)
    parser.add_argument("--rounds", type=int, default=11)
    options = parser.parse_args()
    table = sampler.load(options.table)
    conditions = Conditions(table, options.count)
    for name in NAMES[:6]:  # so that both types have the same numbers
        setattr(conditions, name, getattr(conditions, name).astype(np.float32).astype(float))
    host = draws_of(table, conditions, np.asarray, threads=1)
    expected = {name: draw() for name, draw in host.items()}
    seconds = in_turns(host, 3, time.perf_counter)
    properties = cupy.cuda.runtime.getDeviceProperties(cupy.cuda.Device().id)
    print(f"{properties['name'].decode()}, CuPy {cupy.__version__}")
    print(f"{'million draws a second':24}     host   device     equal  largest difference")
    for dtype in ("float64", "float32"):

        def as_array(values: np.ndarray, dtype: str = dtype) -> Any:
            return cupy.asarray(values.astype(dtype) if values.dtype.kind == "f" else values)

        # a call of the device waits for it, once the flags of its rows are read
        device = draws_of(table.to_device(dtype), conditions, as_array)
        times = in_turns(device, options.rounds, time.perf_counter)
        for name, draw in device.items():
            given, wanted = cupy.asnumpy(draw()), expected[name].astype(dtype)
            largest = np.abs(given - wanted).max() / wanted.std()
            rates = (1e-6 * options.count / statistics.median(x[name]) for x in (seconds, times))
            figures = (*rates, np.mean(given == wanted), largest)
            row = "{:24} {:8.1f} {:8.0f} {:9.7f} {:19.1e}"
            print(row.format(f"{name}, {dtype}", *figures))


if __name__ == "__main__":
    main()
