from types import SimpleNamespace

import pytest
from command_line import BAD_INPUT
from tiny_tables import GENERATE, MEASURED, TINY, Tiny

from tablegen.accuracy.measure import measure
from tablegen.commands.main import main
from tablegen.generate import generate


@pytest.fixture
def quick_measurement(monkeypatch):
    """New tables are measured with fewer states, which takes seconds off each."""

    def few(*arguments, **settings):
        return measure(*arguments, **settings | {"samples": MEASURED})

    monkeypatch.setattr(GENERATE, "measure", few)


@pytest.fixture
def quick_classifier(monkeypatch):
    """Few trees, where it does not matter how well they tell a table from direct simulation."""
    monkeypatch.setattr("tablegen.accuracy.metrics.TREES", 20)


@pytest.fixture(scope="session")
def tiny(tmp_path_factory):
    """The tiny table, made once."""
    path = tmp_path_factory.mktemp("tables") / "tiny.h5"
    return Tiny(path, generate(TINY, path, conditions=2, samples=MEASURED))


@pytest.fixture
def terminal(monkeypatch):
    """Progress is shown as on a terminal."""
    monkeypatch.setattr("tablegen.tasks.progress.draws_over", lambda file: True)


@pytest.fixture
def run(capsys):
    """Run the command line in this process: status, standard output, standard error."""

    def runner(*arguments):
        status = main([str(argument) for argument in arguments])
        captured = capsys.readouterr()
        return SimpleNamespace(status=status, out=captured.out, err=captured.err)

    return runner


@pytest.fixture
def refused(run, tmp_path):
    """Run what must be refused: one line, and the folder as it was. Returns the line."""

    def runner(*arguments):
        before = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*")}
        ended = run(*arguments)
        assert ended.status == BAD_INPUT
        assert ended.out == ""
        assert ended.err.count("\n") == 1
        assert ended.err.endswith("\n")
        assert {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*")} == before
        assert ended.err.startswith("tablegen: error: ")
        return ended.err.removeprefix("tablegen: error: ").rstrip("\n")

    return runner
