"""The program ``sampler``, and ``python -m sampler``."""

from typing import NoReturn

from sampler.commands.process import run_process


def run() -> NoReturn:
    """Run the program."""
    run_process("sampler")


if __name__ == "__main__":
    run()
