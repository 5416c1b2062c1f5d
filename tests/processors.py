"""Processors that this machine can imitate, to see what changes on them.

    python tests/processors.py PROCESSOR COMMAND...

runs a command as on another processor, for example
``python tests/processors.py avx2 pytest -m processor``. PROCESSOR is one of `SETTINGS`:

- ``avx2``, processors with AVX2 and FMA but without AVX-512;
- ``x86-64``, the least that there is, for all but the C library;
- ``no-fma``, the same for the C library too. Direct simulation then takes a thousand times as long,
  as it asks the C library for every fused product and sum: it is for tests of draws.

`.ci/run` does this for all, and tests/test_imitated_processors.py looks whether it switches
anything. What environment variables can switch:

- numpy: the instruction sets above those that its wheels are built for (SSE4.2, or SSE3 before
  numpy 2.4), by NPY_DISABLE_CPU_FEATURES;
- OpenBLAS, numpy's and scipy's: the kernels of a processor type, by OPENBLAS_CORETYPE;
- numba: what LLVM compiles for, by NUMBA_CPU_NAME. Compiled kernels are kept apart by this name;
- the C library (``no-fma`` only): its functions with FMA and AVX, by GLIBC_TUNABLES.

Not switched: what gcc and clang compile for ``-march=native`` and the copies of a function that the
C header lets the loader choose from, which the tests of the header compare by compiler flags;
instructions of memory copies; and Python itself, scipy and scikit-learn, which are built once for
all processors.
"""

import hashlib
import json
import math
import os
import platform
import shutil
import sys
from typing import NamedTuple

import numpy as np

#: Spellings of the C library before and since version 2.33; it takes no notice of unknown ones.
_NO_FMA = ",".join(
    f"-{name}{suffix}" for suffix in ("", "_Usable") for name in ("AVX", "AVX2", "FMA", "FMA4")
)


#: Environment variable with the name of the processor that a process runs as on.
IMITATED = "IMITATED_PROCESSOR"


class Processor(NamedTuple):
    """Processor to be imitated: how the libraries name it.

    ``above`` has the beginnings of the names of numpy's instruction sets that it lacks, ``blas``
    the type asked of OpenBLAS and those that OpenBLAS may then report.
    """

    above: tuple[str, ...]
    blas: tuple[str, ...]
    llvm: str
    tunables: str | None = None


_LEAST = Processor(
    ("AVX", "F16C", "FMA", "X86_V3", "X86_V4"),
    ("Prescott", "Katmai", "Core2", "Nehalem"),
    "x86-64",
)

SETTINGS = {
    "avx2": Processor(("AVX512", "X86_V4"), ("Haswell",), "haswell"),
    "x86-64": _LEAST,
    "no-fma": _LEAST._replace(tunables=f"glibc.cpu.hwcaps={_NO_FMA}"),
}


def numpy_features():
    """Instruction sets that numpy uses here beyond those that it is built for."""
    return np.show_config(mode="dicts")["SIMD Extensions"].get("found", [])


def environment(name):
    """Environment variables that imitate a processor, as a change to the present ones.

    Raises
    ------
    SystemExit
        Where the processor cannot be imitated.
    """
    if platform.machine() not in ("x86_64", "AMD64"):
        sys.exit(f"machine: got {platform.machine()}, allowed: x86_64")
    processor = SETTINGS[name]
    disabled = [f for f in numpy_features() if f.startswith(processor.above)]
    settings = {
        "NPY_DISABLE_CPU_FEATURES": " ".join(disabled),
        "OPENBLAS_CORETYPE": processor.blas[0],
        "NUMBA_CPU_NAME": processor.llvm,
        "NUMBA_CPU_FEATURES": "",  # those of the name
        IMITATED: name,
    }
    return settings | ({"GLIBC_TUNABLES": processor.tunables} if processor.tunables else {})


def as_it_is():
    """Environment of this process without what imitates a processor."""
    names = set().union(*(environment(name) for name in SETTINGS))
    return {name: value for name, value in os.environ.items() if name not in names}


def seen():
    """What the libraries see in this process, and a checksum of values of the C library."""
    import scipy.linalg  # noqa: F401  (loads its own OpenBLAS)
    from numba.core.registry import cpu_target
    from threadpoolctl import threadpool_info

    values = [f(k / 1024) for f in (math.exp, math.sin, math.atan) for k in range(1, 1024)]
    blas = [found for found in threadpool_info() if found["user_api"] == "blas"]
    return {
        "numpy": numpy_features(),
        "blas": sorted({found.get("architecture", "unknown") for found in blas}),
        "numba": cpu_target.target_context.codegen().magic_tuple()[1],
        "libm": hashlib.sha256(np.array(values).tobytes()).hexdigest(),
    }


def unswitched(name, found):
    """Libraries that do not see the processor, of what `seen` found."""
    processor = SETTINGS[name]
    holds = {
        "numpy": not any(feature.startswith(processor.above) for feature in found["numpy"]),
        "blas": set(found["blas"]) <= set(processor.blas),
        "numba": found["numba"] == processor.llvm,
    }
    return [library for library, switched in holds.items() if not switched]


def main(words):
    """Replace this process by the command, as on the processor."""
    if words == ["seen"]:
        print(json.dumps(seen()))
        return
    if len(words) < 2 or words[0] not in SETTINGS:
        sys.exit(f"usage: processors.py {'|'.join(SETTINGS)} COMMAND...")
    name, *command = words
    if shutil.which(command[0]) is None:
        sys.exit(f"COMMAND: got {command[0]}, allowed: a program on PATH")
    os.execvpe(command[0], command, os.environ | environment(name))


if __name__ == "__main__":
    main(sys.argv[1:])
