"""How both programs end: with an exit status, and with one line where the input is bad."""

import sys
from collections.abc import Callable, Sequence
from typing import Any

import click

from sampler.errors import InputError

#: Exit statuses: all is well, a declared accuracy was missed, bad input, interrupted by the user.
DONE, MISSED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130

#: Runs the program with a context object for its commands; returns the exit status.
Call = Callable[[Any], int]


class Program(click.Group):
    """Group of commands that names the commands there are where another one is given."""

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command of the first word; raises `click.UsageError` if there is none."""
        if args[0] not in self.commands:
            ctx.fail(f"COMMAND: got '{args[0]}', allowed: {', '.join(sorted(self.commands))}")
        return super().resolve_command(ctx, args)


def run_program(
    program: Program,
    argv: Sequence[str] | None,
    start: Callable[[list[str], Call], int] = lambda words, call: call(None),
) -> int:
    """Run a command line and return its exit status; what goes wrong is one line.

    Parameters
    ----------
    program : Program
        Its ``name`` stands in front of the line.
    argv : sequence of str or None
        Arguments; None for those of the process.
    start : callable
        Gets the arguments and what runs the program; returns the exit status.
    """
    words, name = list(sys.argv[1:] if argv is None else argv), program.name

    def call(context: Any) -> int:
        status = program.main(args=words, obj=context, prog_name=name, standalone_mode=False)
        return status if isinstance(status, int) else DONE

    try:
        return start(words, call)
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
        click.echo(": ".join([f"{name}: interrupted", *error.args]), err=True)
        return INTERRUPTED
    click.echo(f"{name}: error: {' '.join(message.split())}", err=True)
    return BAD_INPUT


def note(program: str, line: str) -> None:
    """Tell the user of a program, on standard error, what is worth knowing."""
    click.echo(f"{program}: note: {line}", err=True)
