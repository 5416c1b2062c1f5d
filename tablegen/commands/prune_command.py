"""``tablegen prune``: a table cut to a scene, from the command line."""

from pathlib import Path

import click

from sampler.errors import InputError
from sampler.files.locate import find_table
from sampler.formats.hdf5 import read_table
from tablegen.config import Config, parse_config, scene_over
from tablegen.prune import prune as prune_table


def run(
    table: str,
    scene: str | None,
    dimension: str | None,
    components: list[str] | None,
    output: Path,
) -> int:
    """Run ``tablegen prune``; parameters are the options of `tablegen.commands.prune`."""
    if scene is None and dimension is None and components is None:
        raise InputError(
            "Missing option '--scene', '--dimension' or '--components', allowed: one or more"
        )
    source = find_table(table)
    config = parse_config(read_table(source).config, "config of the table")
    wanted = _wanted(config, scene, dimension, components)
    contents = prune_table(source, wanted, output, scene or "flags")
    alpha, speed = contents["axes/alpha_deg"], contents["axes/speed"]
    click.echo(
        f"{output}: {', '.join(contents.components)}; {alpha[0]:g} to {alpha[-1]:g} degrees, "
        f"{speed[0]:g} to {speed[-1]:g} m/s; {output.stat().st_size / 1e3:.0f} kB "
        f"of {source.stat().st_size / 1e3:.0f} kB"
    )
    return 0


def _wanted(
    config: Config, scene: str | None, dimension: str | None, components: list[str] | None
) -> Config:
    """Lay the scene over the configuration of the table, and the flags over both."""
    if scene is not None:
        pair = config.pair_name
        config, named = scene_over(config, scene)
        if named is not None and Path(named).stem != pair:
            click.echo(
                f"tablegen: note: {scene} is a scene of {named}; "
                f"what it keeps is kept of the table of {pair}",
                err=True,
            )
    domain: dict[str, object] = {}
    if dimension is not None:
        domain["dimension"] = int(dimension)
    if components is not None:
        domain["components"] = components
    return config.with_changes({"domain": domain}) if domain else config
