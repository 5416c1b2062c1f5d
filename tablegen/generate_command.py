"""``tablegen generate``: a table from a configuration, from the command line."""

from concurrent.futures import Executor
from pathlib import Path

import click

from tablegen import options
from tablegen.config import load_config
from tablegen.decision import judge
from tablegen.executors import ENGINES, THREADS, open_executor
from tablegen.generate import CONDITIONS
from tablegen.generate import generate as generate_table
from tablegen.summary import accuracy_text, identity_text, time_text
from tablegen.verdict import verdict


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
@click.argument("config", metavar="CONFIG.toml")
@click.option(
    "--output", required=True, type=options.OUTPUT, metavar="T.h5", help="Table to write."
)
@click.option("--resume", is_flag=True, help="Use the finished pieces of an interrupted run.")
@click.option(
    "--conditions",
    type=options.Whole(1, 10_000),
    default=CONDITIONS,
    show_default=True,
    help="Conditions between nodes at which the accuracy is measured and stored.",
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
def generate(
    ranks: Executor | None,
    config: str,
    output: Path,
    resume: bool,
    conditions: int,
    executor: str,
    scheduler: str | None,
    workers: int | None,
    progress: bool,
) -> int:
    """Generate a table from a material pair or scene (a name, or the path of a .toml file).

    Nodes are placed where the error between them, measured against direct simulation, is too
    large for the accuracy that the configuration asks for. Finished pieces are kept in T.h5.parts
    until the table is complete. The table has the same bytes whoever does the pieces. The measured
    accuracy is stored in it; exit status 1 says that it misses the declared one.
    """
    settings = load_config(config)

    def say(line: str) -> None:
        click.echo(f"tablegen: note: {line}", err=True)

    try:
        with open_executor(
            executor, workers=workers, scheduler=scheduler, ranks=ranks, say=say
        ) as pool:
            made = generate_table(
                settings,
                output,
                resume=resume,
                executor=pool,
                conditions=conditions,
                progress=progress,
            )
    except KeyboardInterrupt:
        raise click.Abort(f"the same command with --resume continues from {output}.parts") from None
    click.echo(identity_text(made.table))
    click.echo(accuracy_text(made.comparisons, settings.accuracy))
    click.echo(f"{output}: {output.stat().st_size / 1e6:.2f} MB; {time_text(made.seconds)}")
    judged = judge(made.comparisons, settings.accuracy)
    return verdict(judged.missed, judged.undecided)
