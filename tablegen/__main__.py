"""The program ``tablegen``, and ``python -m tablegen``."""

import os
import sys
from typing import NoReturn


def run() -> NoReturn:
    """Run the program and end the process with its exit status."""
    from sampler.options import INTERRUPTED
    from tablegen.commands.main import main

    status = main()
    if status == INTERRUPTED:  # threads that still work are not waited for
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)
    sys.exit(status)


if __name__ == "__main__":
    run()
