"""``tablegen prune``: its options and its help."""

from typing import Any

import click

from sampler.compilation.late import work
from sampler.formats.variables import COMPONENTS
from tablegen.commands import options


class Components(click.ParamType):
    """Names of components, with commas between them."""

    name = "components"

    def convert(
        self, value: str, param: click.Parameter | None, ctx: click.Context | None
    ) -> list[str]:
        """Parse and check the list."""
        names = [name.strip() for name in value.split(",")]
        if len(set(names)) < len(names) or not set(names) <= set(COMPONENTS):
            allowed = f"some of {','.join(COMPONENTS)}, each once"
            self.fail(f"got {value!r}, allowed: {allowed}", param, ctx)
        return names


@click.command(
    short_help="Cut a table to what a scene needs.",
    epilog=options.examples(
        "tablegen prune corundum-steel --scene plane-flow --output plane.h5",
        "tablegen prune my-pair.h5 --dimension 2 --output plane.h5",
        "tablegen prune my-pair.h5 --components u,v --output no-spin.h5",
        "tablegen prune my-pair.h5 --scene my-scene.toml --output small.h5",
    ),
)
@click.argument("table", type=options.TABLE, metavar="T.h5|NAME")
@click.option(
    "--scene", type=options.CONFIG, metavar="SCENE.toml", help="What to keep: a name, or a path."
)
@click.option(
    "--dimension",
    type=click.Choice(["2", "3"]),
    help="2: keep u, v and omega_z, which are all of a plane flow. 3: all six.",
)
@click.option(
    "--components",
    type=Components(),
    metavar="NAME,NAME,...",
    help=f"Keep these of {', '.join(COMPONENTS)}.",
)
@click.option("--output", required=True, type=options.OUTPUT, metavar="S.h5", help="File to write.")
def prune(**given: Any) -> int:
    """Cut a table to the components, angles and speeds that are needed.

    What stays gives the same draws as the full table for the same keys. A scene says what to keep
    of any pair's table: its components, angles and speeds count, and not the pair that it names.
    Laws, particles and numerical parameters that it states itself must be those of the table.
    """
    return work("tablegen.commands.prune_command", **given)
