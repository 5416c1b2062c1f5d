"""``tablegen report``: error against run time."""

from pathlib import Path

import click

from sampler import options
from sampler.files import json_text, write_text
from sampler.options import DONE


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
@click.option("--quick", is_flag=True, help="Measure less: under two minutes on two cores.")
@click.option(
    "--beside",
    type=options.TABLE,
    multiple=True,
    metavar="T.h5",
    help="A further table of the same pair to compare; may be given several times.",
)
@options.seed("Seed of every sample.")
@options.json_file("Write every number.")
@options.html_file
@click.option(
    "--stability",
    "stability_file",
    type=options.INPUT,
    metavar="F",
    help="Show this result of 'tablegen stability --json' on the page; else a brief study is run.",
)
@options.progress
def report(
    table: str,
    quick: bool,
    beside: tuple[str, ...],
    seed: int,
    json_file: Path | None,
    html_file: Path | None,
    stability_file: Path | None,
    progress: bool,
) -> int:
    """Measure error against run time for every way to get a rebound state.

    Direct simulation by contact resolution, flight tolerance and sample size; draws from the
    table, and from tables of other numbers of nodes, mixture components and knots; stored states,
    independent marginals, a vine copula, a Gaussian mixture and kernel resampling. All are
    compared with the same large direct sample, next to the noise of direct against direct.
    Times are processor time of one thread: leave the machine to it.
    """
    from tablegen.evidence.error_against_time import measure_error_against_time
    from tablegen.evidence.report_data import collect_report_data, map_accuracy, record
    from tablegen.evidence.report_page import report_page, require_plotly
    from tablegen.evidence.report_text import error_against_time_text
    from tablegen.evidence.stability_results import read_study

    if html_file:
        # what is missing shows before the work, not after
        require_plotly()
    if stability_file:
        read_study(stability_file)
    evidence = measure_error_against_time(table, beside, quick=quick, seed=seed, progress=progress)
    click.echo(error_against_time_text(evidence))
    if json_file is None and html_file is None:
        return DONE
    atlas = map_accuracy(table, quick, seed, progress)
    if json_file:
        write_text(json_file, json_text(record(evidence, atlas)))
    if html_file:
        page = report_page(collect_report_data(evidence, atlas, stability_file, progress))
        write_text(html_file, page)
        click.echo(f"{html_file}: {len(page.encode()) / 1e6:.1f} MB")
    return DONE
