"""``tablegen generate``: a table from a configuration, from the command line."""

from concurrent.futures import Executor
from pathlib import Path

import click

from tablegen.config import load_config
from tablegen.decision import judge
from tablegen.executors import open_executor
from tablegen.generate import generate as generate_table
from tablegen.identity import identity_text
from tablegen.summary import accuracy_text, time_text
from tablegen.verdict import verdict


def run(
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
    """Run ``tablegen generate``; parameters are the options of `tablegen.commands.generate`."""
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
    click.echo(identity_text(made.table.contents))
    click.echo(accuracy_text(made.comparisons, settings.accuracy))
    click.echo(f"{output}: {output.stat().st_size / 1e6:.2f} MB; {time_text(made.seconds)}")
    judged = judge(made.comparisons, settings.accuracy)
    return verdict(judged.missed, judged.undecided)
