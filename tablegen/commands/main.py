"""Command line of the generator: ``tablegen`` and its commands.

Exit status: 0 done, 1 accuracy missed, 2 bad input, 3 any other failure, 130 interrupted, 141
standard output has no reader. A mistake in what the user typed gives one line on standard error,
and no output is written.
"""

from collections.abc import Sequence

import click

import sampler
from sampler.cli import export, list_names
from sampler.options import BAD_INPUT, SETTINGS, Program, ended, examples, run_program
from tablegen.commands.calibrate import calibrate
from tablegen.commands.compare import compare
from tablegen.commands.compile import compile_kernels
from tablegen.commands.demo import demo
from tablegen.commands.export_direct import export_direct
from tablegen.commands.generate import generate
from tablegen.commands.inspect import inspect
from tablegen.commands.prune import prune
from tablegen.commands.report import report
from tablegen.commands.simulate import simulate
from tablegen.commands.stability import stability
from tablegen.commands.validate import validate
from tablegen.config import require_generator


@click.group(
    "tablegen",
    cls=Program,
    context_settings=SETTINGS,
    epilog=examples(
        "tablegen demo",
        "tablegen generate my-pair.toml --output my-pair.h5",
        "tablegen validate my-pair.h5",
    ),
)
@click.version_option(sampler.__version__)
def cli() -> None:
    """Simulate rebounds of non-spherical particles, and make tables to draw rebounds from.

    Exit status: 0 done, 1 accuracy missed, 2 bad input, 3 any other failure, 130 interrupted, 141
    standard output has no reader.
    """


for command in (demo, simulate, generate, validate, inspect, list_names, prune, export):
    cli.add_command(command)
cli.add_command(export_direct)
for study in (compare, calibrate, report, stability, compile_kernels):
    cli.add_command(study)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit status.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments; by default those of the process.
    """
    try:
        require_generator()
    except ImportError as error:
        return ended(cli, BAD_INPUT, f"error: {error}")
    return run_program(cli, argv)
