"""Run the command line: ``python -m tablegen``."""

import sys

from tablegen.commands.main import main

if __name__ == "__main__":
    sys.exit(main())
