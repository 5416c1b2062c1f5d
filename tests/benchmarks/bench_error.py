"""Error of the direct model against its cost: contact resolution and flight tolerance.

    python tests/benchmarks/bench_error.py
    python tests/benchmarks/bench_error.py --angles 20 --count 50000 --plot error.png

Every setting follows the same particles as a much finer one, so the differences hold no sampling
noise but that of the few particles whose course a setting changes. Error is the largest change of
a statistic: mean, standard deviation and the 1, 10, 50, 90 and 99 per cent quantiles of each
component of the state (in V and V/a), and each correlation. Beside it stands the standard error
of the largest change of a mean. Cost is processor time on one thread.
"""

import argparse
import json
import math
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import checkout  # noqa: F401  (before the imports that it makes possible)
import numpy as np
from bench_model import angle, at_least, machine, output_file
from numpy.typing import NDArray
from tqdm import tqdm

from sampler.atomic import atomic_output
from sampler.errors import InputError
from tablegen.config import load_config
from tablegen.particles import SHAPE_NAMES
from tablegen.simulate import CONTACT_RESOLUTION, TOLERANCE, make_condition, simulate

#: Settings compared: one of the two is varied, the other has its default.
RESOLUTIONS = (1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4)
TOLERANCES = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12)

#: The setting that stands for the truth.
FINEST = (1e-6, 1e-13)

QUANTILES = (0.01, 0.1, 0.5, 0.9, 0.99)


@dataclass(frozen=True)
class Setting:
    """One point of the curve."""

    shape: str
    alpha_deg: float
    varied: str
    resolution: float
    tolerance: float
    nanoseconds: float
    error: float
    statistic: str
    noise: float


def statistics_of(state: NDArray[np.float64]) -> dict[str, NDArray[np.float64]]:
    """Give every statistic of (n, 6) states whose error is asked for."""
    quantiles = np.quantile(state, QUANTILES, axis=0)
    upper = np.triu_indices(6, 1)
    return {
        "mean": state.mean(axis=0),
        "deviation": state.std(axis=0),
        "correlation": np.corrcoef(state.T)[upper],
        **{f"quantile {q:g}": row for q, row in zip(QUANTILES, quantiles, strict=True)},
    }


def largest_change(
    one: dict[str, NDArray[np.float64]], other: dict[str, NDArray[np.float64]]
) -> tuple[float, str]:
    """Largest difference of two sets of statistics, and of which it is."""
    changes = {name: float(np.abs(one[name] - other[name]).max()) for name in one}
    name = max(changes, key=changes.__getitem__)
    return changes[name], name


def settings() -> Iterator[tuple[str, float, float]]:
    """What is varied, resolution and tolerance of every point."""
    for resolution in RESOLUTIONS:
        yield "resolution", resolution, TOLERANCE
    for tolerance in TOLERANCES:
        yield "tolerance", CONTACT_RESOLUTION, tolerance


def curve(shape: str, alpha_deg: float, options: argparse.Namespace) -> Iterator[Setting]:
    """Error and cost of every setting at one condition."""
    config = load_config("corundum-steel")
    population = config.population.restricted_to(shape)

    def run(resolution: float, tolerance: float) -> tuple[NDArray[np.float64], float]:
        condition = make_condition(
            math.radians(alpha_deg), options.speed, resolution=resolution, tolerance=tolerance
        )
        start = time.process_time()
        made = simulate(
            config.pair, population, condition, options.count, seed=options.seed, threads=1
        )
        return made.state, 1e9 * (time.process_time() - start) / options.count

    true_state, _ = run(*FINEST)
    truth = statistics_of(true_state)
    for varied, resolution, tolerance in settings():
        state, nanoseconds = run(resolution, tolerance)
        error, statistic = largest_change(statistics_of(state), truth)
        noise = float(np.std(state - true_state, axis=0).max() / math.sqrt(options.count))
        yield Setting(
            shape, alpha_deg, varied, resolution, tolerance, nanoseconds, error, statistic, noise
        )


def is_default(point: Setting) -> bool:
    """Whether a point has the default settings."""
    return (point.resolution, point.tolerance) == (CONTACT_RESOLUTION, TOLERANCE)


def row(point: Setting) -> str:
    """One line of the table."""
    return (
        f"{point.shape:<16}{point.alpha_deg:>6g}{point.resolution:>12g}{point.tolerance:>11g}"
        f"{point.nanoseconds:>12.0f}{point.error:>12.1e}{point.noise:>10.1e}"
        f"  {point.statistic}{'  default' if is_default(point) else ''}"
    )


def draw(points: Sequence[Setting], file: Path) -> None:
    """Plot error against cost, one curve a condition; a star marks the default."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 4.5), layout="constrained")
    panels = figure.subplots(1, 2, sharey=True)
    for axes, varied in zip(panels, ("resolution", "tolerance"), strict=True):
        chosen = [p for p in points if p.varied == varied]
        for shape, alpha_deg in dict.fromkeys((p.shape, p.alpha_deg) for p in chosen):
            line = [p for p in chosen if (p.shape, p.alpha_deg) == (shape, alpha_deg)]
            cost, error = [p.nanoseconds for p in line], [max(p.error, 1e-16) for p in line]
            axes.loglog(cost, error, "o-", label=f"{shape}, {alpha_deg:g}°")
            star = next(i for i, p in enumerate(line) if is_default(p))
            axes.loglog(cost[star], error[star], "k*", markersize=12)
        axes.axhline(1e-4, color="grey", linestyle=":")
        axes.set(xlabel="ns of one core per rebound", title=f"{varied} varied (star: default)")
    panels[0].set_ylabel("largest error of a statistic")
    panels[0].legend()
    figure.savefig(file, format=file.suffix.lstrip(".") or "png")


def parse(argv: Sequence[str] | None) -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    names = ["mixture", *SHAPE_NAMES]
    parser.add_argument("--shapes", nargs="+", choices=names, default=["mixture", "ellipsoid"])
    parser.add_argument(
        "--angles", nargs="+", type=angle, default=[0.5, 20.0, 45.0, 90.0], metavar="DEG"
    )
    parser.add_argument("--speed", type=at_least(1e-3, float), default=200.0, metavar="M_S")
    parser.add_argument("--count", type=at_least(2, int), default=400_000, metavar="N")
    parser.add_argument("--seed", type=at_least(0, int), default=1, metavar="S")
    parser.add_argument("--json", type=output_file, metavar="F", help="write every point")
    parser.add_argument("--plot", type=output_file, metavar="F", help="draw the curves")
    return parser.parse_args(argv)


def benchmark(options: argparse.Namespace) -> list[Setting]:
    """Measure and print; every point."""
    print(
        f"{options.count} rebounds at {options.speed:g} m/s; truth: resolution, tolerance {FINEST}"
    )
    print(
        f"{'shape':<16}{'angle':>6}{'resolution':>12}{'tolerance':>11}"
        f"{'ns/rebound':>12}{'error':>12}{'noise':>10}  of"
    )
    points = []
    conditions = [(shape, a) for shape in options.shapes for a in options.angles]
    for shape, alpha_deg in tqdm(conditions, leave=False, disable=not sys.stderr.isatty()):
        for point in curve(shape, alpha_deg, options):
            tqdm.write(row(point))
            points.append(point)
    return points


def main(argv: Sequence[str] | None = None) -> int:
    """Run the benchmark; exit status."""
    try:
        options = parse(argv)
        points = benchmark(options)
        if options.json:
            result: dict[str, Any] = {
                "speed": options.speed,
                "count": options.count,
                "seed": options.seed,
                "machine": machine(None),
                "points": [asdict(point) for point in points],
            }
            with atomic_output(options.json) as temporary:
                temporary.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
        if options.plot:
            draw(points, options.plot)
    except InputError as error:
        print(f"bench_error: error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
