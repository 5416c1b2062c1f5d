"""An error is a record, whose sentence is made where it is shown."""

import ast
import copy
import pickle
import warnings
from pathlib import Path

import numpy as np
import pytest

import sampler
from sampler.errors import CODES, InputError, OutsideTableWarning, TableError

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize(
    ("error", "line"),
    [
        (InputError("speed", 0.0, "above 0 m/s"), "speed: got 0.0, allowed: above 0 m/s"),
        (
            InputError("speed", 0.0, "above 0", row=3, particle=9),
            "speed: got 0.0 at row 3 (particle 9), allowed: above 0",
        ),
        (
            InputError("ra", "nan", "numbers", row=(0, 2)),
            "ra: got nan at index (0, 2), allowed: numbers",
        ),
        (
            InputError("to_device", problem="CuPy is not installed", remedy="run: pip install x"),
            "to_device: CuPy is not installed; run: pip install x",
        ),
        (
            TableError("axes/speed", 1, "2").within("t.h5"),
            "t.h5: axes/speed: got 1, allowed: 2",
        ),
        (
            InputError("a", 1, "2", further=(InputError("b", problem="is missing"),)),
            "a: got 1, allowed: 2; b: is missing",
        ),
    ],
)
def test_the_sentence_has_what_the_fields_have(error, line):
    assert str(error) == line
    for other in (pickle.loads(pickle.dumps(error)), copy.copy(error), error.replaced()):
        assert (type(other), other.__dict__.keys(), str(other)) == (
            type(error),
            error.__dict__.keys(),
            line,
        )


def test_the_first_refused_row_and_its_particle_are_fields(table_path):
    table = sampler.load(table_path)
    speed = np.full((4, 5), 100.0)
    speed[2, 3] = speed[3, 0] = -1.0
    index = np.arange(100, 120).reshape(4, 5)
    with pytest.raises(InputError) as refusal:
        table.sample(0.7, speed, seed=1, index=index)
    error = refusal.value
    assert (error.argument, error.row, error.particle) == ("speed", (2, 3), 113)
    assert speed[error.row] == float(error.given) == -1.0


def test_a_warning_has_the_first_row_outside(table_path):
    with pytest.warns(OutsideTableWarning) as warned:
        sampler.load(table_path).sample(0.7, [100.0, 1e4, 2e4], seed=1, index=[5, 6, 7])
    (message,) = (one.message for one in warned)
    assert (message.kind, message.number) == ("speed", 2)
    assert (message.first.argument, message.first.row, message.first.particle) == ("speed", 1, 6)
    # programs that give a warning again make it of its text, as `warnings.warn` does with a text
    with pytest.warns(OutsideTableWarning) as again:
        warnings.warn(str(message), type(message), stacklevel=1)
    assert str(again[0].message) == str(message)


def test_texts_of_codes_are_sentences_that_no_code_reads():
    for code in CODES:
        assert "allowed:" not in code.text, code
        assert not code.text.endswith((".", ";")), code


def test_every_error_is_made_of_fields():
    """Never of a sentence in the place of the argument."""
    calls = 0
    for path in [*ROOT.glob("sampler/**/*.py"), *ROOT.glob("tablegen/**/*.py")]:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Name)):
                continue
            if node.func.id in ("InputError", "TableError"):
                calls += 1
                named = {keyword.arg for keyword in node.keywords}
                assert len(node.args) >= 2 or "problem" in named, f"{path}:{node.lineno}"
    assert calls > 100
