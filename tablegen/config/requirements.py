"""Whether the packages of the generator are there; the runtime is installed without them."""

from importlib.util import find_spec

#: Names under which the packages of the extra ``generate`` are imported.
GENERATOR = (
    "jinja2",
    "pydantic",
    "scipy",
    "sklearn",
    "threadpoolctl",
    "tomli_w",
    "tqdm",
    "trimesh",
)

_LINE = "the generator is not installed, allowed after: pip install 'rebound-tables[generate]'"


def require_generator() -> None:
    """Check that the generator can run.

    Raises
    ------
    ImportError
        If a package of the extra ``generate`` is not installed; with the command that brings it.
    """
    if missing := [name for name in GENERATOR if find_spec(name) is None]:
        raise ImportError(_LINE, name=missing[0])
