"""Numba caches a kernel by its own file and does not see edits in the kernels that it calls.

A cache folder named after all sources keeps a test run from meeting stale kernels.
"""

import hashlib
import os
import tempfile
from pathlib import Path

_ROOT = Path(__file__).resolve().parents[1]
_digest = hashlib.sha256()
for _source in sorted(
    _p for _d in ("sampler", "tablegen", "tests") for _p in _ROOT.glob(f"{_d}/**/*.py")
):
    _digest.update(_source.read_bytes())
_folder = f"rebound-tables-{os.getuid()}-{_digest.hexdigest()[:16]}"
os.environ.setdefault("NUMBA_CACHE_DIR", str(Path(tempfile.gettempdir()) / _folder))
