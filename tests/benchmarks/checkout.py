"""Lets the benchmarks run from a checkout; imported for that, before anything of the project."""

import runpy
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
_TESTS = HERE.parent

for _folder in (_TESTS / "reference", _TESTS.parent):
    sys.path.insert(0, str(_folder))

# Compiled kernels are cached in a folder of their own for each state of the sources. Timing stale
# ones would be worse than a test that meets them.
runpy.run_path(str(_TESTS / "conftest.py"))
