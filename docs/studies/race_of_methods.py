"""Race of methods: error against run time of tables, direct simulation and other ways to draw.

    python docs/studies/race_of_methods.py corundum-steel --beside corundum-steel-compact \
        --picture docs/error_against_time.png

A table answers at any angle and speed, from nodes elsewhere. The other methods have the easier
task: each is fitted to 40,000 states at the very condition at which it is judged. Independent
marginals draw each variable by itself; stored states are drawn with replacement; kernel resampling
adds Gaussian noise to them. A forbidden state moves into the wall or has gained energy. It takes
five minutes on two cores.
"""

import argparse
from functools import partial
from pathlib import Path

import numpy as np
from scipy.stats import gaussian_kde
from sklearn.mixture import GaussianMixture

from tablegen import simulate
from tablegen.config.config import stored_config
from tablegen.evidence.error_against_time import (
    CONDITION,
    BenchmarkCase,
    Budget,
    SamplingMethod,
    direct_methods,
    load_whole,
    other_table,
    run_benchmark,
    table_method,
)
from tablegen.evidence.report import PLOT_STYLES, conditions_of, errors_picture, method_table

#: States to which a method is fitted.
TRAINING = 40_000

#: Colour of Okabe and Ito, and marker, by family.
ALL_LOOKS = PLOT_STYLES | {
    "stored states": ("#d55e00", "^"),
    "independent marginals": ("#cc79a7", "v"),
    "Gaussian mixture": ("#009e73", "D"),
    "kernel resampling": ("#56b4e9", "P"),
}


def training_states(case):
    """Simulate the states that a method is fitted to."""
    alpha1 = np.radians(case.alpha_deg)
    return simulate(case.config, alpha1, case.speed, TRAINING, seed=case.seed).state


def independent_marginals(case):
    """Draw every variable by itself, from 257 quantiles."""
    levels = np.linspace(0.0, 1.0, 257)
    values = np.quantile(training_states(case), levels, axis=0)

    def draw(count, seed):
        uniform = np.random.default_rng(seed).random((count, 6))
        return np.column_stack([np.interp(uniform[:, k], levels, values[:, k]) for k in range(6)])

    return draw


def stored_states(case, stored):
    """Draw whole states from a store, with replacement."""
    store = training_states(case)[:stored].astype(np.float32)

    def draw(count, seed):
        rows = np.random.default_rng(seed).integers(len(store), size=count)
        return store[rows].astype(np.float64)

    return draw


def gaussian_mixture(case, components):
    """Draw from a Gaussian mixture with full covariances, fitted to the states."""
    fit = GaussianMixture(components, random_state=case.seed % 2**32).fit(training_states(case))

    def draw(count, seed):
        fit.set_params(random_state=seed % 2**32)
        # the library gives the components one after the other
        return np.random.default_rng(seed).permutation(fit.sample(count)[0])

    return draw


def kernel_resampling(case):
    """Draw from a Gaussian kernel density estimate of the states."""
    density = gaussian_kde(training_states(case).T)

    def draw(count, seed):
        return np.ascontiguousarray(density.resample(count, seed=seed % 2**32).T)

    return draw


def baseline_methods():
    """List the methods that one would use without a table; sizes are those of float32 numbers."""
    state, component = 6 * 4, (1 + 6 + 21) * 4
    baselines = [
        ("independent marginals", "257 quantiles", 257 * state, independent_marginals),
        ("stored states", "4,096 stored states", 4096 * state, partial(stored_states, stored=4096)),
        (
            "stored states",
            "16,384 stored states",
            16_384 * state,
            partial(stored_states, stored=16_384),
        ),
        (
            "Gaussian mixture",
            "8 components",
            8 * component,
            partial(gaussian_mixture, components=8),
        ),
        (
            "Gaussian mixture",
            "40 components",
            40 * component,
            partial(gaussian_mixture, components=40),
        ),
        ("kernel resampling", "Gaussian kernels", TRAINING * state, kernel_resampling),
    ]
    return [
        SamplingMethod(family, name, CONDITION, size, prepare)
        for family, name, size, prepare in baselines
    ]


def forbidden_share(state):
    """Return the share of states that no rebound can have: v <= 0, or more energy than before."""
    energy = np.square(state[:, :3]).sum(axis=1)
    return np.mean((state[:, 1] <= 0.0) | (energy > 1.0))


def main():
    """Run the race, print its tables, and draw the condition at which the table does worst."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("table", nargs="?", default="corundum-steel")
    parser.add_argument("--beside", nargs="*", default=[], help="other tables of the same pair")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--picture", type=Path, help="picture to write")
    args = parser.parse_args()
    table, budget = load_whole(args.table), Budget()
    config = stored_config(table.config, args.table)
    tables = [table_method(args.table), *(other_table(other, table) for other in args.beside)]
    methods, races = [*direct_methods(), *tables, *baseline_methods()], []
    for number, condition in enumerate(conditions_of(table, budget)):
        race = run_benchmark(methods, config, condition, budget, (args.seed, number))
        races.append(race)
        print(method_table(race), end="\n\n")
        case = BenchmarkCase(config, *condition, args.seed)
        for method in baseline_methods():
            state = method.prepare(case)(budget.batch, args.seed)
            print(f"{method.family}, {method.name}: forbidden {forbidden_share(state):.2%}")
        print()
    if args.picture:
        own = len(direct_methods())
        worst = max(races, key=lambda race: race.runners[own].errors["auc"].mean)
        args.picture.write_bytes(errors_picture(worst, args.picture.name, ALL_LOOKS))


if __name__ == "__main__":
    main()
