"""Command line of the runtime: ``sampler draw``, and where the C header is.

Bad input gives one line on standard error and exit status 2; an output file appears whole or not
at all.
"""

import argparse
import math
import sys
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NoReturn

import numpy as np

import sampler
from sampler.atomic import atomic_output, check_output
from sampler.errors import InputError, OutsideTableWarning
from sampler.kernel import is_outside
from sampler.locate import include_directory
from sampler.table import Table, load

#: Exit status for bad input.
BAD_INPUT = 2

_EXAMPLES = """\
examples:
  sampler draw corundum-steel --alpha 30 --speed 150 --count 100000 --seed 1 --output states.npz
  sampler draw my-table.h5 --alpha 90 --speed 80 --count 1000 --seed 2 --output states.npz

The output holds one array, state (N, 6): u, v, w over V and omega_x, omega_y, omega_z times a/V.
Read it with numpy.load("states.npz")["state"].
"""


class _Parser(argparse.ArgumentParser):
    """Parser that reports an error as one line, without the usage."""

    def error(self, message: str) -> NoReturn:
        raise InputError(message)


class _PrintIncludeDirectory(argparse.Action):
    """Flag that prints a path, unbroken however narrow the terminal is, and exits."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> NoReturn:
        sys.stdout.write(f"{include_directory()}\n")
        parser.exit()


def _number(low: float, high: float, allowed: str) -> Callable[[str], float]:
    """Parser of a finite number in (low, high]."""

    def parse(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not (low < value <= high and math.isfinite(value)):
            raise argparse.ArgumentTypeError(f"got {text!r}, allowed: {allowed}")
        return value

    return parse


def _integer(low: int, high: int, allowed: str) -> Callable[[str], int]:
    """Parser of an integer in [low, high]."""

    def parse(text: str) -> int:
        try:
            value = int(text)
        except ValueError:
            value = low - 1
        if not low <= value <= high:
            raise argparse.ArgumentTypeError(f"got {text!r}, allowed: {allowed}")
        return value

    return parse


def _output(text: str) -> Path:
    try:
        return check_output(text)
    except InputError as error:
        raise argparse.ArgumentTypeError(str(error).removeprefix("output: ")) from None


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="sampler",
        description="Draw rebound states of non-spherical particles from a table.",
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.add_argument("--version", action="version", version=sampler.__version__)
    parser.add_argument(
        "--include-dir",
        action=_PrintIncludeDirectory,
        nargs=0,
        help="print the folder of rebound_sampler.h and rebound_sampler.f90, and exit",
    )
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    draw = commands.add_parser(
        "draw",
        help="draw states at one impact angle and speed",
        description="Draw rebound states at one impact angle and speed.",
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    draw.add_argument("table", metavar="TABLE", help="name of a table, or path of a .h5 file")
    angle = _number(0.0, 90.0, "degrees above 0, at most 90")
    speed = _number(0.0, sys.float_info.max, "m/s above 0, finite")
    count = _integer(1, 2**63 - 1, "a whole number from 1")
    seed = _integer(0, 2**64 - 1, "a whole number from 0 to 2**64 - 1")
    add = draw.add_argument
    add("--alpha", required=True, type=angle, metavar="DEG", help="impact angle from the wall")
    add("--speed", required=True, type=speed, metavar="M_S", help="impact speed")
    add("--count", required=True, type=count, metavar="N", help="number of states")
    add("--seed", required=True, type=seed, metavar="S", help="seed of the random numbers")
    add("--output", required=True, type=_output, metavar="F.npz", help="file to write")
    add(
        "--outside",
        choices=("clamp", "raise"),
        default="clamp",
        help="outside the table's range: use its edge and say so (default), or stop",
    )
    return parser


def _range_text(table: Table) -> str:
    low, high = np.rad2deg(table.alpha_range)
    return f"{low:g} to {high:g} deg, {table.speed_range[0]:g} to {table.speed_range[1]:g} m/s"


def _draw(arguments: argparse.Namespace) -> None:
    """Run ``sampler draw``."""
    table = load(arguments.table, outside="clamp")
    alpha1 = math.radians(arguments.alpha)
    given = f"{arguments.alpha:g} deg, {arguments.speed:g} m/s"
    outside_alpha = is_outside(alpha1, table.arrays.alpha)
    if outside_alpha or is_outside(arguments.speed, table.arrays.speed):
        if arguments.outside == "raise":
            flag, value = (
                ("alpha", arguments.alpha) if outside_alpha else ("speed", arguments.speed)
            )
            raise InputError(f"argument --{flag}: got {value:g}, allowed: {_range_text(table)}")
        sys.stderr.write(
            f"sampler: note: {given} is outside the table ({_range_text(table)}), "
            "its nearest condition is used\n"
        )
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", OutsideTableWarning)  # the note has said it
            state = table.sample(
                alpha1, arguments.speed, seed=arguments.seed, index=_indices(arguments.count)
            )
    except MemoryError:
        raise InputError(
            f"argument --count: got {arguments.count}, allowed: as many states as fit into "
            "memory, 48 bytes each"
        ) from None
    with atomic_output(arguments.output) as temporary, open(temporary, "wb") as file:
        # An open file, because numpy would add a suffix to a name.
        np.savez(file, state=state)


def _indices(count: int) -> np.ndarray:
    """Identities 0 to count - 1; numpy has two errors for a count that is too large."""
    try:
        return np.arange(count, dtype=np.uint64)
    except ValueError:
        raise MemoryError from None


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
        _draw(_parser().parse_args(argv))
    except InputError as error:
        sys.stderr.write(f"sampler: error: {error}\n")
        return BAD_INPUT
    return 0
