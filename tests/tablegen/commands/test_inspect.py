"""``tablegen inspect``: what a table is, for people and for programs."""

import json
from dataclasses import replace

import numpy as np
from command_line import DONE
from corrupt_tables import declaring, forged
from tiny_tables import TINY

import sampler
from sampler.formats.hdf5 import write_table
from tablegen.commands.inspect import identity, identity_text
from tablegen.config.metric_table import PRESETS


def test_says_what_the_table_is(run, tiny):
    ended = run("inspect", tiny.path)
    assert (ended.status, ended.err) == (DONE, "")
    table = sampler.load(tiny.path)
    for words in (
        "corundum-steel",
        "35 to 45 degrees, 2 nodes",
        "60 to 300 m/s, 2 nodes",
        "16 components",
        table.contents.content_sha256,
        "at 2 conditions between nodes",
        f"AUC {table.accuracy['auc'].max():.3f}",
        "at most KS 0.1500, sliced Wasserstein 0.1500, correlation 0.3000, AUC 0.800",
    ):
        assert words in ended.out


def test_prints_the_configuration(run, tiny):
    assert run("inspect", tiny.path, "--config").out == TINY.text + "\n"


def test_json_has_what_the_table_has(run, tiny):
    ended = run("inspect", tiny.path, "--json")
    assert (ended.status, ended.err) == (DONE, "")
    facts, table = json.loads(ended.out), sampler.load(tiny.path)
    assert facts["pair"] == "corundum-steel"
    assert facts["components"] == list(table.columns)
    assert facts["alpha_deg"] == [35.0, 45.0]
    assert facts["speed"] == [60.0, 300.0]
    assert facts["mixture_components"] == table.arrays.n_components
    assert facts["content_sha256"] == table.contents.content_sha256
    assert facts["bytes_in_memory"] == table.nbytes
    assert facts["accuracy"].keys() == table.accuracy.keys()
    for name, values in table.accuracy.items():
        np.testing.assert_array_equal(facts["accuracy"][name], values)
    assert facts["declared"] == {name: getattr(TINY.accuracy, name) for name in facts["worst"]}
    assert facts["worst"]["ks"] == table.accuracy["ks"].max()


def test_json_of_a_table_of_which_nothing_was_measured(run, tmp_path):
    pruned = tmp_path / "pruned.h5"
    words = ("prune", "corundum-steel", "--scene", "plane-flow", "--output", pruned)
    assert run(*words).status == DONE
    facts = json.loads(run("inspect", pruned, "--json").out)
    assert facts["components"] == ["u", "v", "omega_z"]
    assert facts["worst"] is None
    assert facts["accuracy"]["auc"] == []
    assert "measured          nothing" in run("inspect", pruned).out


def test_json_and_configuration_are_one_too_many(refused, tiny):
    assert refused("inspect", tiny.path, "--json", "--config") == (
        "--json: got it with --config, allowed: one of them"
    )


def test_declarations_that_say_little_are_noted(run, tiny, tmp_path):
    contents, path = tiny.generated.table.contents, tmp_path / "t.h5"
    write_table(path, forged(contents))
    said = run("inspect", path).out
    assert "declared          at most KS 1.0000, sliced Wasserstein 1000000.0000," in said
    assert "note              the table declares little: ks 1, sliced_wasserstein 1e+06," in said
    write_table(path, declaring(contents, ks=0.001))
    assert (
        "note              the file stores more than it declares: KS 0." in run("inspect", path).out
    )
    assert "note  " not in run("inspect", "corundum-steel").out


def test_declared_accuracy_of_a_preset_and_of_nonsense(tiny):
    contents = tiny.generated.table.contents
    compact = replace(contents, config='accuracy.preset = "compact"\naccuracy.ks = 0.5')
    assert identity(compact)["declared"] == {**PRESETS["compact"], "ks": 0.5}
    for text in ("no toml", "accuracy = 1", 'accuracy.ks = "small"', "accuracy.ks = []"):
        unreadable = replace(contents, config=text)
        assert identity(unreadable)["declared"] is None
        assert "declared          ?" in identity_text(unreadable)
