"""Make a table: choose sizes and nodes, fit them, measure the accuracy, write the file."""

import time
from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path

from sampler.arguments import as_integer
from sampler.files import check_output
from sampler.formats.hdf5 import write_table
from sampler.table import Table
from tablegen.accuracy.validate import Validation, validate_contents
from tablegen.checkpoints import CheckpointStore, TaskRunner, software
from tablegen.config.config import Config
from tablegen.config.defaults import VALIDATE_CONDITIONS
from tablegen.fitting.spin_law import spin_law
from tablegen.tables.assembly import assemble, with_accuracy, with_rounded_quantiles
from tablegen.tables.axes import make_axes
from tablegen.tables.cost import Cost, estimate
from tablegen.tables.plan import make_plan
from tablegen.tables.refine import NodeCache, refine_grid
from tablegen.tables.rehearsal import rehearse
from tablegen.tables.spheres import sphere_contents

#: Seed of the measurement, other than the default seed of a validation.
_MEASURE_SEED = 0xACC0


@dataclass(frozen=True)
class Generated:
    """A new table and its measured accuracy, from `generate`.

    Attributes
    ----------
    table : Table
        The new table.
    validation : Validation or None
        Comparison with direct simulation, as `tablegen.validate` does it with another seed. None if
        no condition was asked for, or for a table of spheres, which is exact.
    unmet : list of str
        One line for each part of the accuracy that the planned nodes could not reach.
    seconds : float
        Processor time of all threads [s].
    """

    table: Table
    validation: Validation | None
    unmet: list[str]
    seconds: float


def pieces_of(config: Config, output: Path, resume: bool = False) -> CheckpointStore:
    """Open the finished pieces of a table, beside its file."""
    return CheckpointStore(output, f"{software()}\n{config.text}", resume=resume)


def generate(
    config: Config,
    output: str | Path,
    *,
    resume: bool = False,
    executor: Executor | None = None,
    conditions: int = VALIDATE_CONDITIONS,
    samples: int | None = None,
    progress: bool = False,
    on_cost: Callable[[Cost], None] | None = None,
) -> Generated:
    """Make a table, and write its file.

    Finished pieces of the work stay in the folder ``OUTPUT.parts`` until the table is complete, so
    an interrupted run can be resumed.

    Parameters
    ----------
    config : Config
        Configuration, from `tablegen.load_config`.
    output : str or Path
        The .h5 file to write. It appears when it is complete.
    resume : bool, optional
        Whether to use the finished pieces of an interrupted run of the same configuration and
        version. Pieces that are damaged are computed again.
    executor : concurrent.futures.Executor, optional
        Executor that runs the tasks. By default one thread for each processor.
    conditions : int, optional
        Number of conditions between nodes at which the accuracy is measured and stored. With 0
        nothing is measured.
    samples : int, optional
        Number of states at each of these conditions, from the table and from direct simulation
        each, 1000 or more. By default it is as large as the declared accuracy needs.
    progress : bool, optional
        Whether to show progress bars on standard error.
    on_cost : callable, optional
        Function that is called with the estimated cost, after one node has been fitted.

    Returns
    -------
    Generated
        The table and its measured accuracy.

    Raises
    ------
    InputError
        If the output cannot be written, or if a reader would refuse the table
        (`tablegen.tables.rehearsal`).

    Notes
    -----
    The bytes of the table depend on the configuration and the version of the software only. On
    another kind of processor, last digits may differ.

    Examples
    --------
    A table takes minutes, so this example is not run by the tests:

    >>> from tablegen import generate, load_config
    >>> generated = generate(load_config("demo"), "demo.h5")  # doctest: +SKIP
    >>> generated.validation.holds  # doctest: +SKIP
    True
    """
    as_integer("conditions", conditions, 0, 2**63 - 1, "0 or more")
    if samples is not None:
        as_integer("samples", samples, 1000, 2**63 - 1, "1000 or more")
    path = check_output(output)
    if config.population.only_spheres:
        contents = sphere_contents(config)
        write_table(path, contents)
        return Generated(Table(contents), None, [], 0.0)
    store = pieces_of(config, path, resume)
    runner = TaskRunner(store, executor, progress)
    plan, cache = make_plan(config), NodeCache(config, runner)
    rehearse(plan)
    if on_cost is not None:
        on_cost(estimate(plan, cache, store.seconds()))
    refined = refine_grid(plan, cache)
    law = spin_law(config, runner, plan.spin) if config.spin else None
    axes = make_axes(config, refined.placement.grid)
    contents = with_rounded_quantiles(assemble(config, axes, refined.nodes, law))
    begin, validation = time.process_time(), None
    if conditions > 0:
        validation = validate_contents(
            contents,
            config,
            str(path),
            conditions,
            _MEASURE_SEED,
            samples=samples,
            progress=progress,
        )
        contents = with_accuracy(contents, validation)
    write_table(path, contents)
    store.remove()
    seconds = runner.seconds + time.process_time() - begin
    return Generated(Table(contents), validation, refined.missed, seconds)
