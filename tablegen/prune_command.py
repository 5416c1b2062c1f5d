"""``tablegen prune``: a table cut to a scene, from the command line."""

from pathlib import Path

import click

from sampler.locate import find_table
from tablegen import options
from tablegen.config import load_config
from tablegen.prune import prune as prune_table


@click.command(
    short_help="Cut a table to what a scene needs.",
    epilog=options.examples(
        "tablegen prune corundum-steel --scene plane-flow --output plane.h5",
        "tablegen prune my-table.h5 --scene my-scene.toml --output small.h5",
    ),
)
@click.argument("table", metavar="T.h5|NAME")
@click.option(
    "--scene", required=True, metavar="SCENE.toml", help="What to keep: a name, or a path."
)
@click.option("--output", required=True, type=options.OUTPUT, metavar="S.h5", help="File to write.")
def prune(table: str, scene: str, output: Path) -> int:
    """Cut a table to the components, angles and speeds that a scene needs.

    What stays gives the same draws as the full table for the same keys.
    """
    source = find_table(table)
    contents = prune_table(source, load_config(scene), output)
    alpha, speed = contents["axes/alpha_deg"], contents["axes/speed"]
    click.echo(
        f"{output}: {', '.join(contents.components)}; {alpha[0]:g} to {alpha[-1]:g} degrees, "
        f"{speed[0]:g} to {speed[-1]:g} m/s; {output.stat().st_size / 1e3:.0f} kB "
        f"of {source.stat().st_size / 1e3:.0f} kB"
    )
    return 0
