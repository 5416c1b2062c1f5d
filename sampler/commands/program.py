"""How both programs end: with an exit status, and with one line where the input is bad."""

import os
import sys
import traceback
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any, TextIO

import click

from sampler.commands.signals import ending, first_to_say, is_ending, line_break
from sampler.errors import InputError

#: Exit statuses: all is well, an accuracy was missed, bad input, any other failure. Python's own 1,
#: for what nobody caught, would look like a missed accuracy. Signals end with 128 and their number.
DONE, MISSED, BAD_INPUT, FAILED = 0, 1, 2, 3

#: Characters of a line on standard error: what was given may be a file full of them.
_LONGEST_LINE = 4000

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

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command; on Ctrl-C click would print an empty line, wherever that goes."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            raise click.Abort from None


def run_program(
    program: Program,
    argv: Sequence[str] | None,
    start: Callable[[list[str], Call], int] = lambda words, call: call(None),
) -> int:
    """Run a command line and return its exit status; what goes wrong is one line.

    What no user can cause is a defect of the program and keeps its traceback, for a report.

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
        try:
            status = program.main(args=words, obj=context, prog_name=name, standalone_mode=False)
        except click.exceptions.NoArgsIsHelpError as error:
            click.echo(error.format_message())
            return BAD_INPUT
        return status if isinstance(status, int) else DONE

    try:
        status = start(words, call)
        _flush(sys.stdout)
        return status
    except SystemExit as error:
        if error.code != 1:  # of completion in a shell
            raise
        return FAILED  # click, where nobody reads the output any more
    except (Exception, KeyboardInterrupt) as error:
        status, line = _end(error)
        if not is_ending() or first_to_say():
            with suppress(OSError):
                click.echo(f"{line_break() * is_ending()}{name}: {_one_line(line)}", err=True)
        return status
    finally:
        for stream in (sys.stdout, sys.stderr):
            _give_up_unwritten(stream)


def _end(error: BaseException) -> tuple[int, str]:
    """Exit status and line for what ended a program; prints the traceback of a defect."""
    # first: what a signal breaks off may fail in many ways
    if isinstance(error, click.Abort | KeyboardInterrupt) or is_ending():
        status, word = ending()
        said = error.args if isinstance(error, click.Abort) else ()
        return status, ": ".join([word, *map(str, said)])
    if isinstance(error, click.ClickException):
        return BAD_INPUT, f"error: {error.format_message()}"
    if isinstance(error, InputError):
        return BAD_INPUT, f"error: {error}"
    if isinstance(error, MemoryError):
        return BAD_INPUT, "error: not enough memory, allowed: a smaller count, or fewer samples"
    if isinstance(error, OSError):  # of the system: a full disk, a file that went away
        return FAILED, f"error: {error}"
    with suppress(OSError):
        traceback.print_exception(error)
    told = f"{type(error).__name__}: {error}"
    return FAILED, f"error: a defect of the program, please report it with the lines above; {told}"


def _one_line(text: str) -> str:
    """Text on one line of bounded length, without characters that terminals obey."""
    line = " ".join(text.split())
    if len(line) > _LONGEST_LINE:
        line = f"{line[:_LONGEST_LINE]} ..."
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in line)


def _flush(stream: TextIO | None) -> None:
    """Write out what a stream holds; raises `OSError` where that cannot be."""
    if stream is not None and not stream.closed:
        stream.flush()


def _give_up_unwritten(stream: TextIO | None) -> None:
    """Drop what cannot be written: Python would try again when it ends, and end with 120."""
    try:
        _flush(stream)
    except OSError:
        if stream is not None:
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def note(program: str, line: str) -> None:
    """Tell the user of a program, on standard error, what is worth knowing."""
    click.echo(f"{program}: note: {_one_line(line)}", err=True)
