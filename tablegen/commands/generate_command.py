"""``tablegen generate``: a table from a configuration, from the command line."""

from concurrent.futures import Executor
from pathlib import Path

import click

from sampler.compilation.processors import processors
from tablegen.accuracy.decision import judge
from tablegen.accuracy.verdict import verdict
from tablegen.commands.table_identity import identity_text, several_processors
from tablegen.config import load_config
from tablegen.generate import generate as generate_table
from tablegen.refinement.cost_estimate import cost_text, estimate, rebound_seconds
from tablegen.studies.validation.accuracy_text import accuracy_text, time_text
from tablegen.tasks.executors import MPI, open_executor


def run(
    ranks: Executor | None,
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
    """Run ``tablegen generate``; parameters are the options of `tablegen.commands.generate`."""
    settings = load_config(config)

    def say(line: str) -> None:
        click.echo(f"tablegen: note: {line}", err=True)

    def tell_cost() -> None:
        if not progress:
            return
        # how many work elsewhere is not known here
        here = executor != MPI and scheduler is None
        cost = estimate(settings, rebound_seconds(settings), conditions)
        say(cost_text(cost, workers or processors() if here else None))

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
                samples=samples,
                progress=progress,
                before=tell_cost,
            )
    except KeyboardInterrupt:
        raise click.Abort(f"the same command with --resume continues from {output}.parts") from None
    contents = made.table.contents
    if len(contents.processors) > 1:
        say(several_processors(contents))
    click.echo(identity_text(contents))
    click.echo(accuracy_text(made.comparisons, settings.accuracy))
    click.echo(f"{output}: {output.stat().st_size / 1e6:.2f} MB; {time_text(made.seconds)}")
    judged = judge(made.comparisons, settings.accuracy)
    return verdict(judged.missed, judged.undecided)
