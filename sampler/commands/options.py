"""Options of commands: types of values that refuse, in one line, what cannot be used."""

import math
import sys
from collections.abc import Callable
from typing import Any, TypeVar

import click

from sampler.options import InputFile, Named, OutputFile, check_apart

#: What a decorator of commands is given, and gives back.
Decorated = TypeVar("Decorated", bound=Callable[..., Any])

#: Settings of the help pages of both programs.
SETTINGS = {"help_option_names": ["-h", "--help"], "max_content_width": 100}


class Command(click.Command):
    """Command of both programs.

    Its examples name the program that was called, and it writes to nothing that it reads.
    """

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command, after its files were told apart."""
        check_apart(ctx)
        return super().invoke(ctx)

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the examples, in which PROGRAM stands for the program."""
        formatter.write_paragraph()
        with formatter.indentation():
            program = str(ctx.find_root().info_name)
            formatter.write_text(str(self.epilog).replace("PROGRAM", program))


class Number(click.ParamType):
    """Number from low to high.

    click's own ranges let NaN pass.
    """

    name = "number"
    kind: type[float] | type[int] = float

    def __init__(self, allowed: str, low: float, high: float = sys.float_info.max) -> None:
        self.allowed, self.low, self.high = allowed, low, high

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Parse and check one value."""
        try:
            number = self.kind(value)
        except ValueError:
            number = math.nan
        if not self.low <= number <= self.high:
            self.fail(f"got {value!r}, allowed: {self.allowed}", param, ctx)
        return number


class Integer(Number):
    """Integer from first to last."""

    name = "integer"
    kind = int

    def __init__(self, first: int, last: int) -> None:
        super().__init__(f"a whole number from {first} to {last}", first, last)


SEED = Integer(0, 2**64 - 1)
COUNT = Integer(1, 2**40)
SAMPLES = Integer(1000, 10**9)
THREADS = Integer(1, 4096)
CONDITIONS = Integer(1, 10_000)
ANGLE = Number("above 0 and up to 90", math.ulp(0.0), 90.0)
COMPONENT = Number("a number from -1e6 to 1e6", -1e6, 1e6)
POSITIVE = Number("a finite number above 0", math.ulp(0.0))
OUTPUT = OutputFile()
INPUT = InputFile()
TABLE = Named(".h5")

#: Adds the argument ``table``, which must be given.
table = click.argument("table", type=TABLE, metavar="T.h5|NAME")

#: Adds ``as_json``: whether the result is for a program to read.
as_json = click.option("--json", "as_json", is_flag=True, help="Print it for a program to read.")

#: Adds ``progress``: whether the command says how far it is.
progress = click.option(
    "--progress/--quiet",
    default=True,
    help="Say how far it is: a bar on a terminal, else a line every half minute.",
)

#: Adds ``html_file``: where a page is written, if anywhere.
html_file = click.option("--html", "html_file", type=OUTPUT, metavar="F", help="Write a page.")

#: Adds ``threads``: how many work, if not one a processor.
threads = click.option("--threads", type=THREADS, help="Default: one a processor.")


def json_file(what: str) -> Callable[[Decorated], Decorated]:
    """Add ``json_file`` to a command: where numbers are written, if anywhere."""
    return click.option("--json", "json_file", type=OUTPUT, metavar="F", help=what)


def output(metavar: str, what: str = "File to write.") -> Callable[[Decorated], Decorated]:
    """Add ``output`` to a command: the file that it writes, which must be given."""
    return click.option("--output", required=True, type=OUTPUT, metavar=metavar, help=what)


def seed(what: str) -> Callable[[Decorated], Decorated]:
    """Add ``seed`` to a command, 1 unless given."""
    return click.option("--seed", type=SEED, default=1, show_default=True, metavar="S", help=what)


def examples(*lines: str) -> str:
    """Epilog of a help page, laid out as it stands."""
    return "\b\nExamples:\n" + "\n".join(f"  {line}" for line in lines)
