"""The program ``tablegen``, which says what it needs where only the runtime is installed."""

import sys
from collections.abc import Sequence
from importlib import import_module

from tablegen.configuration.requirements import require_generator

#: Exit status for bad input.
BAD_INPUT = 2


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit status.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments; those of the process if left out.
    """
    try:
        require_generator()
    except ImportError as error:
        sys.stderr.write(f"tablegen: error: {error}\n")
        return BAD_INPUT
    status: int = import_module("tablegen.commands.main").main(argv)
    return status
