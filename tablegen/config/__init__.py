"""Configurations: material pairs, scenes, populations and laws as checked records."""

from importlib.util import find_spec

#: Import names of the packages that the extra ``generate`` brings.
GENERATOR = (
    "llvmlite",
    "numba",
    "pydantic",
    "scipy",
    "sklearn",
    "threadpoolctl",
    "tomli_w",
    "tqdm",
    "trimesh",
)


def require_generator() -> None:
    """Raise ImportError, with the command that helps, if a package of the generator is missing."""
    if missing := [name for name in GENERATOR if find_spec(name) is None]:
        raise ImportError(
            "the generator is not installed; run: pip install 'rebound-tables[generate]'",
            name=missing[0],
        )
