"""``tablegen validate``: its options and its help."""

from typing import Any

import click

from sampler.late import work
from tablegen import options
from tablegen.choices import VALIDATE_CONDITIONS


@click.command(
    short_help="Compare a table with fresh direct simulation.",
    epilog=options.examples(
        "tablegen validate corundum-steel",
        "tablegen validate my-pair.h5 --conditions 20 --seed 3 --json accuracy.json",
    ),
)
@click.argument("table", type=options.TABLE, metavar="T.h5")
@click.option(
    "--conditions",
    type=options.Whole(1, 10_000),
    default=VALIDATE_CONDITIONS,
    show_default=True,
    help="Conditions between nodes to compare at.",
)
@options.seed("Seed of the conditions and of both samples.")
@click.option(
    "--samples",
    type=options.Whole(1000, 10**9),
    help="States a side; by default as many as the declared accuracy needs, at least 100000.",
)
@options.json_file("Write every number.")
@options.html_file
@click.option("--details", is_flag=True, help="Means and modes at every condition.")
@options.progress
def validate(**given: Any) -> int:
    """Compare a table with fresh direct simulation at conditions that are not nodes.

    KS: largest Kolmogorov-Smirnov distance of a component. Sliced W: sliced Wasserstein distance
    of the standardised states. Corr.: largest error of a correlation. AUC: how well a classifier
    tells table from direct; 0.5 = it cannot. Exit status 1 if a declared accuracy is missed.
    """
    return work("tablegen.validate_command", **given)
