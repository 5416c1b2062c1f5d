"""Make a table: choose sizes and nodes, fit them, measure the accuracy, write the file."""

import time
from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from sampler.arguments import as_integer
from sampler.errors import refuse
from sampler.files import check_output
from sampler.formats.hdf5 import write_table
from sampler.table import Table
from tablegen.accuracy.comparison import Comparison
from tablegen.accuracy.conditions import (
    pick_conditions,
    pick_own_conditions,
)
from tablegen.accuracy.measure import LawAccuracy, measure, measure_spin, spin_accuracy_datasets
from tablegen.checkpoints import CheckpointStore, TaskRunner, software
from tablegen.config.config import Config
from tablegen.config.defaults import GENERATE_CONDITIONS
from tablegen.fitting.spin_law import spin_law
from tablegen.tables.assembly import accuracy_datasets, assemble, with_rounded_quantiles
from tablegen.tables.axes import make_axes
from tablegen.tables.cost import Cost, estimate
from tablegen.tables.refine import NodeCache, refine_grid
from tablegen.tables.rehearsal import rehearse
from tablegen.tables.spheres import sphere_contents

#: Seed of the measurement, other than the default seed of a validation.
_MEASURE_SEED = 0xACC0


@dataclass(frozen=True)
class Generated:
    """A new table and its measured accuracy.

    Attributes
    ----------
    table : Table
    comparisons : list of Comparison
        At conditions between nodes that played no part in placing them.
    seconds : dict
        Worker seconds by stage.
    spin : LawAccuracy or None
        Accuracy of the spin law, if there is one.
    """

    table: Table
    comparisons: list[Comparison]
    seconds: dict[str, float]
    spin: LawAccuracy | None = None


def generate(
    config: Config,
    output: str | Path,
    *,
    resume: bool = False,
    discard: bool = False,
    executor: Executor | None = None,
    conditions: int = GENERATE_CONDITIONS,
    samples: int | None = None,
    progress: bool = False,
    on_cost: Callable[[Cost], None] | None = None,
) -> Generated:
    """Generate a table and write it.

    Checkpoints stay in ``OUTPUT.parts`` until the table is complete, so that an interrupted run can
    be resumed. The bytes of the table depend on the configuration and the software alone, but for
    last digits, which may differ between kinds of processor.

    Parameters
    ----------
    config : Config
    output : str or Path
        The .h5 file; it appears when it is complete.
    resume : bool
        Use the checkpoints of an interrupted run, if there are any.
    discard : bool
        Remove them. With neither, they are refused.
    executor : concurrent.futures.Executor, optional
        Runs the tasks; by default one thread per processor.
    conditions : int
        Number of conditions between the nodes at which the accuracy is measured and stored.
    samples : int, optional
        States a side there; by default as many as the declared accuracy needs.
    progress : bool
        Show progress bars on standard error.
    on_cost : callable, optional
        Is called with the estimated cost, when one node has been fitted.

    Returns
    -------
    Generated

    Raises
    ------
    InputError
        If the output cannot be written, its checkpoints cannot be used, or a reader would refuse
        the table (`tablegen.tables.rehearsal`).
    """
    as_integer("conditions", conditions, 0, 2**63 - 1, "0 or more")
    if samples is not None:
        as_integer("samples", samples, 1000, 2**63 - 1, "1000 or more")
    if config.spin and config.domain.omega != "mean":
        allowed = "'mean' with spin = true, because a spin is given back at the next wall"
        refuse("domain.omega", repr(config.domain.omega), allowed)
    path = check_output(output)
    if config.population.only_spheres:
        contents = sphere_contents(config)
        write_table(path, contents)
        return Generated(Table(contents), [], {})
    fingerprint = f"{software()}\n{config.text}"
    with CheckpointStore(path, fingerprint, resume=resume, discard=discard) as store:
        runner = TaskRunner(store, executor, progress)
        if not store.resumed:
            rehearse(config)
        cache = NodeCache(config, runner)
        if on_cost is not None:
            on_cost(estimate(cache, conditions))
        refined = refine_grid(cache)
        law = spin_law(config, runner) if config.spin else None
        axes = make_axes(config, refined.placement.grid)
        contents = with_rounded_quantiles(assemble(config, axes, refined.nodes, law))
        table = Table(contents)
        begin = time.perf_counter()
        how: Any = {"seed": _MEASURE_SEED, "samples": samples, "progress": progress}
        places = pick_conditions(table, conditions, _MEASURE_SEED)
        comparisons = measure(table, config, places, **how)
        measured = accuracy_datasets(comparisons, len(contents.variables))
        spin = None
        if contents.has_spin and conditions > 0:
            own = pick_own_conditions(table, conditions, _MEASURE_SEED)
            spin = measure_spin(table, config, own, **how)
            measured |= spin_accuracy_datasets(spin)
        contents = replace(contents, datasets={**contents.datasets, **measured})
        write_table(path, contents)
        store.remove()
    seconds = {**runner.seconds, "measurement": time.perf_counter() - begin}
    return Generated(Table(contents), comparisons, seconds, spin)
