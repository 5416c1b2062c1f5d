"""Lets ``python docs/examples/many_hits`` run from a checkout."""

import runpy
import sys
from pathlib import Path

_HERE = Path(__file__).resolve().parent
_ROOT = _HERE.parents[2]

# In place of this folder, whose modules have common names.
sys.path[0] = str(_HERE.parent)
sys.path.insert(1, str(_ROOT))
# Compiled kernels are cached in a folder of their own for each state of the sources.
runpy.run_path(str(_ROOT / "tests" / "conftest.py"))

from many_hits.command import main  # noqa: E402  (after the paths that it needs)

sys.exit(main())
