"""``tablegen generate``: a table from a configuration."""

from concurrent.futures import Executor
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from sampler.commands import options
from sampler.commands.program import note
from tablegen.commands.config_argument import CONFIG
from tablegen.commands.resuming import resumable
from tablegen.commands.validate import print_verdict
from tablegen.config.defaults import GENERATE_CONDITIONS
from tablegen.tasks.executors import ENGINES, MPI, THREADS

if TYPE_CHECKING:
    from tablegen.config.config import Config
    from tablegen.tables.generate import Generated


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
    type=click.Choice(ENGINES),
    default=THREADS,
    show_default=True,
    help="Who does the pieces. dask: a cluster. mpi: all ranks of mpiexec but the first.",
)
@click.option(
    "--scheduler",
    metavar="ADDRESS",
    help="A running Dask scheduler; without one, dask starts processes on this machine.",
)
@click.option(
    "--workers",
    type=options.THREADS,
    help="Threads, or processes of Dask on this machine; by default one a processor.",
)
@options.progress
@click.pass_obj
def generate(
    ranks: Executor | None,
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

    Unless it is --quiet, it says beforehand what the table will cost: nodes, minutes and memory.
    Small tables take seconds, the shipped pair to the standard accuracy 10 to 30 minutes on two
    processors. The bars show the time that is left of a stage.

    Nodes are placed where the error between them, measured against direct simulation, is too
    large for the accuracy that the configuration asks for. Finished pieces are kept in T.h5.parts
    until the table is complete, and belong to one run at a time. If an interrupted run left some,
    say what becomes of them: --resume or --discard. The table has the same bytes whoever does the
    pieces, on processors of one kind; made on several kinds it says so. The measured accuracy is
    stored in it; exit status 1 says that it misses the declared one.
    """
    from sampler.compilation.processors import processors
    from tablegen.config.config import load_config
    from tablegen.tables.cost_estimate import cost_text, estimate, rebound_seconds
    from tablegen.tables.generate import generate as generate_table
    from tablegen.tasks.executors import open_executor

    settings = load_config(config)

    # how many work elsewhere is not known here
    here = workers or processors() if executor != MPI and scheduler is None else None

    def note_cost() -> None:
        if progress:
            cost = estimate(settings, rebound_seconds(settings), conditions)
            note("tablegen", cost_text(cost, here))

    say = partial(note, "tablegen")
    opened = open_executor(executor, workers=workers, scheduler=scheduler, ranks=ranks, say=say)
    with resumable(output), opened as pool:
        made = generate_table(
            settings,
            output,
            resume=resume,
            discard=discard,
            executor=pool,
            conditions=conditions,
            samples=samples,
            progress=progress,
            before=note_cost,
        )
    return _summarise(made, settings, output)


def _summarise(made: "Generated", settings: "Config", output: Path) -> int:
    """Print what a new table is and how accurate; returns the exit status."""
    from tablegen.accuracy.accuracy_text import accuracy_table, law_tables, time_text
    from tablegen.accuracy.decision import judge
    from tablegen.commands.inspect import identity_text, several_processors

    contents = made.table.contents
    if len(contents.processors) > 1:
        note("tablegen", several_processors(contents))
    click.echo(identity_text(contents))
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
