from functools import partial

import pytest
from tiny_tables import GENERATE, MEASURED, TINY, Tiny

from tablegen.accuracy.validate import validate_contents
from tablegen.tables.generate import generate

_TREES = "tablegen.accuracy.metrics.TREES"


@pytest.fixture
def quick_measurement(monkeypatch):
    """New tables are measured with fewer states, which takes seconds off each."""

    def few(*arguments, **settings):
        return validate_contents(*arguments, **settings | {"samples": MEASURED})

    monkeypatch.setattr(GENERATE, "validate_contents", few)


@pytest.fixture
def quick_classifier(monkeypatch):
    """Few trees, where it does not matter how well they tell a table from direct simulation."""
    monkeypatch.setattr(_TREES, 20)


@pytest.fixture(scope="session")
def tiny(tmp_path_factory):
    path = tmp_path_factory.mktemp("tables") / "tiny.h5"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(_TREES, 20)
        return Tiny(path, generate(TINY, path, conditions=2, samples=MEASURED))


@pytest.fixture
def terminal(monkeypatch):
    """Progress is shown as on a terminal."""
    monkeypatch.setattr("tablegen.progress.draws_over", lambda file: True)


@pytest.fixture
def run(call):
    """Run the command line in this process: status, standard output, standard error."""
    return partial(call, "tablegen")


@pytest.fixture
def refused(refuse):
    """Run what must be refused: one line, and the folder as it was. Returns the line."""
    return partial(refuse, "tablegen")
