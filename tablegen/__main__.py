"""The program ``tablegen``, and ``python -m tablegen``."""

from typing import NoReturn

from sampler.commands.process import run_process


def run() -> NoReturn:
    """Run the program."""
    run_process("tablegen")


if __name__ == "__main__":
    run()
