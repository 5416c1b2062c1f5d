"""What does the work of a command is imported when the command is run, here and nowhere else."""

from importlib import import_module
from typing import Any


def work(module: str, *context: Any, **given: Any) -> int:
    """Run a command.

    Parameters
    ----------
    module : str
        Module whose function ``run`` does the work.
    *context, **given
        What that function gets: an object of the program, and the values of the options.

    Returns
    -------
    int
        Exit status.
    """
    status: int = import_module(module).run(*context, **given)
    return status
