"""Error of the direct model against its cost: contact resolution and flight tolerance.

    python tests/benchmarks/bench_error.py

Each setting simulates the same particles as a much finer setting. So the differences have no
sampling noise, except from the few particles whose course a setting changes. The error is the
largest change of a statistic: mean, standard deviation and the 1, 10, 50, 90 and 99 per cent
quantiles of each variable of the state (in V and V/a), and each correlation. The cost is processor
time on one thread.
"""

import argparse
import math
import time

import harness  # noqa: F401  (makes the imports from a checkout possible)
import numpy as np

from tablegen.config.config import load_config
from tablegen.simulation.simulate import CONTACT_RESOLUTION, TOLERANCE, simulate

#: Resolutions and tolerances compared: one of the two is varied, the other has its default.
SETTINGS = [(x, TOLERANCE) for x in (1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4)]
SETTINGS += [(CONTACT_RESOLUTION, 10.0**-k) for k in range(4, 13)]

#: The setting that stands for the truth.
FINEST = (1e-6, 1e-13)

QUANTILES = (0.01, 0.1, 0.5, 0.9, 0.99)


def summary_statistics(state):
    """Compute the statistics of states (n, 6) whose errors are measured."""
    quantiles = np.quantile(state, QUANTILES, axis=0)
    return {
        "mean": state.mean(axis=0),
        "deviation": state.std(axis=0),
        "correlation": np.asarray(np.corrcoef(state.T))[np.triu_indices(6, 1)],
        **{f"quantile {q:g}": row for q, row in zip(QUANTILES, quantiles, strict=True)},
    }


def print_curve(config, shape, alpha_deg, options):
    """Print error and cost of every setting at one condition."""
    population = config.population.restricted_to(shape)

    def run(resolution, tolerance):
        numerics = {"contact_resolution": resolution, "tolerance": tolerance}
        changed, start = config.with_changes({"model": numerics}), time.process_time()
        state = simulate(
            changed,
            math.radians(alpha_deg),
            options.speed,
            options.count,
            population=population,
            seed=options.seed,
            threads=1,
        ).state
        return state, 1e9 * (time.process_time() - start) / options.count

    truth = summary_statistics(run(*FINEST)[0])
    for setting in SETTINGS:
        state, cost = run(*setting)
        statistics = summary_statistics(state)
        changes = {name: np.abs(statistics[name] - truth[name]).max() for name in truth}
        worst = max(changes, key=changes.__getitem__)
        print(
            f"{shape:<16}{alpha_deg:>6g}{setting[0]:>12g}{setting[1]:>11g}{cost:>12.0f}"
            f"{changes[worst]:>12.1e}  {worst}"
            f"{'  default' if setting == (CONTACT_RESOLUTION, TOLERANCE) else ''}",
            flush=True,
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--angles", nargs="+", type=float, default=[0.5, 20.0, 45.0, 90.0])
    parser.add_argument("--speed", type=float, default=200.0)
    parser.add_argument("--count", type=int, default=400_000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    print(f"{options.count} rebounds at {options.speed:g} m/s; truth: {FINEST}")
    print(
        f"{'shape':<16}{'angle':>6}{'resolution':>12}{'tolerance':>11}"
        f"{'ns/rebound':>12}{'error':>12}  of"
    )
    config = load_config("corundum-steel")
    for shape in ("mixture", "ellipsoid"):
        for angle in options.angles:
            print_curve(config, shape, angle, options)


if __name__ == "__main__":
    main()
