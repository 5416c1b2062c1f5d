"""Command line of the runtime: ``sampler draw``, ``export`` and ``list``, and where the header is.

Exit status: 0 done, 2 bad input, 3 any other failure, 130 interrupted, 143 terminated. Bad input
gives one line on standard error and leaves no output. What does the work of a command is imported
when it runs.
"""

from collections.abc import Sequence

import click

import sampler
from sampler.cli import export, list_names
from sampler.commands.draw import draw
from sampler.files import include_directory
from sampler.options import SETTINGS, Program, examples, run_program


def _print_include_directory(ctx: click.Context, _: click.Parameter, given: bool) -> None:
    if given:
        click.echo(include_directory())
        ctx.exit()


@click.group(
    "sampler",
    cls=Program,
    no_args_is_help=False,
    context_settings=SETTINGS,
    epilog=examples(
        "sampler list",
        "sampler draw corundum-steel --alpha 30 --speed 150 --count 100000 --seed 1 --output a.npz",
        "sampler export corundum-steel --output corundum-steel.rbt",
    ),
)
@click.version_option(sampler.__version__, message="%(version)s")
@click.option(
    "--include-dir",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_print_include_directory,
    help="Print the folder of rebound_sampler.h and rebound_sampler.f90, and exit.",
)
def cli() -> None:
    """Draw rebound states of non-spherical particles from a table.

    An output is a file: a regular one is replaced and keeps its mode, a link is followed; devices
    and pipes, what is read, and other outputs are refused.

    Exit status: 0 done, 2 bad input, 3 any other failure, 130 interrupted, 143 terminated.
    """


for command in (draw, export, list_names):
    cli.add_command(command)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit status.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments; those of the process if left out.
    """
    return run_program(cli, argv)
