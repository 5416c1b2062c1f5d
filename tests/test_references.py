"""Names in docstrings and comments, such as `sampler.drawing.batch.draw_batch`, exist."""

import pkgutil
import re

import pytest
from documents import ROOT

REFERENCE = re.compile(r"`((?:sampler|tablegen)(?:\.\w+)+)`")


def _exists(name):
    """Whether the name is a module, or an attribute of one, or of a class in one."""
    try:
        pkgutil.resolve_name(name)
    except (ImportError, AttributeError):
        return False
    return True


def test_names_referred_to_exist():
    found = {
        (name, path.relative_to(ROOT))
        for package in ("sampler", "tablegen")
        for path in (ROOT / package).rglob("*.py")
        for name in REFERENCE.findall(path.read_text(encoding="utf-8"))
    }
    assert len(found) > 20
    assert not [(str(path), name) for name, path in found if not _exists(name)]


@pytest.mark.parametrize(
    "name", ["sampler.drawing.kernel.draw_batch", "sampler.nowhere", "sampler.Table.x"]
)
def test_missing_names_are_seen(name):
    assert not _exists(name)
