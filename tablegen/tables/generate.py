"""Make a table: choose sizes and nodes, fit them, measure the accuracy, write the file."""

import time
from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from sampler.files.atomic import check_output
from sampler.formats.hdf5 import write_table
from sampler.inputs.rows import as_integer
from sampler.table import Table
from tablegen.accuracy.comparison import Comparison
from tablegen.accuracy.conditions import (
    pick_conditions,
    pick_spin_conditions,
    spin_conditions_beside,
)
from tablegen.accuracy.measure import LawAccuracy, measure, measure_spin, spin_accuracy_datasets
from tablegen.config.config import Config
from tablegen.config.defaults import GENERATE_CONDITIONS
from tablegen.fitting.spin_law import spin_law
from tablegen.tables.assembly import accuracy_datasets, assemble, with_rounded_quantiles
from tablegen.tables.axes import make_axes
from tablegen.tables.refine import refine_grid
from tablegen.tables.rehearsal import rehearse
from tablegen.tasks.checkpoint import CheckpointStore
from tablegen.tasks.processor_kind import processor_kind
from tablegen.tasks.runner import TaskRunner
from tablegen.tasks.software import software

#: Seed of the measurement: not one that a user's validation has by default.
_MEASURE_SEED = 0xACC0


@dataclass(frozen=True)
class Generated:
    """A new table and its measured accuracy.

    Attributes
    ----------
    table : Table
    comparisons : list of Comparison
        At conditions between nodes that played no part in placing them.
    spin : LawAccuracy or None
        The same of the spin law, if the table has one.
    seconds : dict
        Spent on simulation, fit and check of nodes by all workers together, and on the
        measurement of the whole table.
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
    before: Callable[[], None] = lambda: None,
) -> Generated:
    """Generate a table and write it.

    Checkpoints of nodes and trials stay in ``OUTPUT.parts`` until the table is complete, so that an
    interrupted run can be resumed. The bytes of the table depend on the configuration, the versions
    of the software and the kind of processor. The kinds that took part are written into it; if
    there are several, another run may differ from it in last digits.

    Parameters
    ----------
    config : Config
    output : str or Path
        The .h5 file; it appears when it is complete.
    resume : bool
        Use the checkpoints of an interrupted run, if there are any.
    discard : bool
        Remove the checkpoints of an interrupted run, if there are any. With neither, they are
        refused.
    executor : concurrent.futures.Executor, optional
        Runs the tasks; by default one thread a processor.
    conditions : int
        Number of conditions between the nodes at which the accuracy is measured and stored. A spin
        law is measured at three times as many, at most 24.
    samples : int, optional
        States a side there at first; by default as many as the declared accuracy needs.
    progress : bool
        Show progress bars on standard error.
    before : callable
        Called after all checks, before any work is done.

    Returns
    -------
    Generated

    Raises
    ------
    InputError
        If the output cannot be written, another run is making it, or there are checkpoints that
        nothing was said of, or that are those of another configuration; or if the finished table
        would be refused, which `tablegen.tables.rehearsal` finds out before any work.
    """
    as_integer("conditions", conditions, 0, 2**63 - 1, "0 or more")
    if samples is not None:
        as_integer("samples", samples, 1000, 2**63 - 1, "1000 or more")
    path = check_output(output)
    fingerprint = f"{software()}\n{config.text}"
    with CheckpointStore(path, fingerprint, resume=resume, discard=discard) as store:
        runner = TaskRunner(store, executor, progress)
        if not store.resumed:
            rehearse(config, store.rehearsal)
        before()
        refined = refine_grid(config, runner)
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
            few = spin_conditions_beside(conditions)
            spinning = pick_spin_conditions(config, few, _MEASURE_SEED)
            spin = measure_spin(table, config, spinning, **how)
            measured |= spin_accuracy_datasets(spin)
        contents = replace(
            contents,
            datasets={**contents.datasets, **measured},
            processors=tuple(sorted(runner.processors | {processor_kind()})),
        )
        write_table(path, contents)
        store.remove()
    seconds = {**runner.seconds, "measurement": time.perf_counter() - begin}
    return Generated(Table(contents), comparisons, seconds, spin)
