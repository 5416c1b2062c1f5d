"""A mistake in the arguments of an example ends it with one line and the exit status 2."""

import importlib

import pytest


@pytest.mark.parametrize(
    ("example", "words", "named"),
    [
        ("bend", ["--count", "0"], "--count: got 0, allowed: whole numbers from 20"),
        ("bend", ["--diameter", "nan"], "--diameter: got nan, allowed: numbers above 0"),
        ("bend", ["--table", "no-such-table"], "--table"),
        ("cyclone", ["--grains", "0"], "--grains: got 0"),
        ("cyclone", ["--grains", "many"], "--grains: got many"),
        ("cyclone", ["--seed", "-1"], "--seed: got -1"),
        ("cyclone", ["--compact", "no/such/table.h5"], "--compact"),
        ("cyclone", ["--picture", "no/such/folder/c.png"], "--picture: got no/such/folder/c.png"),
        ("how_sure", ["--pairs", "corundum-steel", "no-such-pair"], "--pairs"),
        ("how_sure", ["--seed", "1.5"], "--seed: got 1.5"),
        ("openfoam_bend", ["no/such/folder"], "folder: got no/such/folder"),
        ("wall_cost", ["--grains", "0"], "--grains: got 0"),
        ("wall_laws", ["--sizes", "50"], "--sizes: give two or more increasing diameters"),
        ("wall_laws", ["--sizes", "60", "50"], "--sizes"),
        ("wall_laws", ["--output", "nowhere"], "--output: got nowhere"),
        ("wear", ["--table", "corundum-steel"], "--table: got corundum-steel, allowed: tables"),
    ],
)
def test_a_mistake_is_one_line(example, words, named, capsys):
    with pytest.raises(SystemExit, match="2"):
        importlib.import_module(example).main(words)
    error = capsys.readouterr().err
    assert error.startswith(f"{example}.py: ")
    assert named in error
    assert error.count("\n") == 1
