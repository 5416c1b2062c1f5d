"""``python -m sampler`` runs the command line."""

import sys

from sampler.commands.main import main

if __name__ == "__main__":
    sys.exit(main())
