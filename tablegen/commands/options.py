"""Types of command-line values that refuse what cannot be used, in one line."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click
from click.shell_completion import CompletionItem

from sampler.errors import InputError
from sampler.files.atomic import check_output
from sampler.files.locate import available

#: What a decorator of commands is given, and gives back.
Command = TypeVar("Command", bound=Callable[..., Any])


class Number(click.ParamType):
    """Finite number in [low, high], or (low, high] where ``open_low``.

    click's own ranges let NaN pass.
    """

    name = "number"

    def __init__(
        self, low: float = -math.inf, high: float = math.inf, open_low: bool = False
    ) -> None:
        self.low, self.high, self.open_low = low, high, open_low

    def _allowed(self) -> str:
        lower = f"above {self.low:g}" if self.open_low else f"{self.low:g}"
        if math.isinf(self.low) and math.isinf(self.high):
            return "a finite number"
        if math.isinf(self.high):
            return f"a finite number {lower}" if self.open_low else f"{self.low:g} or more"
        return f"{lower} and up to {self.high:g}" if self.open_low else f"{lower} to {self.high:g}"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Parse and check one value."""
        try:
            number = float(value)
        except ValueError:
            number = math.nan
        inside = self.low < number if self.open_low else self.low <= number
        if not (inside and number <= self.high and math.isfinite(number)):
            self.fail(f"got {value!r}, allowed: {self._allowed()}", param, ctx)
        return number


class Whole(click.ParamType):
    """Whole number in [low, high]."""

    name = "integer"

    def __init__(self, low: int, high: int) -> None:
        self.low, self.high = low, high

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:
        """Parse and check one value."""
        try:
            number = int(value)
        except ValueError:
            number = self.low - 1
        if not self.low <= number <= self.high:
            self.fail(
                f"got {value!r}, allowed: a whole number from {self.low} to {self.high}", param, ctx
            )
        return number


class OutputFile(click.ParamType):
    """File that can be written, checked before any work is done."""

    name = "file"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        """Check that the file's folder exists and can be written."""
        try:
            return check_output(value)
        except InputError as error:
            self.fail(str(error).removeprefix("output: "), param, ctx)


class Named(click.ParamType):
    """Name of a file that comes with the package, or a path; a shell completes both.

    Whether there is such a file is for the command to find out.
    """

    name = "text"

    def __init__(self, suffix: str) -> None:
        self.suffix = suffix

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """Names that begin with the word, and the files of the shell."""
        names = [name for name in available(self.suffix) if name.startswith(incomplete)]
        return [*map(CompletionItem, names), CompletionItem(incomplete, type="file")]


SEED = Whole(0, 2**64 - 1)
COUNT = Whole(1, 2**40)
ANGLE = Number(0.0, 90.0, open_low=True)
POSITIVE = Number(0.0, open_low=True)
RATIO = Number(0.0, 1.0, open_low=True)
ANY = Number()
OUTPUT = OutputFile()
TABLE = Named(".h5")
CONFIG = Named(".toml")


#: Adds the argument ``progress`` to a command: whether it says how far it is.
progress = click.option(
    "--progress/--quiet",
    default=True,
    help="Say how far it is: a bar on a terminal, else a line every half minute.",
)


#: Adds ``html_file``: where a page is written, if anywhere.
html_file = click.option("--html", "html_file", type=OUTPUT, metavar="F", help="Write a page.")


def json_file(what: str) -> Callable[[Command], Command]:
    """Add ``json_file`` to a command: where numbers are written, if anywhere."""
    return click.option("--json", "json_file", type=OUTPUT, metavar="F", help=what)


def seed(what: str) -> Callable[[Command], Command]:
    """Add ``seed`` to a command, 1 unless given."""
    return click.option("--seed", type=SEED, default=1, show_default=True, metavar="S", help=what)


def examples(*lines: str) -> str:
    """Epilog of a help page, laid out as it stands."""
    return "\b\nExamples:\n" + "\n".join(f"  {line}" for line in lines)
