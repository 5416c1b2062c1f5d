"""Measure the accuracy of a table against direct simulation with new particles."""

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sampler.formats.channels import STATE
from sampler.formats.layout import ACCURACY
from sampler.table import Table
from tablegen.accuracy.chains import LaterHit, chains_of
from tablegen.accuracy.comparison import Comparison, compare
from tablegen.accuracy.conditions import Place
from tablegen.config.config import Config
from tablegen.config.metric_table import CHAINS, METRICS
from tablegen.config.targets import AccuracyTargets
from tablegen.parallel import in_threads
from tablegen.progress import bar
from tablegen.simulation.scene_variables import simulated_variables
from tablegen.simulation.simulate import simulate

#: Least number of states a side; and their number times the square of the declared
#: Kolmogorov-Smirnov distance, so that the noise is a fifth of that distance.
_LEAST_SAMPLES = 100_000
_SAMPLES = 40.0

#: Largest number of states: four million take a gigabyte and half a minute.
_MOST_SAMPLES = 4_000_000

#: First stream of measurements; nodes use those below.
FIRST_STREAM = 2**31

#: First number of conditions of particles with their own grain; other conditions have those below.
FIRST_OWN = 2**29


def sample_size(targets: AccuracyTargets) -> int:
    """Compute the states a side that tell a declared accuracy from noise."""
    return min(max(_LEAST_SAMPLES, int(_SAMPLES / targets.ks**2)), _MOST_SAMPLES)


def compared(
    table: Table, config: Config, seed: int, samples: int, numbered: tuple[int, Place]
) -> Comparison:
    """Compare a table with direct simulation at one condition.

    The number separates conditions that share a seed: stream of the simulation, hit of the draws.
    """
    number, place = numbered
    alpha1, speed = np.radians(place.alpha_deg), place.speed
    shared: dict[str, Any] = {"seed": seed, "threads": 1}
    direct = simulate(config, alpha1, speed, samples, stream=FIRST_STREAM + number, **shared)
    keys = shared | ({"spin": np.zeros(3)} if place.own else {})
    drawn = table.sample(alpha1, speed, hit=number, index=np.arange(samples), **keys)
    states = drawn, simulated_variables(direct, table.columns)
    return compare(*states, place.alpha_deg, speed, seed % 2**32, table.columns, place.own)


def measure(
    table: Table,
    config: Config,
    places: Sequence[Place],
    *,
    seed: int,
    samples: int,
    progress: bool = False,
) -> list[Comparison]:
    """Compare a table with direct simulation at conditions of one law, with states a side.

    ``progress`` shows a bar on standard error.
    """
    own = any(place.own for place in places)
    first, words = (FIRST_OWN, "own grain") if own else (0, "validating")
    work = partial(compared, table, config, seed, samples)
    with bar(progress, "condition", total=len(places), desc=words) as counted:
        return in_threads(work, enumerate(places, first), counted.update)


def measure_chains(
    table: Table,
    config: Config,
    *,
    seed: int,
    samples: int | None = None,
    progress: bool = False,
) -> list[LaterHit]:
    """Compare a spin law with direct simulation along chains of hits (`tablegen.accuracy.chains`).

    ``samples`` are the grains of a kind a side. A table that leaves some of the six variables of a
    state out has no chains, because a chain goes on from all six.
    """
    if not set(STATE) <= set(table.columns):
        return []
    work = chains_of(table, config, seed, samples)
    with bar(progress, "chain", total=len(work), desc="later hits") as counted:
        parts = in_threads(lambda chain: chain(), work, counted.update)
    return [hit for part in parts for hit in part]


def spin_accuracy_datasets(
    own: Sequence[Comparison] = (), hits: Sequence[LaterHit] = ()
) -> dict[str, NDArray[np.float64]]:
    """Make the datasets of the group ``spin_accuracy``; empty ones if nothing was measured."""
    columns: dict[str, list[Any]] = {
        "alpha_deg": [c.alpha_deg for c in own],
        "speed": [c.speed for c in own],
        "spin": [(0.0, 0.0, 0.0)] * len(own),
        **{name: [c.distances()[name] for c in own] for name in METRICS},
        **{name: [hit.estimates[name].value for hit in hits] for name in CHAINS},
    }
    wide = {"spin": 3, "ks": len(own[0].variables if own else STATE)}
    arrays = {name: np.array(values, dtype=np.float64) for name, values in columns.items()}
    return {
        f"{ACCURACY}{name}": values.reshape(-1, wide[name]) if name in wide else values
        for name, values in arrays.items()
    }
