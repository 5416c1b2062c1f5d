"""``tablegen report``: error against run time."""

from pathlib import Path

import click

from sampler import options
from sampler.files import json_text, write_bytes, write_text
from sampler.options import DONE
from tablegen.commands import shared


@click.command(
    cls=options.Command,
    short_help="Measure error against run time next to other methods.",
    epilog=options.examples(
        "tablegen report --quick",
        "tablegen report my-pair.h5 --json report.json --html report.html",
        "tablegen report --beside corundum-steel-compact --beside fine.h5 --html report.html",
    ),
)
@click.argument("table", type=options.TABLE, metavar="[T.h5]", default="corundum-steel")
@click.option("--quick", is_flag=True, help="Measure less; this takes about a minute on two cores.")
@click.option(
    "--beside",
    type=options.TABLE,
    multiple=True,
    metavar="T.h5",
    help="Another table of the same pair to compare; may be given several times.",
)
@options.seed("Seed of all samples.")
@options.json_file("Write all numbers to this JSON file.")
@options.html_file
@shared.picture("Draw two errors against the run time, at the worst condition of the table.")
@options.overwrite
@options.progress
def report(
    table: str,
    quick: bool,
    beside: tuple[str, ...],
    seed: int,
    json_file: Path | None,
    html_file: Path | None,
    picture: Path | None,
    progress: bool,
) -> int:
    """Measure error against run time for every way to get a rebound state.

    The ways are direct simulation at several contact resolutions and flight tolerances, draws from
    the table, stored states, independent marginals, a Gaussian mixture, and kernel resampling. Each
    is compared with the same large sample of direct simulation. The difference between two samples
    of direct simulation shows how much chance alone gives. The table is also compared over its
    whole range, and along chains of sixty hits.

    Times are processor times of one thread, so do not run other programs meanwhile. The command
    takes up to five minutes on two cores.
    """
    from tablegen.evidence.page import render_text
    from tablegen.evidence.report import measure_report
    from tablegen.evidence.report_page import report_page, report_picture, report_sections
    from tablegen.presentation import require_matplotlib

    if html_file:  # refuse before the work
        require_matplotlib("--html")
    measured = measure_report(table, beside, quick=quick, seed=seed, progress=progress)
    if json_file:
        write_text(json_file, json_text(measured.to_dict()))
    if picture:
        write_bytes(picture, report_picture(measured, picture.name).data)
    if html_file:
        page = report_page(measured)
        write_text(html_file, page)
    click.echo(render_text(report_sections(measured)))
    if html_file:
        click.echo(f"{html_file}: {len(page.encode()) / 1e6:.1f} MB")
    return DONE
