"""``tablegen generate``: a table from a configuration."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

from sampler import options
from sampler.options import DONE, note
from tablegen.commands.shared import CONFIG
from tablegen.commands.validate import print_spheres, print_verdict
from tablegen.config.defaults import GENERATE_CONDITIONS

if TYPE_CHECKING:
    from tablegen.config.config import Config
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
@options.output("T.h5", "Table to write.")
@click.option("--resume", is_flag=True, help="Use the finished pieces of an interrupted run.")
@click.option("--discard", is_flag=True, help="Remove the finished pieces of an interrupted run.")
@click.option(
    "--conditions",
    type=options.CONDITIONS,
    default=GENERATE_CONDITIONS,
    show_default=True,
    help="Conditions between nodes at which the accuracy is measured and stored.",
)
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

    Unless it is --quiet, it estimates the cost first: nodes and minutes. Small tables take
    seconds, the shipped pair to the standard accuracy 10 to 30 minutes on two processors. The bars
    show the remaining time of a stage.

    Nodes are placed where the error between them, measured against direct simulation, is too
    large for the accuracy that the configuration asks for. Finished pieces are kept in T.h5.parts
    until the table is complete; after an interrupted run, choose --resume or --discard. The table
    has the same bytes whatever the executor. The measured accuracy is stored in it; exit status 1
    says that it misses the declared one.
    """
    from sampler.library import processors
    from tablegen.config.config import load_config
    from tablegen.tables import executors
    from tablegen.tables.cost import Cost, cost_text
    from tablegen.tables.generate import generate as generate_table

    # the number of workers elsewhere is not known here
    here = workers or processors() if executor != executors.MPI and scheduler is None else None

    def say_cost(cost: Cost) -> None:
        note("tablegen", cost_text(cost, here))

    opened = executors.open_executor(executor, workers=workers, scheduler=scheduler)
    with resumable(output), opened as pool:
        if pool is None:  # another rank than the first, whose work is done
            return DONE
        settings = load_config(config)
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
    return _summarise(made, settings, output)


def _summarise(made: "Generated", settings: "Config", output: Path) -> int:
    """Describe a new table and its accuracy; returns the exit status."""
    from tablegen.accuracy.accuracy_text import accuracy_table, law_tables, time_text
    from tablegen.accuracy.decision import judge
    from tablegen.commands.inspect import identity_text

    click.echo(identity_text(made.table.contents))
    if made.table.contents.of_spheres:
        return print_spheres(made.table.contents, settings.table.seed)
    click.echo(accuracy_table(made.comparisons, settings.accuracy))
    click.echo(f"{output}: {output.stat().st_size / 1e6:.2f} MB; {time_text(made.seconds)}")
    together = len(made.comparisons) + (made.spin.count if made.spin else 0)
    judged = judge(made.comparisons, settings.accuracy, together)
    if made.spin is None:
        return print_verdict(judged.missed, judged.undecided)
    for table in law_tables(made.spin, settings.spin_targets, None, together):
        click.echo(table)
    of_spin = made.spin.judged(settings.spin_targets, together)
    return print_verdict(judged.missed + of_spin.missed, judged.undecided + of_spin.undecided)
