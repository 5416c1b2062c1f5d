"""Run a command as on a processor with AVX2 but without AVX-512.

    python tests/processors.py pytest -m processor

Environment variables switch numpy, OpenBLAS and numba to the instructions of such a processor.
"""

import os
import sys

import numpy as np


def environment():
    """Environment variables that imitate the processor."""
    features = np.show_config(mode="dicts")["SIMD Extensions"].get("found", [])
    disabled = [feature for feature in features if feature.startswith(("AVX512", "X86_V4"))]
    return {
        "NPY_DISABLE_CPU_FEATURES": " ".join(disabled),
        "OPENBLAS_CORETYPE": "Haswell",
        "NUMBA_CPU_NAME": "haswell",
        "NUMBA_CPU_FEATURES": "",  # those of the name
    }


if __name__ == "__main__":
    os.execvpe(sys.argv[1], sys.argv[1:], os.environ | environment())
