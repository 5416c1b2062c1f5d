"""``tablegen prune``: a table cut to a scene, from the command line."""

from pathlib import Path

import click

from sampler.locate import find_table
from tablegen.config import load_config
from tablegen.prune import prune as prune_table


def run(table: str, scene: str, output: Path) -> int:
    """Run ``tablegen prune``; parameters are the options of `tablegen.commands.prune`."""
    source = find_table(table)
    contents = prune_table(source, load_config(scene), output)
    alpha, speed = contents["axes/alpha_deg"], contents["axes/speed"]
    click.echo(
        f"{output}: {', '.join(contents.components)}; {alpha[0]:g} to {alpha[-1]:g} degrees, "
        f"{speed[0]:g} to {speed[-1]:g} m/s; {output.stat().st_size / 1e3:.0f} kB "
        f"of {source.stat().st_size / 1e3:.0f} kB"
    )
    return 0
