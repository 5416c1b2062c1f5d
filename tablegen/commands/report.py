"""``tablegen report``: its options and its help."""

from pathlib import Path
from typing import Any

import click

from sampler.compilation.late import work
from tablegen.commands import options


@click.command(
    short_help="Measure error against run time beside other methods.",
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
    type=click.Path(path_type=Path),
    metavar="F",
    help="Show this result of 'tablegen stability --json' on the page; else a brief study is run.",
)
@options.progress
def report(**given: Any) -> int:
    """Measure error against run time for every way to get a rebound state.

    Direct simulation by contact resolution, flight tolerance and sample size; draws from the
    table, and from tables of other numbers of nodes, components and knots; stored states,
    independent marginals, a vine copula, a Gaussian mixture and kernel resampling. All are
    compared with the same large direct sample, beside the noise of direct against direct.
    Times are processor time of one thread: leave the machine to it.
    """
    return work("tablegen.commands.report_command", **given)
