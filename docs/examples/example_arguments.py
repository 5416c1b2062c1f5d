"""Command lines of the examples: types of arguments, and mistakes that end with one line.

parser = Parser(__file__, __doc__)
parser.add_table("--table", "corundum-steel")
parser.add_number("--grains", 10_000, "number of grains under each law")
args = parser.parse_args()  # args.grains is an int, args.table a `sampler.Table`
"""

import argparse
import math
import sys
from pathlib import Path

import sampler
import tablegen


def refuse(text, allowed):
    """Refuse the text of an argument."""
    raise argparse.ArgumentTypeError(f"got {text}, allowed: {allowed}")


def whole_number(least, most=2**32 - 1):
    """Make a type of whole numbers in a range."""

    def parse(text):
        if not (text.isascii() and text.isdecimal() and least <= int(text) <= most):
            refuse(text, f"whole numbers from {least} to {most}")
        return int(text)

    return parse


def length(text):
    """Return a length in metres, or whatever unit the help names."""
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not 0.0 < number < math.inf:
        refuse(text, "numbers above 0")
    return number


def table_with_spin(text):
    """Load a table by its name or path; it must have a spin law."""
    try:
        table = sampler.load(text)
    except (sampler.InputError, OSError) as error:
        raise argparse.ArgumentTypeError(str(error)) from None
    if not table.has_spin:
        refuse(text, "tables with a spin law")
    return table


def table_with_works(text):
    """Load a table by its name or path; it must have a spin law and both works."""
    table = table_with_spin(text)
    if not {"work_normal", "work_shear"} <= set(table.columns):
        refuse(text, "tables with works, such as corundum-steel-wear")
    return table


def pair(text):
    """Return the name or path of a configuration, and the configuration."""
    try:
        return text, tablegen.load_config(text)
    except (sampler.InputError, OSError) as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def output_file(text):
    """Return the path of a file to write, whose folder must exist."""
    path = Path(text)
    if not path.absolute().parent.is_dir():
        refuse(text, "a file in a folder that exists")
    return path


def folder(text):
    """Return the path of a folder that exists."""
    if not Path(text).is_dir():
        refuse(text, "a folder that exists")
    return Path(text)


class Parser(argparse.ArgumentParser):
    """A parser whose errors are one line on standard error, with the exit status 2."""

    def __init__(self, path, docstring):
        """Name the program after its file, and describe it by the first line of its docstring."""
        super().__init__(prog=Path(path).name, description=docstring.splitlines()[0])

    def error(self, message):
        """End the program."""
        print(f"{self.prog}: {message}", file=sys.stderr)
        sys.exit(2)

    def add_table(
        self, flag, default, parse=table_with_spin, description="name, or path of a .h5 file"
    ):
        """Add an argument that names a table; by default it must have a spin law."""
        self.add_argument(flag, type=parse, default=default, metavar="TABLE", help=description)

    def add_number(self, flag, default, description, least=1):
        """Add an argument that is a whole number, as of grains."""
        parse = whole_number(least)
        self.add_argument(flag, type=parse, default=default, metavar="N", help=description)

    def add_figure(self, flag):
        """Add an argument that names the picture to write."""
        self.add_argument(flag, type=output_file, metavar="F.png", help="picture to write")
