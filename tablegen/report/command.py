"""``tablegen report``: the evidence from the command line."""

import json
import sys
from pathlib import Path

import click

from sampler.atomic import atomic_output
from tablegen import options
from tablegen.report.study import gather_evidence
from tablegen.report.text import evidence_text


def _write(path: Path, text: str) -> None:
    with atomic_output(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


@click.command(
    epilog=options.examples(
        "tablegen report --quick",
        "tablegen report my-pair.h5 --json report.json --html report.html",
    )
)
@click.argument("table", metavar="[T.h5]", default="corundum-steel")
@click.option("--quick", is_flag=True, help="Measure less: under two minutes on two cores.")
@click.option("--seed", type=options.SEED, default=1, show_default=True, metavar="S")
@click.option("--json", "json_file", type=options.OUTPUT, metavar="F", help="Write every number.")
@click.option("--html", "html_file", type=options.OUTPUT, metavar="F", help="Write a page.")
@click.option("--quiet", is_flag=True, help="No progress bars.")
def report(
    table: str,
    quick: bool,
    seed: int,
    json_file: Path | None,
    html_file: Path | None,
    quiet: bool,
) -> int:
    """Measure error against run time for every way to get a rebound state.

    Direct simulation by contact resolution, flight tolerance and sample size; draws from the
    table, and from tables of other numbers of nodes, components and knots; stored states,
    independent marginals, a vine copula, a Gaussian mixture and kernel resampling. All are
    compared with the same large direct sample, beside the noise of direct against direct.
    Times are processor time of one thread: leave the machine to it.
    """
    progress = not quiet and sys.stderr.isatty()
    evidence = gather_evidence(table, quick=quick, seed=seed, progress=progress)
    click.echo(evidence_text(evidence))
    if json_file:
        _write(json_file, json.dumps(evidence.to_dict(), indent=1, allow_nan=False) + "\n")
    return 0
