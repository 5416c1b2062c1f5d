"""``tablegen generate``: make a table from a configuration."""

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
    """If Ctrl-C interrupts the block and finished pieces exist, say that ``--resume`` uses them."""
    from tablegen.checkpoints import parts_path

    try:
        yield
    except KeyboardInterrupt:
        parts = parts_path(output)
        if not parts.exists():
            raise
        raise click.Abort(
            f"to continue from {parts}, give the same command with --resume"
        ) from None


@click.command(
    cls=options.Command,
    short_help="Make a table for a material pair or scene.",
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
@click.option(
    "--resume", is_flag=True, help="Continue an interrupted run from its finished pieces."
)
@shared.conditions(
    "Number of conditions between nodes at which the accuracy is measured and stored."
)
@click.option(
    "--samples",
    type=options.SAMPLES,
    help="Number of states from the table, and of simulated ones, at each of these conditions; by "
    "default as many as the declared accuracy needs.",
)
@click.option(
    "--executor",
    type=click.Choice(["threads", "dask", "mpi"]),
    default="threads",
    show_default=True,
    help="What does the work: threads of this process, a Dask cluster, or all ranks of mpiexec but "
    "the first.",
)
@click.option(
    "--scheduler",
    metavar="ADDRESS",
    help="Address of a running Dask scheduler; without it, Dask starts processes on this machine.",
)
@click.option(
    "--workers",
    type=options.THREADS,
    help="Number of threads, or of Dask processes on this machine; by default one for each "
    "processor.",
)
@options.progress
def generate(
    config: str,
    output: Path,
    resume: bool,
    conditions: int,
    samples: int | None,
    executor: str,
    scheduler: str | None,
    workers: int | None,
    progress: bool,
) -> int:
    """Make a table for a material pair or scene (a name, or the path of a .toml file).

    First the command says which particles are simulated, and estimates the cost: nodes, and minutes
    of one processor. The minutes are those of one node and of one leaf of the spin law, times their
    numbers. Progress bars show the remaining time of each stage, and where the error is largest.
    With --quiet, the command says none of this.

    The command adds nodes where the table differs from direct simulation by more than the accuracy
    that the configuration declares. It keeps finished pieces in T.h5.parts until the table is
    complete. If a run was interrupted, --resume uses the pieces of this configuration and version.
    All executors make the same table, bit by bit.

    At the end the table is validated, and the distances are stored in it. If the declared accuracy
    is missed, the exit status is 1, and a line says what to do.
    """
    from sampler.library import processors
    from tablegen.config.config import load_config
    from tablegen.tables import executors
    from tablegen.tables.cost import Cost, cost_text, spent_text
    from tablegen.tables.generate import generate as generate_table
    from tablegen.tables.generate import pieces_of

    costs: list[Cost] = []

    # With MPI or a running Dask scheduler, the number of workers is not known here.
    here = workers or processors() if executor != executors.MPI and scheduler is None else None

    def print_cost(cost: Cost) -> None:
        costs.append(cost)
        note("tablegen", cost_text(cost, here))

    opened = executors.open_executor(executor, workers=workers, scheduler=scheduler)
    with resumable(output), opened as pool:
        if pool is None:  # This MPI rank was a worker, and its work is done.
            return DONE
        settings = load_config(config)
        lines = [f"particles: {settings.population}", *settings.doubts()]
        store = pieces_of(settings, output)
        if store.pieces() and not resume:
            lines.append(f"{store.folder} has pieces of this table; --resume would use them")
        elif resume and not store.pieces():
            lines.append(f"{store.folder} has no piece of this configuration and version")
        for line in lines if progress else ():
            note("tablegen", line)
        generated = generate_table(
            settings,
            output,
            resume=resume,
            executor=pool,
            conditions=conditions,
            samples=samples,
            progress=progress,
            on_cost=print_cost if progress else None,
        )
    # The processor time of this process includes its start and its threads. It does not include
    # workers in other processes, whose seconds come with the table.
    spent = time.process_time()
    if executor != executors.THREADS:
        spent = max(spent, generated.seconds)
    click.echo(f"{output}: {output.stat().st_size / 1e6:.2f} MB, {spent_text(spent, *costs)}")
    return _summarise(output, generated)


def _summarise(output: Path, generated: "Generated") -> int:
    """Print a description of a new table and its accuracy, and return the exit status."""
    from sampler.formats.hdf5 import read_table
    from tablegen.commands.inspect import identity_text

    contents = read_table(output)
    click.echo(identity_text(contents))
    if contents.of_spheres:
        return print_spheres(contents, contents.seed)
    for line in generated.unmet:
        note("tablegen", line)
    if generated.validation is None:
        return DONE
    print_validation(generated.validation)
    return DONE if generated.validation.holds else MISSED
