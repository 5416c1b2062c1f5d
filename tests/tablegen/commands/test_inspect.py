"""``tablegen inspect``: the description of a table, for people and for programs."""

import json
import math
import shutil
import subprocess
import sys
import tomllib
from dataclasses import replace
from pathlib import Path

from command_line import DONE
from corrupt_tables import declaring, forged
from tiny_tables import TINY

import sampler
from sampler.files import find_config, find_table
from sampler.formats.hdf5 import read_table, write_table
from tablegen.commands.inspect import identity, identity_text
from tablegen.config.config import load_config, parse_config
from tablegen.config.metric_table import PRESETS
from tablegen.model.contact_laws import exponential_restitution
from tablegen.tables.prune import prune


def test_describes_the_table(run, tiny):
    ended, table = run("inspect", tiny.path), sampler.load(tiny.path)
    assert (ended.status, ended.err) == (DONE, "")
    largest = f"AUC {table.accuracy['auc'].max():.3f}"
    for words in ("35 to 45 deg, 60 to 300 m/s", table.content_sha256, largest):
        assert words in ended.out
    written = run("inspect", tiny.path, "--config").out
    assert written.startswith("# For another pair change the name.")
    assert "\nspeed_nodes = [60.0, 300.0]\n" in written
    expected = tomllib.loads(TINY.text)
    expected["name"] = expected["pair"].pop("name")
    assert tomllib.loads(written) == expected


def test_who_changes_the_name_of_a_configuration_has_another_pair(run):
    written = run("inspect", "corundum-steel", "--config").out
    assert written.count("corundum-steel") == 1
    assert parse_config(written, "mine").pair_name == "corundum-steel"
    changed = written.replace("corundum-steel", "mine")
    assert parse_config(changed, "mine").pair_name == "mine"


def test_json_has_what_the_table_has(run, refused, tiny):
    facts, table = json.loads(run("inspect", tiny.path, "--json").out), sampler.load(tiny.path)
    assert facts["variables"] == list(table.columns)
    assert (facts["alpha_deg"], facts["speed"]) == ([35.0, 45.0], [60.0, 300.0])
    assert facts["bytes_in_memory"] == table.nbytes
    assert facts["accuracy"] == {name: x.tolist() for name, x in table.accuracy.items()}
    assert facts["declared"] == {name: getattr(TINY.accuracy, name) for name in facts["worst"]}
    assert facts["worst"]["ks"] == table.accuracy["ks"].max()
    assert refused("inspect", tiny.path, "--json", "--config").startswith(
        "--json: is given with --config"
    )


def test_a_table_without_measured_accuracy(run, tiny, tmp_path):
    pruned = tmp_path / "pruned.h5"
    prune(tiny.path, TINY.with_changes({"domain": {"variables": ["u", "v"]}}), pruned)
    facts = json.loads(run("inspect", pruned, "--json").out)
    assert (facts["worst"], facts["accuracy"]["auc"]) == (None, [])
    assert "measured          nothing" in run("inspect", pruned).out


def test_loose_and_missed_declarations_are_noted(run, tiny, tmp_path):
    contents, path = read_table(tiny.path), tmp_path / "t.h5"
    write_table(path, forged(contents))
    assert "declares little accuracy: ks 1, sliced_wasserstein 1e+06," in run("inspect", path).out
    write_table(path, declaring(contents, ks=0.001))
    assert "the stored accuracy is worse than the declared one: KS 0." in run("inspect", path).out
    assert "note  " not in run("inspect", "corundum-steel").out


def test_accuracy_of_the_spin_law_stands_beside_that_of_first_impacts(run):
    table = read_table(find_table("corundum-steel-compact"))
    line = next(
        x for x in run("inspect", "corundum-steel-compact").out.splitlines() if "of the spi" in x
    )
    for name, words in (("ks", "KS {:.4f}"), ("chain_angle", "angle of chains {:.4f}")):
        assert words.format(table[f"spin_accuracy/{name}"].max()) in line


def test_declared_accuracy_of_a_preset_and_of_nonsense(tiny):
    contents = read_table(tiny.path)
    compact = replace(contents, config='accuracy.preset = "compact"\naccuracy.ks = 0.5')
    assert identity(compact)["declared"] == {**PRESETS["compact"], "ks": 0.5}
    unreadable = replace(contents, config='accuracy.ks = "small"')
    assert "declared          cannot be read" in identity_text(unreadable)


def test_script(tiny, tmp_path):
    """The installed script runs in its own process, in a folder outside the source tree."""
    script = shutil.which("tablegen", path=str(Path(sys.executable).parent))
    assert script, "the package is not installed in this environment"
    words = [script, "inspect", str(tiny.path)]
    assert "corundum-steel" in subprocess.check_output(words, cwd=tmp_path, text=True)


def test_shows_the_laws_of_a_pair(run, refused, tmp_path):
    """A law in the wrong unit is seen at once, because the numbers that it gives are printed."""
    pair = shutil.copy(find_config("corundum-steel"), tmp_path / "pair.toml")
    ended, (slow, fast) = run("inspect", pair), load_config(pair).domain.speed
    assert ended.status == DONE
    for angle in (10, 45, 90):
        row = next(line.split() for line in ended.out.splitlines() if line.startswith(f"{angle} "))
        sine = math.sin(math.radians(angle))
        expected = [exponential_restitution(0.1, 0.61, v, sine) for v in (slow, fast)]
        assert [row[1], row[3]] == [f"{x:.4f}" for x in expected]
        assert row[4] == f"{math.exp(sine):.4f}"  # equation 7, whose strength and factor are 1
    assert "--json: needs a table, and this is a configuration" in refused(
        "inspect", pair, "--json"
    )
