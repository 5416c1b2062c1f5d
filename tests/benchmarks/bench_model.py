"""Nanoseconds per rebound: the direct model, its readable reference, a plain C++ program.

    python tests/benchmarks/bench_model.py
    python tests/benchmarks/bench_model.py --shapes mixture --count 50000 --json model.json

Every model draws random particles of the same population and follows each to the end of its
rebound, on one thread. Times are processor time. The models take turns within each repetition, in
an order that rotates, so that a slow spell of the machine hits all of them; a ratio is the median
of the ratios of neighbours. Compilation is not timed. Without a C++ compiler (CXX, or else g++)
its column stays empty.
"""

import argparse
import json
import math
import platform
import statistics
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import baseline
import checkout  # noqa: F401  (before the imports that it makes possible)
from pathwise import random_particles
from reference_model import Law, Setup, rebounds
from tqdm import tqdm

from sampler.errors import InputError
from sampler.files import atomic_output, check_output
from sampler.library import processors
from tablegen.config.config import load_config
from tablegen.simulation.simulate import make_condition, simulate_condition

#: Runs a model once over (shape, angle in degrees); nanoseconds per rebound.
Timer = Callable[[str, float], float]

TABLEGEN, REFERENCE, CPP = "tablegen", "reference", "C++"
MODELS = (TABLEGEN, REFERENCE, CPP)


def tablegen_timer(speed: float, count: int, seed: int) -> Timer:
    """Time `tablegen.simulation.simulate.simulate_condition` on one thread."""
    config = load_config("corundum-steel")

    def timed(shape: str, alpha_deg: float) -> float:
        population = config.population.restricted_to(shape)
        condition = make_condition(math.radians(alpha_deg), speed)
        start = time.process_time()
        simulate_condition(config.pair, population, condition, count, seed=seed, threads=1)
        return 1e9 * (time.process_time() - start) / count

    return timed


def reference_timer(speed: float, count: int, seed: int) -> Timer:
    """Time the readable reference, its random particles included."""
    population = load_config("corundum-steel").population

    def timed(shape: str, alpha_deg: float) -> float:
        setup = Setup(math.radians(alpha_deg), speed)
        start = time.process_time()
        particles = random_particles(population.restricted_to(shape), count, seed)
        rebounds(Law(), setup, *particles, population.truncation)
        return 1e9 * (time.process_time() - start) / count

    return timed


def cpp_timer(program: Path, speed: float, count: int, seed: int) -> Timer:
    """Time the C++ baseline; it measures itself, without its start."""

    def timed(shape: str, alpha_deg: float) -> float:
        result = baseline.run(program, shape, alpha_deg, speed, count, seed)
        return 1e3 * float(result["microseconds"])

    return timed


def measure(
    timers: dict[str, Timer], shape: str, alpha_deg: float, repeat: int
) -> dict[str, list[float]]:
    """Nanoseconds per rebound of each model in each repetition."""
    names = list(timers)
    times: dict[str, list[float]] = {name: [] for name in names}
    for repetition in range(repeat):
        first = repetition % len(names)
        for name in names[first:] + names[:first]:
            times[name].append(timers[name](shape, alpha_deg))
    return times


def ratio(times: dict[str, list[float]], model: str) -> float:
    """How many times longer a model takes than tablegen's."""
    pairs = zip(times[model], times[TABLEGEN], strict=True)
    return statistics.median(slow / fast for slow, fast in pairs)


def header() -> str:
    """Head of the table."""
    columns = "".join(f"{f'{name} min':>16}{'median':>9}" for name in MODELS)
    over = "".join(f"{f'{name} / tablegen':>22}" for name in MODELS[1:])
    return f"{'shape':<16}{'angle':>6}{columns}{over}"


def row(shape: str, alpha_deg: float, times: dict[str, list[float]]) -> str:
    """One line of the table."""
    text = f"{shape:<16}{alpha_deg:>6g}"
    for name in MODELS:
        if name in times:
            text += f"{min(times[name]):>16.0f}{statistics.median(times[name]):>9.0f}"
        else:
            text += f"{'-':>16}{'-':>9}"
    for name in MODELS[1:]:
        text += f"{ratio(times, name):>22.1f}" if name in times else f"{'-':>22}"
    return text


def machine(compiler: str | None) -> dict[str, Any]:
    """What the times depend on besides the code."""
    return {
        "processor": platform.processor() or platform.machine(),
        "processors": processors(),
        "python": platform.python_version(),
        "compiler": Path(compiler).name if compiler else None,
        "flags": list(baseline.FLAGS),
    }


def at_least(low: float, kind: Callable[[str], Any]) -> Callable[[str], Any]:
    """Type of an argument that must not be below ``low``."""

    def convert(text: str) -> Any:
        try:
            value = kind(text)
        except ValueError:
            value = math.nan
        if not low <= value < math.inf:
            raise argparse.ArgumentTypeError(f"got {text!r}, allowed: {low:g} or more")
        return value

    return convert


def angle(text: str) -> float:
    """Type of an impact angle in degrees."""
    value = at_least(0.0, float)(text)
    if not 0.0 < value <= 90.0:
        raise argparse.ArgumentTypeError(f"got {text!r}, allowed: above 0 and up to 90")
    return float(value)


def output_file(text: str) -> Path:
    """Type of a file that can be written."""
    try:
        return check_output(text)
    except InputError as error:
        raise argparse.ArgumentTypeError(str(error).removeprefix("output: ")) from error


def parse(argv: Sequence[str] | None) -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--shapes", nargs="+", choices=baseline.SHAPES, default=baseline.SHAPES)
    parser.add_argument(
        "--angles", nargs="+", type=angle, default=[20.0, 45.0, 90.0], metavar="DEG"
    )
    parser.add_argument("--speed", type=at_least(1e-3, float), default=200.0, metavar="M_S")
    parser.add_argument("--count", type=at_least(1, int), default=10_000, metavar="N")
    parser.add_argument("--repeat", type=at_least(1, int), default=5, metavar="K")
    parser.add_argument("--seed", type=at_least(0, int), default=1, metavar="S")
    parser.add_argument("--json", type=output_file, metavar="F", help="write every time")
    return parser.parse_args(argv)


def benchmark(options: argparse.Namespace, folder: Path) -> dict[str, Any]:
    """Build, warm up, measure and print; everything measured."""
    run = (options.speed, options.count, options.seed)
    timers = {TABLEGEN: tablegen_timer(*run), REFERENCE: reference_timer(*run)}
    compiler = baseline.find_compiler()
    if compiler:
        timers[CPP] = cpp_timer(baseline.build(compiler, folder), *run)
    else:
        print("no C++ compiler found: no baseline", file=sys.stderr)
    measure(timers, options.shapes[0], options.angles[0], 1)  # compiles the kernels
    print(f"ns of one core per rebound, {options.count} rebounds, {options.repeat} repetitions")
    print(header())
    results = []
    cases = [(shape, alpha_deg) for shape in options.shapes for alpha_deg in options.angles]
    for shape, alpha_deg in tqdm(cases, leave=False, disable=not sys.stderr.isatty()):
        times = measure(timers, shape, alpha_deg, options.repeat)
        tqdm.write(row(shape, alpha_deg, times))
        results.append({"shape": shape, "alpha_deg": alpha_deg, "nanoseconds": times})
    return {
        "speed": options.speed,
        "count": options.count,
        "seed": options.seed,
        "machine": machine(compiler),
        "results": results,
    }


def main(argv: Sequence[str] | None = None) -> int:
    """Run the benchmark; exit status."""
    try:
        options = parse(argv)
        with tempfile.TemporaryDirectory() as folder:
            results = benchmark(options, Path(folder))
        if options.json:
            with atomic_output(options.json) as temporary:
                temporary.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
    except InputError as error:
        print(f"bench_model: error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
