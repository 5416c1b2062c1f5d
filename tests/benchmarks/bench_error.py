"""Error of the direct model against its cost: contact resolution and flight tolerance.

    python tests/benchmarks/bench_error.py
    python tests/benchmarks/bench_error.py --angles 20 --count 50000 --plot error.png

`tolerances` says what is measured, and how.
"""

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import checkout  # noqa: F401  (before the imports that it makes possible)
from bench_model import angle, at_least, machine, output_file
from tolerances import FINEST, Setting, curve
from tqdm import tqdm

from sampler.errors import InputError
from sampler.files.atomic import atomic_output
from tablegen.config.config import load_config
from tablegen.model.shape_codes import SHAPE_NAMES


def row(point: Setting) -> str:
    """One line of the table."""
    return (
        f"{point.shape:<16}{point.alpha_deg:>6g}{point.resolution:>12g}{point.tolerance:>11g}"
        f"{point.nanoseconds:>12.0f}{point.error:>12.1e}{point.noise:>10.1e}"
        f"  {point.statistic}{'  default' if point.is_default else ''}"
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
            star = next(i for i, p in enumerate(line) if p.is_default)
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
    points, config = [], load_config("corundum-steel")
    conditions = [(shape, a) for shape in options.shapes for a in options.angles]
    for shape, alpha_deg in tqdm(conditions, leave=False, disable=not sys.stderr.isatty()):
        for point in curve(config, shape, alpha_deg, options.speed, options.count, options.seed):
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
