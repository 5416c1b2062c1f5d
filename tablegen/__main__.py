"""The program ``tablegen``, and ``python -m tablegen``."""

import sys
from typing import NoReturn


def run() -> NoReturn:
    """Run the program and end the process with its exit status."""
    from tablegen.commands.main import main

    sys.exit(main())


if __name__ == "__main__":
    run()
