"""What decides the result of a task besides its arguments: our sources and the libraries below.

Results of other software are neither resumed from nor accepted from a worker. The kind of
processor (`tablegen.tasks.processor_kind`) decides no more than last digits; it is recorded.
"""

import hashlib
import platform
from functools import cache
from importlib import metadata
from pathlib import Path

import sampler

#: Packages that take part in the arithmetic. The C library has the elementary functions.
_LIBRARIES = ("llvmlite", "numba", "numpy", "scikit-learn", "scipy")


@cache
def _sources() -> str:
    """First digits of the SHA-256 of all modules of both packages."""
    digest = hashlib.sha256()
    for package in (Path(sampler.__file__).parent, Path(__file__).parents[1]):
        for path in sorted(package.rglob("*.py")):
            digest.update(f"{path.relative_to(package.parent)}\0".encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()[:12]


@cache
def _libraries() -> str:
    versions = [f"{name} {metadata.version(name)}" for name in _LIBRARIES]
    return ", ".join([*versions, " ".join(platform.libc_ver()), platform.machine()])


def software() -> str:
    """Versions of all software that results depend on, in one line.

    Two machines with the same line compute the same results, and the same bytes if their processors
    are of one kind: see `tablegen.tasks.processor_kind.processor_kind`.
    """
    return f"rebound-tables {sampler.__version__} (sources {_sources()}), {_libraries()}"
