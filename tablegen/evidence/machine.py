"""What a timing was measured on: processor, operating system, versions."""

import platform
from collections.abc import Sequence
from importlib import metadata
from pathlib import Path
from typing import Any

from sampler.library import processors

#: Packages whose version decides what a rebound costs or how it comes out.
PACKAGES = (
    "numpy",
    "scipy",
    "numba",
    "llvmlite",
    "h5py",
    "scikit-learn",
    "pyvinecopulib",
    "matplotlib",
    "plotly",
)

_CPUINFO = Path("/proc/cpuinfo")


def processor() -> str:
    """Model name of the processor, or what the platform says where that is not known."""
    try:
        lines = _CPUINFO.read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(names, platform.processor() or platform.machine() or "unknown")


def versions(packages: Sequence[str] = PACKAGES) -> dict[str, str | None]:
    """Installed versions; None for a package that is not installed."""
    found: dict[str, str | None] = {}
    for name in packages:
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            found[name] = None
    return found


def machine() -> dict[str, Any]:
    """Describe this machine, without its name.

    Returns
    -------
    dict
        ``processor``, ``cores`` (that this process may use), ``system``, ``python`` and
        ``packages``, JSON-ready.
    """
    return {
        "processor": processor(),
        "cores": processors(),
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        "packages": versions(),
    }
