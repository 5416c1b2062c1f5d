"""A mistake in the arguments of a study is named, and ends it with the exit status 2."""

import importlib

import pytest


@pytest.mark.parametrize(
    ("study", "words", "named"),
    [
        (
            "how_sure",
            ["--pairs", "corundum-steel", "no-such-pair"],
            "there is no .toml file 'no-such-pair'",
        ),
        ("hops", ["--grains", "0"], "argument --grains: give 1 or more"),
        ("hops", ["--tables", "nothing"], "there is no .h5 file 'nothing'"),
        ("how_sure", ["--seed", "1.5"], "argument --seed: invalid int value"),
        ("openfoam_bend", ["no/such/folder"], "there is no folder no/such/folder"),
        ("wall_cost", ["--grains", "0"], "argument --grains: give 1 or more"),
        ("wall_laws", ["--sizes", "50"], "--sizes: give two or more increasing diameters"),
        ("wall_laws", ["--sizes", "60", "50"], "--sizes: give two or more"),
        ("wavy_duct", ["--grains", "0"], "argument --grains: give 1 or more"),
        ("wavy_duct", ["--grains", "many"], "argument --grains: invalid int value: 'many'"),
        ("wavy_duct", ["--tables", "nothing"], "there is no .h5 file 'nothing'"),
        ("wear", ["--table", "corundum-steel"], "argument --table: it needs works"),
    ],
)
def test_a_mistake_is_named(study, words, named, capsys):
    with pytest.raises(SystemExit, match="2"):
        importlib.import_module(study).main(words)
    assert named in capsys.readouterr().err.splitlines()[-1]
