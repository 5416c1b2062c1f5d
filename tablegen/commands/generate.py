"""``tablegen generate``: a table from a configuration."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

from sampler import options
from sampler.options import DONE, MISSED, note
from tablegen.commands import shared
from tablegen.commands.shared import CONFIG
from tablegen.commands.validate import print_spheres, print_validation

if TYPE_CHECKING:
    from tablegen.tables.generate import Generated


@contextmanager
def resumable(output: Path) -> Iterator[None]:
    """Name ``--resume`` when Ctrl-C interrupts the block and there are checkpoints."""
    from tablegen.checkpoints import parts_path

    try:
        yield
    except KeyboardInterrupt:
        kept = parts_path(output)
        if not kept.exists():
            raise
        raise click.Abort(f"the same command with --resume continues from {kept}") from None


@click.command(
    cls=options.Command,
    short_help="Make a table of a material pair or scene.",
    epilog=options.examples(
        "tablegen generate corundum-steel --output corundum-steel.h5",
        "tablegen generate my-pair.toml --output my-pair.h5 --resume",
        "tablegen generate my-pair.toml --output my-pair.h5 --executor dask \\",
        "    --scheduler tcp://head:8786",
        "mpiexec -n 64 tablegen generate my-pair.toml --output my-pair.h5 --executor mpi",
    ),
)
@click.argument("config", type=CONFIG, metavar="CONFIG.toml")
@options.output("T.h5", ".h5", help_text="Table to write.")
@options.overwrite
@click.option("--resume", is_flag=True, help="Use the finished pieces of an interrupted run.")
@click.option("--discard", is_flag=True, help="Remove the finished pieces of an interrupted run.")
@shared.conditions("Conditions between nodes at which the accuracy is measured and stored.")
@click.option(
    "--samples",
    type=options.SAMPLES,
    help="States a side there; by default as many as the declared accuracy needs.",
)
@click.option(
    "--executor",
    type=click.Choice(["threads", "dask", "mpi"]),
    default="threads",
    show_default=True,
    help="Workers: threads, a Dask cluster, or all ranks of mpiexec but the first.",
)
@click.option(
    "--scheduler",
    metavar="ADDRESS",
    help="A running Dask scheduler; without one, dask starts processes on this machine.",
)
@click.option(
    "--workers",
    type=options.THREADS,
    help="Threads, or processes of Dask on this machine; by default one per processor.",
)
@options.progress
def generate(
    config: str,
    output: Path,
    resume: bool,
    discard: bool,
    conditions: int,
    samples: int | None,
    executor: str,
    scheduler: str | None,
    workers: int | None,
    progress: bool,
) -> int:
    """Generate a table from a material pair or scene (a name, or the path of a .toml file).

    Unless it is --quiet, it first says what the table is of and estimates the cost: nodes, minutes
    of one processor, and disk space. The minutes are extrapolated from one node, and may be off by
    half where other programs share the processor. The bars show the remaining time of a stage, and
    where the error is largest.

    Nodes are placed where the error between them, measured against direct simulation, is too
    large for the accuracy that the configuration asks for. Finished pieces are kept in T.h5.parts
    until the table is complete; after an interrupted run, choose --resume or --discard. The table
    has the same bytes whatever the executor. It ends with a validation, whose distances are stored
    in the table; exit status 1 says that the declared accuracy is missed; a line says what to do.
    """
    from sampler.library import processors
    from tablegen.config.config import load_config
    from tablegen.tables import executors
    from tablegen.tables.cost import Cost, cost_text, spent_text
    from tablegen.tables.generate import generate as generate_table

    quoted: list[Cost] = []

    # the number of workers elsewhere is not known here
    here = workers or processors() if executor != executors.MPI and scheduler is None else None

    def say_cost(cost: Cost) -> None:
        quoted.append(cost)
        note("tablegen", cost_text(cost, here))

    opened = executors.open_executor(executor, workers=workers, scheduler=scheduler)
    with resumable(output), opened as pool:
        if pool is None:  # another rank than the first, whose work is done
            return DONE
        settings = load_config(config)
        for line in [f"particles: {settings.population}", *settings.doubts()] if progress else ():
            note("tablegen", line)
        made = generate_table(
            settings,
            output,
            resume=resume,
            discard=discard,
            executor=pool,
            conditions=conditions,
            samples=samples,
            progress=progress,
            on_cost=say_cost if progress else None,
        )
    spent = time.process_time()  # of this program, from its start
    if executor != executors.THREADS:
        spent = max(spent, made.seconds)
    click.echo(f"{output}: {output.stat().st_size / 1e6:.2f} MB, {spent_text(spent, *quoted)}")
    return _summarise(made)


def _summarise(made: "Generated") -> int:
    """Describe a new table and its accuracy; returns the exit status."""
    from tablegen.commands.inspect import identity_text

    click.echo(identity_text(made.table.contents))
    if made.table.contents.of_spheres:
        return print_spheres(made.table.contents, made.table.contents.seed)
    for line in made.unmet:
        note("tablegen", line)
    if made.validation is None:
        return DONE
    print_validation(made.validation)
    return DONE if made.validation.holds else MISSED
