"""Conventions of both command lines: exit statuses, one line for bad input, types of options."""

import errno
import math
import os
import sys
import traceback
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar

import click
from click.shell_completion import CompletionItem

from sampler.errors import InputError, OutputError, printable
from sampler.files import available, check_output, is_stream, parse_number
from sampler.limits import Bounds
from sampler.version import __version__

#: Exit statuses: all is well, an accuracy was missed, bad input, any other failure, Ctrl-C, and no
#: reader of standard output, for which shells show the same number. The 1 of Python itself, for an
#: uncaught exception, would look like a missed accuracy.
DONE, MISSED, BAD_INPUT, FAILED, INTERRUPTED, NO_READER = 0, 1, 2, 3, 130, 141

#: Longest line on standard error: a given value may be a file.
_LONGEST_LINE = 4000

#: A function that a decorator of commands takes, and returns.
Decorated = TypeVar("Decorated", bound=Callable[..., Any])

#: Settings of the help pages of both programs.
SETTINGS = {"help_option_names": ["-h", "--help"], "max_content_width": 100}


class Program(click.Group):
    """Group of commands that lists them where an unknown one is given."""

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command of the first word; raises `click.UsageError` if there is none."""
        if args[0] not in self.commands:
            raise InputError("COMMAND", f"'{args[0]}'", ", ".join(sorted(self.commands)))
        return super().resolve_command(ctx, args)


class Command(click.Command):
    """Command of both programs, whose outputs are no inputs and whose examples name the program."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse the words; raises `InputError` if an option is given twice.

        Click takes the last one.
        """
        _, _, given = self.make_parser(ctx).parse_args(args=list(args))
        for param in given:
            if given.count(param) > 1 and not param.multiple and not ctx.resilient_parsing:
                raise InputError(flag_of(param), problem="is given twice", remedy="give it once")
        return super().parse_args(ctx, args)

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command; raises `InputError` if an output is also an input or another output.

        Errors of functions that the command calls name the option as the user has typed it.
        """
        self._check_outputs(ctx)
        try:
            return super().invoke(ctx)
        except InputError as error:
            if error.source:  # a field of a file
                raise
            raise error.replaced(argument=self._typed(ctx, error)) from error

    def _typed(self, ctx: click.Context, error: InputError) -> str:
        """Return the first option that may have given an argument, by name or kind of file.

        An error about an output knows its path.
        """
        argument = error.argument
        path = error.path if isinstance(error, OutputError) else None
        for param in self.params:
            if path is not None and ctx.params.get(str(param.name)) == path:
                return flag_of(param)
        for param in self.params:
            if argument in (param.name, getattr(param.type, "kind_of_file", None)):
                return flag_of(param) if isinstance(param, click.Option) else argument
        return argument

    def _check_outputs(self, ctx: click.Context) -> None:
        """Refuse an output that is also an input or another output."""
        named = [(p.opts[0], p.type, ctx.params.get(str(p.name))) for p in self.params]
        inputs = [
            (name, value)
            for name, kind, values in named
            if isinstance(kind, Named | click.Path) and values
            for value in (values if isinstance(values, tuple) else (values,))
        ]
        taken = {os.path.realpath(value): name for name, value in inputs if os.path.exists(value)}
        for name, kind, value in named:
            if isinstance(kind, OutputFile) and value is not None:
                key = os.path.realpath(value)
                if key in taken:
                    problem = f"{value} is the file that {taken[key]} names, too"
                    raise InputError(name, problem=problem, remedy="give another file")
                taken[key] = name

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the examples, in which PROGRAM stands for the program."""
        formatter.write_paragraph()
        with formatter.indentation():
            program = str(ctx.find_root().info_name)
            formatter.write_text(str(self.epilog).replace("PROGRAM", program))


#: Numbers of errors of a file, such as standard output, to which nothing more can be written.
_NO_SPACE = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EBADF)


def run_program(program: Program, argv: Sequence[str] | None) -> int:
    """Run a command line and return its exit status; a user's mistake is one line.

    A defect of the program keeps its traceback.

    Parameters
    ----------
    program : Program
        Its ``name`` stands in front of the line.
    argv : sequence of str or None
        Arguments; None for those of the process.
    """
    words = list(sys.argv[1:] if argv is None else argv)
    _open_standard_output()
    try:
        status = _run(program, words)
        sys.stdout.flush()
        return status
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.format_message())
        return BAD_INPUT
    except (click.Abort, KeyboardInterrupt) as error:
        line = ": ".join(["interrupted", *map(str, error.args)])
        return ended(program, INTERRUPTED, line)
    except click.ClickException as error:
        return ended(program, BAD_INPUT, f"error: {error.format_message()}")
    except InputError as error:
        return ended(program, BAD_INPUT, f"error: {error}")
    except MemoryError:
        line = "error: there is not enough memory; ask for a smaller count, or fewer samples"
        return ended(program, BAD_INPUT, line)
    except BrokenPipeError:  # as of `| head`; other programs say nothing of it, either
        return NO_READER
    except OSError as error:  # of the system; files of outputs are named by an InputError
        if error.filename is not None:
            return ended(program, BAD_INPUT, f"error: {error.filename}: {error.strerror}")
        if error.errno in _NO_SPACE:
            line = f"error: cannot write to standard output: {error.strerror}"
            return ended(program, FAILED, line)
        return ended(program, FAILED, f"error: {error}")  # such as a connection that broke
    except Exception as error:
        with suppress(OSError):
            traceback.print_exception(error)
        what = f"{type(error).__name__}: {error}"
        line = f"error: a defect of rebound-tables {__version__}, not of your input; {what}"
        return ended(program, FAILED, line)
    finally:
        _drop_unwritten()


def _run(program: Program, words: list[str]) -> int:
    """Run a command line; click's own `main` would end with 1 if a pipe breaks."""
    name = str(program.name)
    if f"_{name}_COMPLETE".upper() in os.environ:  # a shell asks how a word may go on
        program.main(words, name, standalone_mode=False)
    try:
        with program.make_context(name, words) as ctx:
            status = program.invoke(ctx)
    except click.exceptions.Exit as error:  # after --help, for example
        status = error.exit_code
    return status if isinstance(status, int) else DONE


def _open_standard_output() -> None:
    """If standard output is closed, open it such that nothing can be written to it.

    Otherwise all that is printed would be lost without a word, or go to the first file that the
    program opens, which gets the free descriptor.
    """
    if sys.stdout is None:
        while os.open(os.devnull, os.O_RDONLY) < 1:
            pass  # standard input is closed, too
        sys.stdout = open(1, "w", encoding="utf-8", closefd=False)  # noqa: SIM115


def _drop_unwritten() -> None:
    """Drop what cannot be written: the interpreter would try it again, and end with 120."""
    for stream in filter(None, (sys.stdout, sys.stderr)):
        try:
            stream.flush()
        except OSError:
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, stream.fileno())
            os.close(nowhere)


def ended(program: Program, status: int, line: str) -> int:
    """Write the line on how a program ended and return its status."""
    with suppress(OSError):  # standard error is closed or full
        click.echo(f"{program.name}: {_one_line(line)}", err=True)
    return status


def _one_line(text: str) -> str:
    """Put a text on one line of bounded length, without characters that terminals obey."""
    line = " ".join(text.split())
    if len(line) > _LONGEST_LINE:
        line = f"{line[:_LONGEST_LINE]} ..."
    return printable(line)


def note(program: str, line: str) -> None:
    """Write a note to the user of a program, on standard error."""
    with suppress(OSError):  # what is said by the way ends no work
        click.echo(f"{program}: note: {_one_line(line)}", err=True)


#: Whether an output may be replaced, in the ``meta`` of a context.
_OVERWRITE = "overwrite"


def flag_of(param: click.Parameter | None) -> str:
    """Return the name of an option or argument in messages, as a user writes it."""
    return "" if param is None else param.opts[0]


class OutputFile(click.ParamType):
    """File that can be written, checked before any work is done.

    Parameters
    ----------
    suffixes : str
        Endings that names may have; any, if none is given.
    """

    name = "file"

    def __init__(self, *suffixes: str) -> None:
        self.suffixes = suffixes

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        """Check that the path is no folder and lies in a folder that can be written."""
        flag = flag_of(param)
        try:
            path = check_output(value)
        except InputError as error:
            raise error.replaced(argument=flag) from None
        if self.suffixes and path.suffix not in self.suffixes:
            allowed = f"a name that ends in {' or '.join(self.suffixes)}"
            raise InputError(flag, str(value), allowed)
        kept = ctx is not None and ctx.meta.get(_OVERWRITE) is False
        if kept and path.exists() and not is_stream(path):
            remedy = "give a new name, or --overwrite"
            raise InputError(flag, problem=f"{value} exists", remedy=remedy)
        return path


#: What files that have names are, by suffix.
_KINDS_OF_FILES = {".h5": "table", ".toml": "configuration", ".csv": "measurements"}


class Named(click.ParamType):
    """Name of a file that comes with the package, or a path; a shell completes both.

    Parameters
    ----------
    suffix : str
        Of the file.
    """

    name = "text"

    def __init__(self, suffix: str) -> None:
        self.suffix = suffix
        #: As the errors of `find_file` name it.
        self.kind_of_file = _KINDS_OF_FILES[suffix]

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """List names that begin with the word, and the files of the shell."""
        names = [name for name in available(self.suffix) if name.startswith(incomplete)]
        return [*map(CompletionItem, names), CompletionItem(incomplete, type="file")]


class Number(click.ParamType):
    """Number within bounds; click's own ranges let NaN pass."""

    name = "number"
    kind: type[float] | type[int] = float

    def __init__(self, allowed: Bounds) -> None:
        self.allowed = allowed

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Parse and check one value."""
        try:
            number = math.nan if math.isnan(parse_number(str(value))) else self.kind(value)
        except ValueError:  # 1e3 is no integer
            number = math.nan
        if not self.allowed.low <= number <= self.allowed.high:
            raise InputError(flag_of(param), repr(value), self.allowed.words)
        return number


class Integer(Number):
    """Integer from first to last."""

    name = "integer"
    kind = int

    def __init__(self, first: int, last: int) -> None:
        super().__init__(Bounds(first, last, text=f"a whole number from {first} to {last}"))


SEED = Integer(0, 2**64 - 1)
COUNT = Integer(1, 2**40)
SAMPLES = Integer(1000, 10**9)
THREADS = Integer(1, 4096)
CONDITIONS = Integer(1, 10_000)
ANGLE = Number(Bounds(math.ulp(0.0), 90.0, text="above 0 and up to 90"))
COMPONENT = Number(Bounds(-1e6, 1e6))
POSITIVE = Number(Bounds(math.ulp(0.0), text="a finite number above 0"))
OUTPUT = OutputFile()
INPUT = click.Path(path_type=Path)
TABLE = Named(".h5")

#: Adds the argument ``table``, which must be given.
table = click.argument("table", type=TABLE, metavar="T.h5|NAME")

#: Adds ``as_json``: whether the result is for a program to read.
as_json = click.option(
    "--json", "as_json", is_flag=True, help="Print the result as JSON, for a program to read."
)

#: Adds ``progress``: whether the command says how far it is.
progress = click.option(
    "--progress/--quiet",
    default=True,
    help="Show progress, or not: a bar on a terminal, otherwise a line every half minute.",
)

#: Adds ``html_file``: where a page is written, if anywhere.
html_file = click.option(
    "--html", "html_file", type=OUTPUT, metavar="F", help="Write the results to this HTML page."
)


def impact(angle: Number, speed: Number) -> Callable[[Decorated], Decorated]:
    """Add ``alpha`` and ``speed`` to a command: the impact, which must be given."""
    add_alpha = click.option(
        "--alpha",
        required=True,
        type=angle,
        metavar="DEG",
        help="Impact angle from the wall, degrees.",
    )
    add_speed = click.option(
        "--speed", required=True, type=speed, metavar="M_S", help="Impact speed V, m/s."
    )
    return lambda command: add_alpha(add_speed(command))


#: Adds ``threads``: how many work, if not one a processor.
threads = click.option(
    "--threads", type=THREADS, help="Number of threads; by default one for each processor."
)


def json_file(help_text: str) -> Callable[[Decorated], Decorated]:
    """Add ``json_file`` to a command: where numbers are written, if anywhere."""
    return click.option("--json", "json_file", type=OUTPUT, metavar="F", help=help_text)


def output(
    metavar: str, *suffixes: str, help_text: str = "File to write."
) -> Callable[[Decorated], Decorated]:
    """Add ``output`` to a command: the file that it writes, which must be given."""
    kind = OutputFile(*suffixes)
    return click.option("--output", required=True, type=kind, metavar=metavar, help=help_text)


#: Makes a command keep outputs that exist, without this flag: for those that work long.
overwrite = click.option(
    "--overwrite",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=lambda ctx, _, value: ctx.meta.update({_OVERWRITE: value}),
    help="Replace output files that exist.",
)


def seed(help_text: str) -> Callable[[Decorated], Decorated]:
    """Add ``seed`` to a command, 1 unless given."""
    return click.option(
        "--seed", type=SEED, default=1, show_default=True, metavar="S", help=help_text
    )


def examples(*lines: str) -> str:
    """Write the epilog of a help page, laid out as it stands."""
    return "\b\nExamples:\n" + "\n".join(f"  {line}" for line in lines)
