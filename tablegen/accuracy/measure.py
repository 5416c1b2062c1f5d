"""Measure the accuracy of a table: simulate new particles, draw as many states, compare them.

The random numbers differ from those that the table was fitted to.
"""

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sampler.formats.channels import STATE
from sampler.formats.layout import ACCURACY
from sampler.table import Table
from tablegen.accuracy.chains import LaterHit, chain_comparisons
from tablegen.accuracy.comparison import Comparison, compare
from tablegen.accuracy.conditions import ComparedCondition
from tablegen.config.config import Config
from tablegen.config.metric_table import CHAINS, METRICS
from tablegen.config.targets import AccuracyTargets
from tablegen.parallel import in_threads
from tablegen.progress import bar
from tablegen.simulation.scene_variables import simulated_variables
from tablegen.simulation.simulate import simulate

#: Smallest number of states on each side, which the classifier needs, and the largest. Four million
#: states take a gigabyte of memory and half a minute.
SMALLEST_SAMPLES, _LARGEST_SAMPLES = 100_000, 4_000_000

#: Number of states times the square of the declared Kolmogorov-Smirnov distance. With this number,
#: the noise of the measured distance is about a quarter of the declared distance.
_SAMPLES = 40.0

#: First stream of random numbers of measurements. The nodes of a table use the streams below it.
FIRST_STREAM = 2**31

#: First number of the conditions of the spin law. Conditions of the law of first impacts have
#: numbers below it.
FIRST_OWN = 2**29


def sample_size(targets: AccuracyTargets, smallest: int = SMALLEST_SAMPLES) -> int:
    """Compute how many states on each side are needed to measure a declared accuracy."""
    return min(max(smallest, int(_SAMPLES / targets.ks**2)), _LARGEST_SAMPLES)


def compare_condition(
    table: Table, config: Config, seed: int, samples: int, numbered: tuple[int, ComparedCondition]
) -> Comparison:
    """Compare a table with direct simulation at one condition.

    ``numbered`` is the condition with a number of its own. The number gives each condition other
    random numbers from the same seed: it selects the stream of the simulation, and is the ``hit``
    of the draws.
    """
    number, place = numbered
    alpha1, speed = np.radians(place.alpha_deg), place.speed
    return compare(
        # The two samples have no name here, so that `compare` can free them.
        table.sample(
            alpha1,
            speed,
            spin=np.zeros(3) if place.own else None,
            seed=seed,
            index=np.arange(samples),
            hit=number,
            threads=1,
        ),
        simulated_variables(
            simulate(
                config, alpha1, speed, samples, seed=seed, stream=FIRST_STREAM + number, threads=1
            ),
            table.columns,
        ),
        place.alpha_deg,
        speed,
        seed=seed % 2**32,
        variables=table.columns,
        own=place.own,
    )


def measure(
    table: Table,
    config: Config,
    places: Sequence[ComparedCondition],
    *,
    seed: int,
    samples: int,
    progress: bool = False,
) -> list[Comparison]:
    """Compare a table with direct simulation at conditions of one law.

    Parameters
    ----------
    table, config
        The table, and the configuration that it was made from.
    places : sequence of ComparedCondition
        Conditions, all of the same law.
    seed : int
        Seed of the simulation and of the draws.
    samples : int
        Number of states on each side at each condition.
    progress : bool
        Show a progress bar on standard error.
    """
    own = any(place.own for place in places)
    first, task = (FIRST_OWN, "spin law") if own else (0, "law of first impacts")
    work = partial(compare_condition, table, config, seed, samples)
    with bar(progress, "condition", total=len(places), desc=f"validating the {task}") as counter:
        return in_threads(work, enumerate(places, first), counter.update)


def measure_chains(
    table: Table,
    config: Config,
    *,
    seed: int,
    samples: int | None = None,
    progress: bool = False,
) -> list[LaterHit]:
    """Compare a spin law with direct simulation along chains of hits (`tablegen.accuracy.chains`).

    ``samples`` is the number of grains of each kind on each side. The list is empty if the table
    lacks one of the six variables of a state, because the next hit of a chain needs all six.
    """
    if not set(STATE) <= set(table.columns):
        return []
    work = chain_comparisons(table, config, seed, samples)
    with bar(progress, "chain", total=len(work), desc="validating later hits") as counter:
        parts = in_threads(lambda chain: chain(), work, counter.update)
    return [hit for part in parts for hit in part]


def spin_accuracy_datasets(
    own: Sequence[Comparison] = (), hits: Sequence[LaterHit] = ()
) -> dict[str, NDArray[np.float64]]:
    """Make the datasets of the group ``spin_accuracy`` of a table file.

    They are empty if nothing was measured.
    """
    columns: dict[str, list[Any]] = {
        "alpha_deg": [c.alpha_deg for c in own],
        "speed": [c.speed for c in own],
        "spin": [(0.0, 0.0, 0.0)] * len(own),
        **{name: [c.distances()[name] for c in own] for name in METRICS},
        **{
            name: [hit.estimates[name].value for hit in hits]
            for name, metric in CHAINS.items()
            if metric.stored
        },
    }
    wide = {"spin": 3, "ks": len(own[0].variables if own else STATE)}
    arrays = {name: np.array(values, dtype=np.float64) for name, values in columns.items()}
    return {
        f"{ACCURACY}{name}": values.reshape(-1, wide[name]) if name in wide else values
        for name, values in arrays.items()
    }
