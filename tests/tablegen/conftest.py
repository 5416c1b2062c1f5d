import sys
from functools import partial
from pathlib import Path

import pytest
from tiny_tables import GENERATE, MEASURED, TINY, Tiny

from tablegen.accuracy.validate import validate_contents
from tablegen.tables import angle_path
from tablegen.tables.generate import generate

_TREES = "tablegen.accuracy.metrics.TREES"

# independent models, and the model one particle at a time
sys.path.append(str(Path(__file__).resolve().parents[1] / "reference"))


@pytest.fixture
def quick_measurement(monkeypatch):
    """Measure new tables with fewer states, which saves seconds for each table."""

    def few(*arguments, **settings):
        return validate_contents(*arguments, **settings | {"samples": MEASURED})

    monkeypatch.setattr(GENERATE, "validate_contents", few)


@pytest.fixture
def quick_classifier(monkeypatch):
    """Give the classifier few trees, for tests that do not depend on how well it works."""
    monkeypatch.setattr(_TREES, 20)


@pytest.fixture
def short_paths(monkeypatch):
    """Follow the path between nodes, which `test_angle_path` tests, by few particles.

    It saves half a second for each grid of the whole range of angles.
    """
    monkeypatch.setattr(angle_path, "_PARTICLES", 50)
    angle_path._divide_cell.cache_clear()
    yield
    angle_path._divide_cell.cache_clear()


@pytest.fixture(scope="session")
def tiny(tmp_path_factory):
    path = tmp_path_factory.mktemp("tables") / "tiny.h5"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(_TREES, 20)
        return Tiny(path, generate(TINY, path, conditions=2, samples=MEASURED))


@pytest.fixture
def terminal(monkeypatch):
    """Show progress as on a terminal."""
    monkeypatch.setattr("tablegen.progress.draws_over", lambda file: True)


@pytest.fixture
def run(call):
    """Run the command line in this process; return status, standard output and standard error."""
    return partial(call, "tablegen")


@pytest.fixture
def refused(refuse):
    """Run a command line that must be refused with one line and no new file; return the line."""
    return partial(refuse, "tablegen")
