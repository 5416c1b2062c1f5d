"""Names in docstrings and comments, such as `sampler.drawing.batch.draw_batch`, exist."""

import importlib
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
REFERENCE = re.compile(r"`((?:sampler|tablegen)(?:\.\w+)+)`")


def _references():
    """Every dotted name in back-quotes, and a file that has it."""
    found = {}
    for package in ("sampler", "tablegen"):
        for path in sorted((ROOT / package).rglob("*.py")):
            for name in REFERENCE.findall(path.read_text(encoding="utf-8")):
                found.setdefault(name, path.relative_to(ROOT))
    return found


def _exists(name):
    """Whether the name is a module, or an attribute of what comes before its last dot."""
    try:
        importlib.import_module(name)
        return True
    except ImportError:
        pass
    owner, _, last = name.rpartition(".")
    if not owner:
        return False
    try:
        return hasattr(importlib.import_module(owner), last)
    except ImportError:  # the owner is a class
        module, _, holder = owner.rpartition(".")
        return hasattr(getattr(importlib.import_module(module), holder, None), last)


def test_names_referred_to_exist():
    found = _references()
    assert len(found) > 20
    wrong = [f"{path}: `{name}`" for name, path in found.items() if not _exists(name)]
    assert wrong == []


@pytest.mark.parametrize(
    "name", ["sampler.drawing.kernel.draw_batch", "sampler.nowhere", "sampler.Table.x"]
)
def test_missing_names_are_seen(name):
    assert not _exists(name)
