"""Work of ``sampler list`` and ``tablegen list``."""

import json
import sys

from sampler.commands.catalogue import catalogue, catalogue_text


def run(as_json: bool) -> int:
    """Print what comes with the package; parameters are the options."""
    found = catalogue()
    text = json.dumps(found, indent=1) if as_json else catalogue_text(found)
    sys.stdout.write(f"{text}\n")
    return 0
