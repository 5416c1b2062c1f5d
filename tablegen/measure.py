"""Accuracy of a table at conditions between its nodes, against fresh direct simulation."""

from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits
from tqdm import tqdm

from sampler.arrays import Axis
from sampler.table import Table
from tablegen.accuracy import Comparison, compare
from tablegen.components import simulated_components
from tablegen.config import AccuracyTargets, Config
from tablegen.simulate import simulate

#: Least number of states a side in a comparison, and this over the square of the declared
#: Kolmogorov-Smirnov distance where that is more: noise is then a third of what is declared.
_LEAST_SAMPLES = 100_000
_SAMPLES = 40.0

#: Streams from here on belong to measurements; nodes use those below.
FIRST_STREAM = 2**31

#: A condition keeps this distance, in units of a cell, from the nodes of an axis.
_MARGIN = 0.2


def sample_size(targets: AccuracyTargets) -> int:
    """States a side with which a declared accuracy can be told from noise.

    Two samples of n differ by sqrt(log(12 / q) / n) in the worst of six components with
    probability q; at q = 1e-3 that is half of the declared distance.

    Parameters
    ----------
    targets : AccuracyTargets

    Returns
    -------
    int
    """
    return max(_LEAST_SAMPLES, int(_SAMPLES / targets.ks**2))


def pick_conditions(table: Table, count: int, seed: int) -> list[tuple[float, float]]:
    """Choose conditions well inside the cells between nodes.

    They are a Latin hypercube in the fractional node index: any cell is as likely as another,
    small cells near grazing included, and both axes are covered evenly.

    Parameters
    ----------
    table : Table
    count : int
    seed : int

    Returns
    -------
    list of (alpha_deg, speed)
    """
    if count == 0:
        return []
    rng = np.random.Generator(np.random.Philox(key=[seed, FIRST_STREAM]))
    strata = np.column_stack([np.arange(count), rng.permutation(count)])
    points = (strata + rng.random((count, 2))) / count
    alpha = np.rad2deg(_between_nodes(points[:, 0], table.arrays.alpha))
    speed = _between_nodes(points[:, 1], table.arrays.speed)
    return [(float(a), float(v)) for a, v in zip(alpha, speed, strict=True)]


def _between_nodes(u: NDArray[np.float64], axis: Axis) -> NDArray[np.float64]:
    """Map uniform numbers to values between nodes; an axis of one node has only that value."""
    cells = axis.nodes - 1
    if cells == 0:
        return np.full(len(u), axis.first)
    cell, fraction = np.divmod(u * cells, 1.0)
    index = np.minimum(cell, cells - 1) + _MARGIN + (1.0 - 2.0 * _MARGIN) * fraction
    steps = axis.origin + np.arange(len(axis.coordinate)) / axis.scale
    return np.interp(index, axis.coordinate, steps)


def measure(
    table: Table,
    config: Config,
    conditions: Sequence[tuple[float, float]],
    *,
    seed: int,
    samples: int | None = None,
    progress: bool = False,
) -> list[Comparison]:
    """Compare a table with direct simulation at some conditions.

    Parameters
    ----------
    table : Table
    config : Config
        What the table claims to represent.
    conditions : sequence of (alpha_deg, speed)
    seed : int
        Of the simulation, of the draws and of the metrics.
    samples : int, optional
        States a side; by default as many as the declared accuracy needs.
    progress : bool
        Show a progress bar on standard error.

    Returns
    -------
    list of Comparison, in the order of the conditions
    """
    samples = samples or sample_size(config.accuracy)
    bar = tqdm(total=len(conditions), desc="validating", unit="condition", disable=not progress)
    found = []
    # one thread: sums in another order would change the last bit of what a table says of itself
    with bar, threadpool_limits(limits=1, user_api="blas"):
        for comparison in _comparisons(table, config, conditions, seed, samples):
            found.append(comparison)
            bar.update()
    return found


def _comparisons(
    table: Table,
    config: Config,
    conditions: Sequence[tuple[float, float]],
    seed: int,
    samples: int,
) -> Iterator[Comparison]:
    """Comparisons in order; the next condition is simulated while one is being compared."""

    def states(k: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        alpha_deg, speed = conditions[k]
        direct = simulate(
            config,
            np.radians(alpha_deg),
            speed,
            samples,
            seed=seed,
            stream=FIRST_STREAM + k,
            threads=1,
        )
        drawn = table.sample(
            np.radians(alpha_deg), speed, seed=seed, hit=k, index=np.arange(samples)
        )
        return drawn, simulated_components(direct, table.components)

    if not conditions:
        return
    with ThreadPoolExecutor(1) as pool:
        following = pool.submit(states, 0)
        for k, (alpha_deg, speed) in enumerate(conditions):
            drawn, direct = following.result()
            if k + 1 < len(conditions):
                following = pool.submit(states, k + 1)
            yield compare(
                drawn, direct, alpha_deg, speed, seed=seed % 2**32, components=table.components
            )


def missed_targets(comparisons: Sequence[Comparison], targets: AccuracyTargets) -> list[str]:
    """One line for each accuracy that was missed, with its worst condition.

    Parameters
    ----------
    comparisons : sequence of Comparison
    targets : AccuracyTargets

    Returns
    -------
    list of str
        Empty if the declared accuracy holds at every condition.
    """
    lines = []
    for name, value in (
        ("ks", lambda c: max(c.ks)),
        ("sliced_wasserstein", lambda c: c.sliced_wasserstein),
        ("correlation_error", lambda c: c.correlation_error),
        ("auc", lambda c: c.auc),
    ):
        worst = max(comparisons, key=value)
        declared = getattr(targets, name)
        if not value(worst) <= declared:
            lines.append(
                f"{name}: {value(worst):.4f} at {worst.alpha_deg:.2f} degrees, "
                f"{worst.speed:.1f} m/s, declared at most {declared:g}"
            )
    return lines
