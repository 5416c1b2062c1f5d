"""``tablegen generate``: its options and its help."""

from concurrent.futures import Executor
from typing import Any

import click

from sampler.compilation.late import work
from tablegen.commands import options
from tablegen.configuration.defaults import GENERATE_CONDITIONS
from tablegen.tasks.executors import ENGINES, THREADS


@click.command(
    short_help="Make a table of a material pair or scene.",
    epilog=options.examples(
        "tablegen generate corundum-steel --output corundum-steel.h5",
        "tablegen generate my-pair.toml --output my-pair.h5 --resume",
        "tablegen generate my-pair.toml --output my-pair.h5 --executor dask \\",
        "    --scheduler tcp://head:8786",
        "mpiexec -n 64 tablegen generate my-pair.toml --output my-pair.h5 --executor mpi",
    ),
)
@click.argument("config", type=options.CONFIG, metavar="CONFIG.toml")
@click.option(
    "--output", required=True, type=options.OUTPUT, metavar="T.h5", help="Table to write."
)
@click.option("--resume", is_flag=True, help="Use the finished pieces of an interrupted run.")
@click.option(
    "--conditions",
    type=options.Whole(1, 10_000),
    default=GENERATE_CONDITIONS,
    show_default=True,
    help="Conditions between nodes at which the accuracy is measured and stored.",
)
@click.option(
    "--samples",
    type=options.Whole(1000, 10**9),
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
    type=options.Whole(1, 4096),
    help="Threads, or processes of Dask on this machine; by default one a processor.",
)
@options.progress
@click.pass_obj
def generate(ranks: Executor | None, **given: Any) -> int:
    """Generate a table from a material pair or scene (a name, or the path of a .toml file).

    Unless it is --quiet, it says beforehand what the table will cost: nodes, minutes and memory.
    Small tables take seconds, the shipped pair to the standard accuracy 10 to 30 minutes on two
    processors. The bars show the time that is left of a stage.

    Nodes are placed where the error between them, measured against direct simulation, is too
    large for the accuracy that the configuration asks for. Finished pieces are kept in T.h5.parts
    until the table is complete. The table has the same bytes whoever does the pieces, on processors
    of one kind; made on several kinds it says so. The measured accuracy is stored in it; exit
    status 1 says that it misses the declared one.
    """
    return work("tablegen.commands.generate_command", ranks, **given)
