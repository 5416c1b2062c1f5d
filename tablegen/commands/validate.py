"""``tablegen validate``: its options and its help."""

from typing import Any

import click

from sampler.compilation.late import work
from tablegen.commands import options
from tablegen.configuration.defaults import VALIDATE_CONDITIONS


@click.command(
    short_help="Compare a table with fresh direct simulation.",
    epilog=options.examples(
        "tablegen validate corundum-steel",
        "tablegen validate my-pair.h5 --accuracy standard --conditions 20 --json accuracy.json",
        "tablegen validate my-pair.h5 --alpha 30 --speed 120 --alpha 45 --speed 260",
    ),
)
@click.argument("table", type=options.TABLE, metavar="T.h5")
@click.option(
    "--conditions",
    type=options.Whole(1, 10_000),
    default=VALIDATE_CONDITIONS,
    show_default=True,
    help="Conditions between nodes to compare at, spread evenly over angle and speed.",
)
@click.option(
    "--alpha",
    type=options.ANGLE,
    multiple=True,
    metavar="DEG",
    help="Impact angle to compare at, and nowhere else; repeatable, with --speed.",
)
@click.option(
    "--speed",
    type=options.POSITIVE,
    multiple=True,
    metavar="M_S",
    help="Impact speed to compare at; the first goes with the first --alpha.",
)
@click.option(
    "--accuracy",
    metavar="A",
    help="What to hold the table against: compact, standard or fine, or limits such as "
    "ks=0.01,auc=0.56. By default what the table declares.",
)
@click.option(
    "--seed",
    type=options.SEED,
    metavar="S",
    help="Seed of the conditions and of both samples; by default another one each time, printed.",
)
@click.option(
    "--samples",
    type=options.Whole(1000, 10**9),
    help="States a side at first; by default as many as the accuracy needs, at least 100000. "
    "Where noise leaves the verdict open, up to nine times as many.",
)
@click.option(
    "--store",
    is_flag=True,
    help="Write what was measured between nodes into the table, in place of what it stores.",
)
@options.json_file("Write every number.")
@options.html_file
@click.option("--details", is_flag=True, help="Means and modes at every condition.")
@options.progress
def validate(**given: Any) -> int:
    """Compare a table with fresh direct simulation: all nodes coarsely, some conditions closely.

    KS: largest Kolmogorov-Smirnov distance of a component. Sliced W: sliced Wasserstein distance
    of the standardised states. Corr.: largest error of a correlation. AUC: how well a classifier
    tells table from direct; 0.5 = it cannot. Each stands beside the noise that finite samples add.
    Exit status 1 if the accuracy is missed by more than noise.
    """
    return work("tablegen.commands.validate_command", **given)
