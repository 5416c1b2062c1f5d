"""Command line of the generator.

Exit status: 0 done, 1 a declared accuracy was missed, 2 bad input, 130 interrupted. Bad input
gives one line on standard error and leaves no output.
"""

import sys
from collections.abc import Sequence
from concurrent.futures import Executor

import click

import sampler
from sampler.errors import InputError
from tablegen.accuracy.verdict import DONE
from tablegen.commands.demo import demo
from tablegen.commands.export import export
from tablegen.commands.figures import figures
from tablegen.commands.generate import generate
from tablegen.commands.inspect import inspect
from tablegen.commands.list import list_names
from tablegen.commands.options import examples
from tablegen.commands.prune import prune
from tablegen.commands.report import report
from tablegen.commands.simulate import simulate
from tablegen.commands.stability import stability
from tablegen.commands.validate import validate
from tablegen.tasks.mpi_ranks import asks_for_ranks, on_first_rank

BAD_INPUT, INTERRUPTED = 2, 130


@click.group(
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog=examples(
        "tablegen demo",
        "tablegen generate my-pair.toml --output my-pair.h5",
        "tablegen validate my-pair.h5",
    ),
)
@click.version_option(sampler.__version__, prog_name="tablegen")
def cli() -> None:
    """Simulate the rebound of non-spherical particles and make tables to draw it from."""


for command in (
    demo,
    simulate,
    generate,
    validate,
    inspect,
    list_names,
    prune,
    export,
    report,
    figures,
    stability,
):
    cli.add_command(command)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit status.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments; those of the process if left out.
    """
    words = list(sys.argv[1:] if argv is None else argv)
    try:
        if asks_for_ranks(words):
            return on_first_rank(lambda ranks: _run(words, ranks))
        return _run(words, None)
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.format_message())
        return BAD_INPUT
    except click.ClickException as error:
        message = error.format_message()
    except InputError as error:
        message = str(error)
    except MemoryError:
        message = "not enough memory, allowed: a smaller count, or fewer samples"
    except click.Abort as error:
        click.echo(": ".join(["tablegen: interrupted", *error.args]), err=True)
        return INTERRUPTED
    click.echo(f"tablegen: error: {' '.join(message.split())}", err=True)
    return BAD_INPUT


def _run(words: list[str], ranks: Executor | None) -> int:
    status = cli.main(args=words, obj=ranks, prog_name="tablegen", standalone_mode=False)
    return status if isinstance(status, int) else DONE
