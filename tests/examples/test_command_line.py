"""A mistake in the arguments of an example is named, and ends it with the exit status 2."""

import importlib

import pytest


@pytest.mark.parametrize(
    ("example", "words", "named"),
    [
        ("bend", ["--count", "0"], "give --count 20 or more"),
        ("bend", ["--diameter", "nan"], "a --diameter above 0"),
        (
            "bend",
            ["--table", "no-such-table"],
            "table: there is no .h5 file 'no-such-table'",
        ),
        ("cyclone", ["--grains", "0"], "give --grains 1 or more"),
        ("cyclone", ["--grains", "many"], "argument --grains: invalid int value: 'many'"),
        ("cyclone", ["--seed", "-1"], "--seed 0 or more"),
        ("cyclone", ["--compact", "no/such/table.h5"], "table: there is no file no/such/table.h5"),
    ],
)
def test_a_mistake_is_named(example, words, named, capsys):
    with pytest.raises(SystemExit, match="2"):
        importlib.import_module(example).main(words)
    assert named in capsys.readouterr().err.splitlines()[-1]
