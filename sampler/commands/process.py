"""A program as a process of its own."""

import sys
from importlib import import_module
from typing import NoReturn

from sampler.commands.signals import ended_by_signals, ending, first_to_say, say


def run_process(program: str) -> NoReturn:
    """Run a program with the arguments of this process, and end with its exit status.

    Signals end it within a second, also while its modules are imported.

    Parameters
    ----------
    program : {"sampler", "tablegen"}
    """
    try:
        with ended_by_signals(program):
            status = import_module(f"{program}.commands.main").main()
    except KeyboardInterrupt:  # before the program could hear of it
        status, word = ending()
        if first_to_say():
            say(f"{program}: {word}")
    sys.exit(status)
