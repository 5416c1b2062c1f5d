import sys
from pathlib import Path

_TESTS = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(_TESTS.parent / "docs" / "examples"))
# What an example and the tests of OpenFOAM share.
sys.path.append(str(_TESTS / "openfoam"))
