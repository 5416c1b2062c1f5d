"""The program ``sampler``, and ``python -m sampler``."""

import sys
from typing import NoReturn

from sampler.cli import main


def run() -> NoReturn:
    """Run the program and end the process with its exit status."""
    sys.exit(main())


if __name__ == "__main__":
    run()
