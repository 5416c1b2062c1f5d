"""``tablegen report``: error against run time."""

from pathlib import Path

import click

from sampler import options
from sampler.files import json_text, write_bytes, write_text
from sampler.options import DONE
from tablegen.commands import shared


@click.command(
    cls=options.Command,
    short_help="Measure error against run time, of tables and of direct simulation.",
    epilog=options.examples(
        "tablegen report --quick",
        "tablegen report my-pair.h5 --json report.json --picture report.png",
        "tablegen report --beside corundum-steel-compact --beside fine.h5 --picture report.pdf",
    ),
)
@click.argument("table", type=options.TABLE, metavar="[T.h5]", default="corundum-steel")
@click.option("--quick", is_flag=True, help="Measure less; this takes half a minute on two cores.")
@click.option(
    "--beside",
    type=options.TABLE,
    multiple=True,
    metavar="T.h5",
    help="Another table of the same pair to compare; may be given several times.",
)
@options.seed("Seed of all samples.")
@options.json_file("Write all numbers to this JSON file.")
@shared.picture("Draw two errors against the run time, at the worst condition of the table.")
@options.overwrite
@options.progress
def report(
    table: str,
    quick: bool,
    beside: tuple[str, ...],
    seed: int,
    json_file: Path | None,
    picture: Path | None,
    progress: bool,
) -> int:
    """Measure error against run time for draws from tables and for direct simulation.

    Direct simulation runs at several contact resolutions and flight tolerances. Each way is
    compared with the same large sample of direct simulation. The difference between two samples of
    direct simulation shows how much chance alone gives. Rebounds of spinning particles are timed,
    and compared along chains of sixty hits.

    Times are processor times of one thread, so do not run other programs meanwhile. The command
    takes up to three minutes on two cores. tablegen validate compares a table over its whole range.
    """
    from tablegen.evidence.report import measure_report, report_picture, report_text

    measured = measure_report(table, beside, quick=quick, seed=seed, progress=progress)
    if json_file:
        write_text(json_file, json_text(measured.to_dict()))
    if picture:
        write_bytes(picture, report_picture(measured, picture.name))
    click.echo(report_text(measured))
    return DONE
