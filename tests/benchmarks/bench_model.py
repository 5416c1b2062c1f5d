"""Nanoseconds per rebound: the direct model, its readable reference, a plain C++ program.

    python tests/benchmarks/bench_model.py
    python tests/benchmarks/bench_model.py --shapes mixture --count 50000

Every model draws random particles of the same population and follows each to the end of its
rebound, on one thread. Times are processor time without compilation and the start of programs; a
ratio is the median of the ratios to tablegen's time in the same repetition. Without a C++ compiler
(CXX, or else g++) its column is left out.
"""

import argparse
import json
import math
import os
import shutil
import statistics
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from harness import HERE, median_ratio  # isort: skip
from pathwise import random_particles
from reference_model import Law, Setup, rebounds

from tablegen.config.config import load_config
from tablegen.simulation.simulate import make_condition, simulate_condition

SHAPES = ("mixture", "ellipsoid", "prism", "truncated-prism", "tetrahedron")
CONFIG = load_config("corundum-steel")

#: Seconds of a run over (shape, angle in degrees).
Timer = Callable[[str, float], float]


def tablegen_timer(speed: float, count: int, seed: int) -> Timer:
    """Time the direct model."""

    def timed(shape: str, alpha_deg: float) -> float:
        population = CONFIG.population.restricted_to(shape)
        condition = make_condition(math.radians(alpha_deg), speed)
        start = time.process_time()
        simulate_condition(CONFIG.pair, population, condition, count, seed=seed, threads=1)
        return time.process_time() - start

    return timed


def reference_timer(speed: float, count: int, seed: int) -> Timer:
    """Time the readable reference with its random particles."""

    def timed(shape: str, alpha_deg: float) -> float:
        population = CONFIG.population.restricted_to(shape)
        start = time.process_time()
        particles = random_particles(population, count, seed)
        setup = Setup(math.radians(alpha_deg), speed)
        rebounds(Law(), setup, *particles, population.truncation)
        return time.process_time() - start

    return timed


def cpp_timer(compiler: str, folder: Path, speed: float, count: int, seed: int) -> Timer:
    """Build and time the C++ program, which measures itself."""
    program = folder / "rk4_baseline"
    source = str(HERE / "rk4_baseline.cpp")
    flags = ["-std=c++17", "-O3", "-march=native"]
    subprocess.run([compiler, *flags, source, "-o", str(program)], check=True)

    def timed(shape: str, alpha_deg: float) -> float:
        words = [str(program), shape, repr(alpha_deg), repr(speed), str(count), str(seed)]
        return 1e-6 * count * float(json.loads(subprocess.check_output(words))["microseconds"])

    return timed


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--shapes", nargs="+", choices=SHAPES, default=SHAPES)
    parser.add_argument("--angles", nargs="+", type=float, default=[20.0, 45.0, 90.0])
    parser.add_argument("--speed", type=float, default=200.0)
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    run = options.speed, options.count, options.seed
    with tempfile.TemporaryDirectory() as folder:
        timers = {"tablegen": tablegen_timer(*run), "reference": reference_timer(*run)}
        if compiler := shutil.which(os.environ.get("CXX", "g++")):
            timers["C++"] = cpp_timer(compiler, Path(folder), *run)
        for timer in timers.values():
            timer("mixture", 45.0)  # compiles the kernels
        print(f"ns of one core per rebound, {options.count} rebounds, {options.repeat} repetitions")
        columns = "".join(f"{f'{name} min':>16}{'median':>9}{'ratio':>7}" for name in timers)
        print(f"{'shape':<16}{'angle':>6}{columns}")
        for shape in options.shapes:
            for angle in options.angles:
                times: dict[str, list[float]] = {name: [] for name in timers}
                for _ in range(options.repeat):
                    for name, timer in timers.items():
                        times[name].append(1e9 * timer(shape, angle) / options.count)
                text = f"{shape:<16}{angle:>6g}"
                for own in times.values():
                    text += f"{min(own):>16.0f}{statistics.median(own):>9.0f}"
                    text += f"{median_ratio(own, times['tablegen']):>7.1f}"
                print(text, flush=True)


if __name__ == "__main__":
    main()
