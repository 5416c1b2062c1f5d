"""Error of the direct model against its cost: contact resolution and flight tolerance.

    python tests/benchmarks/bench_error.py
    python tests/benchmarks/bench_error.py --angles 20 --count 50000

`tolerances` says how both are measured.
"""

import argparse

import harness  # noqa: F401  (makes the imports from a checkout possible)
from tolerances import FINEST, curve

from sampler.formats.shape_codes import SHAPE_NAMES
from tablegen.config.config import load_config


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    shapes = ["mixture", *SHAPE_NAMES]
    parser.add_argument("--shapes", nargs="+", choices=shapes, default=["mixture", "ellipsoid"])
    parser.add_argument("--angles", nargs="+", type=float, default=[0.5, 20.0, 45.0, 90.0])
    parser.add_argument("--speed", type=float, default=200.0)
    parser.add_argument("--count", type=int, default=400_000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    print(f"{options.count} rebounds at {options.speed:g} m/s; truth: {FINEST}")
    print(
        f"{'shape':<16}{'angle':>6}{'resolution':>12}{'tolerance':>11}"
        f"{'ns/rebound':>12}{'error':>12}{'noise':>10}  of"
    )
    config = load_config("corundum-steel")
    for shape in options.shapes:
        for angle in options.angles:
            for p in curve(config, shape, angle, options.speed, options.count, options.seed):
                print(
                    f"{p.shape:<16}{p.alpha_deg:>6g}{p.resolution:>12g}{p.tolerance:>11g}"
                    f"{p.nanoseconds:>12.0f}{p.error:>12.1e}{p.noise:>10.1e}"
                    f"  {p.statistic}{'  default' if p.is_default else ''}",
                    flush=True,
                )


if __name__ == "__main__":
    main()
