"""Command line of the runtime: ``sampler draw``, ``export`` and ``list``, and where the header is.

Bad input gives one line on standard error and exit status 2; an output file appears whole or not
at all. What does the work of a command is imported when it is run.
"""

import argparse
import sys
from collections.abc import Sequence
from typing import Any, NoReturn

import sampler
from sampler.compilation.late import work
from sampler.errors import InputError
from sampler.files.locate import include_directory
from sampler.inputs.values import integer, number, output

#: Exit status for bad input.
BAD_INPUT = 2

_DRAW_EXAMPLES = (
    "sampler draw corundum-steel --alpha 30 --speed 150 --count 100000 --seed 1 --output a.npz",
    "sampler draw my-table.h5 --alpha 90 --speed 80 --count 1000 --seed 2 --output b.npz",
)
_EXPORT_EXAMPLES = (
    "sampler export corundum-steel --output corundum-steel.rbt",
    "sampler export my-table.h5 --output my-table.rbt",
)
_LIST_EXAMPLES = ("sampler list", "sampler list --json")

_READING = """

The output holds state (N, 6): u, v, w over V and omega_x, omega_y, omega_z times a/V, and the names
of its columns. Read it with numpy.load("a.npz")["state"]."""


class _Parser(argparse.ArgumentParser):
    """Parser that reports an error as one line, without the usage."""

    def error(self, message: str) -> NoReturn:
        raise InputError(message)


class _PrintIncludeDirectory(argparse.Action):
    """Flag that prints a path, unbroken however narrow the terminal is, and exits."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> NoReturn:
        sys.stdout.write(f"{include_directory()}\n")
        parser.exit()


def _page(description: str, *examples: str, note: str = "") -> dict[str, Any]:
    """Arguments of a parser for its help page."""
    return {
        "description": description,
        "epilog": "\n  ".join(("examples:", *examples)) + note,
        "formatter_class": argparse.RawDescriptionHelpFormatter,
        "allow_abbrev": False,
    }


def _parser() -> argparse.ArgumentParser:
    examples = [_LIST_EXAMPLES[0], _DRAW_EXAMPLES[0], _EXPORT_EXAMPLES[0]]
    about = "Draw rebound states of non-spherical particles from a table."
    parser = _Parser(prog="sampler", **_page(about, *examples))
    parser.add_argument("--version", action="version", version=sampler.__version__)
    parser.add_argument(
        "--include-dir",
        action=_PrintIncludeDirectory,
        nargs=0,
        dest=argparse.SUPPRESS,
        default=argparse.SUPPRESS,
        help="print the folder of rebound_sampler.h and rebound_sampler.f90, and exit",
    )
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    _add_draw(commands)
    _add_export(commands)
    _add_list(commands)
    return parser


def _add_table(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("table", metavar="TABLE", help="name of a table, or path of a .h5 file")


def _add_draw(commands: Any) -> None:
    draw = commands.add_parser(
        "draw",
        help="draw states at one impact angle and speed",
        **_page(
            "Draw rebound states at one impact angle and speed.", *_DRAW_EXAMPLES, note=_READING
        ),
    )
    _add_table(draw)
    angle = number(0.0, 90.0, "degrees above 0, at most 90")
    speed = number(0.0, sys.float_info.max, "m/s above 0, finite")
    count = integer(1, 2**63 - 1, "a whole number from 1")
    seed = integer(0, 2**64 - 1, "a whole number from 0 to 2**64 - 1")
    add = draw.add_argument
    add("--alpha", required=True, type=angle, metavar="DEG", help="impact angle from the wall")
    add("--speed", required=True, type=speed, metavar="M_S", help="impact speed")
    add("--count", required=True, type=count, metavar="N", help="number of states")
    add("--seed", required=True, type=seed, metavar="S", help="seed of the random numbers")
    add("--output", required=True, type=output, metavar="F.npz", help="file to write")
    add(
        "--outside",
        choices=("clamp", "raise"),
        default="clamp",
        help="outside the table's range: use its edge and say so (default), or stop",
    )


def _add_export(commands: Any) -> None:
    export = commands.add_parser(
        "export",
        help="write a table as an image for C, C++, Fortran and OpenFOAM",
        **_page(
            "Write a table as an image (.rbt) that C, C++ and Fortran map into memory.\n\n"
            "The header that reads it lies in the folder that sampler --include-dir prints.",
            *_EXPORT_EXAMPLES,
        ),
    )
    _add_table(export)
    export.add_argument(
        "--output", required=True, type=output, metavar="T.rbt", help="file to write"
    )


def _add_list(commands: Any) -> None:
    listing = commands.add_parser(
        "list",
        help="list the tables, material pairs and scenes that have a name",
        **_page(
            "List the tables, material pairs and scenes that come with the package, by name.",
            *_LIST_EXAMPLES,
        ),
    )
    listing.add_argument(
        "--json", dest="as_json", action="store_true", help="print them for a program to read"
    )


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments; those of the process if left out.

    Returns
    -------
    int
        Exit status: 0 done, 2 bad input.
    """
    try:
        given = vars(_parser().parse_args(argv))
        return work(f"sampler.commands.{given.pop('command')}_command", **given)
    except InputError as error:
        sys.stderr.write(f"sampler: error: {error}\n")
        return BAD_INPUT
