"""``tablegen prune``: cut a table to what a scene needs."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from sampler import options
from sampler.errors import InputError
from sampler.formats.channels import VARIABLES
from sampler.options import DONE, note
from tablegen.commands.shared import CONFIG

if TYPE_CHECKING:
    from tablegen.config.config import Config


def _names(
    _context: click.Context, _option: click.Parameter, value: str | None
) -> list[str] | None:
    """Parse names of variables that are separated by commas."""
    if value is None:
        return None
    names = [name.strip() for name in value.split(",")]
    if len(set(names)) < len(names) or not set(names) <= set(VARIABLES):
        allowed = f"names with commas between them, each once: {', '.join(VARIABLES)}"
        raise InputError("--variables", repr(value), allowed)
    return names


@click.command(
    cls=options.Command,
    short_help="Cut a table to what a scene needs.",
    epilog=options.examples(
        "tablegen prune corundum-steel --scene plane-flow --output plane.h5",
        "tablegen prune my-pair.h5 --dimension 2 --output plane.h5",
        "tablegen prune my-pair.h5 --variables u,v --output velocities.h5",
        "tablegen prune my-pair.h5 --scene my-scene.toml --output small.h5",
    ),
)
@options.table
@click.option(
    "--scene",
    type=CONFIG,
    metavar="SCENE.toml",
    help="Scene with the angles, speeds and variables to keep: a name, or a path.",
)
@click.option(
    "--dimension",
    type=click.Choice(["2", "3"]),
    help="2: keep u, v and omega_z, for a plane flow. 3: keep all six variables.",
)
@click.option(
    "--variables",
    callback=_names,
    metavar="NAME,NAME,...",
    help=f"Variables to keep, of {', '.join(VARIABLES)}.",
)
@options.output("S.h5", ".h5", help_text="New table to write.")
@options.overwrite
def prune(
    table: str,
    scene: str | None,
    dimension: str | None,
    variables: list[str] | None,
    output: Path,
) -> int:
    """Write a smaller table that has only the variables, angles and speeds that you need.

    For the same keys, the new table gives the same draws as the full one. It keeps the spin law,
    unless the scene says spin = false. A scene names the variables, angles and speeds to keep; it
    may be a scene of another pair. If the scene itself states laws, particles or numerical
    parameters, they must be those of the table.
    """
    from sampler.files import find_table
    from sampler.formats.hdf5 import read_table
    from tablegen.config.config import stored_config
    from tablegen.tables.prune import prune as prune_table

    if scene is None and dimension is None and variables is None:
        problem = "no option says what to keep"
        raise InputError("", problem=problem, remedy="give --scene, --dimension or --variables")
    source = find_table(table)
    whole = read_table(source)
    config = stored_config(whole.config, "config of the table")
    wanted = _wanted(config, scene, dimension, variables)
    contents = prune_table(source, wanted, output, scene or "flags")
    alpha, speed = contents["axes/alpha_deg"], contents["axes/speed"]
    click.echo(
        f"{output}: {', '.join(contents.variables)}; {alpha[0]:g} to {alpha[-1]:g} degrees, "
        f"{speed[0]:g} to {speed[-1]:g} m/s; {output.stat().st_size / 1e3:.0f} kB instead of "
        f"{source.stat().st_size / 1e3:.0f} kB"
    )
    removed = [name for name in whole.variables if name not in contents.variables]
    removed += ["the spin law"] if whole.has_spin and not contents.has_spin else []
    click.echo(f"left out: {', '.join(removed) or 'no variable'}")
    if whole["accuracy/ks"].size and not contents["accuracy/ks"].size:
        note(
            "tablegen",
            "the new table stores no accuracy, because that of the full table was measured with "
            "more variables or at other conditions; "
            f"to measure it, run: tablegen validate {output} --store",
        )
    return DONE


def _wanted(
    config: "Config", scene: str | None, dimension: str | None, variables: list[str] | None
) -> "Config":
    """Return the configuration of the table, changed by the scene, and then by the options."""
    from tablegen.config.config import scene_over

    if scene is not None:
        pair = config.pair_name
        config, named = scene_over(config, scene)
        if named is not None and Path(named).stem != pair:
            note("tablegen", f"{scene} is a scene of {named}; the table is of {pair}")
    domain: dict[str, object] = {}
    if dimension is not None:
        domain["dimension"] = int(dimension)
    if variables is not None:
        domain["variables"] = variables
    return config.with_changes({"domain": domain}) if domain else config
