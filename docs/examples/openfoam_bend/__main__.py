"""Lets ``python docs/examples/openfoam_bend`` run from a checkout."""

import runpy
import sys
from pathlib import Path

_HERE = Path(__file__).resolve().parent
_ROOT = _HERE.parents[2]

# In place of this folder, whose modules have common names.
sys.path[0] = str(_HERE.parent)
sys.path.insert(1, str(_ROOT))
# What runs OpenFOAM and reads its files is shared with the tests.
sys.path.insert(2, str(_ROOT / "tests" / "openfoam"))
# Compiled kernels are cached in a folder of their own for each state of the sources.
runpy.run_path(str(_ROOT / "tests" / "conftest.py"))

from openfoam_bend.command import main  # noqa: E402  (after the paths that it needs)

sys.exit(main())
