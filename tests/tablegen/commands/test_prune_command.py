"""``tablegen prune``: options and scenes, also a scene of one pair for the table of another."""

from dataclasses import replace

import pytest
from tiny_tables import TINY

import sampler
from sampler.formats.hdf5 import read_table, write_table


@pytest.fixture
def other(tiny, tmp_path):
    """The tiny table under the name of another pair."""
    path, config = tmp_path / "my-pair.h5", TINY.with_changes({"pair": {"name": "my-pair"}})
    contents = read_table(tiny.path)
    write_table(path, replace(contents, pair="my-pair", config=config.text))
    return path


@pytest.mark.parametrize(
    ("words", "variables"),
    [
        (("--scene", "plane-flow"), ("u", "v", "omega_z")),
        (("--dimension", 2), ("u", "v", "omega_z")),
        (("--variables", "v,u"), ("u", "v")),
        (("--scene", "no-spin", "--dimension", 2), ("u", "v", "omega_z")),
    ],
)
def test_flags_and_scenes_choose_the_variables(run, other, words, variables):
    path = other.with_name("cut.h5")
    ended = run("prune", other, *words, "--output", path)
    assert ended.status == 0, ended.err
    table = sampler.load(path)
    assert (table.columns, table.pair) == (variables, "my-pair")
    assert ("is a scene of corundum-steel; " in ended.err) == ("--scene" in words)


def test_a_scene_may_leave_the_pair_out(run, other):
    scene, path = other.with_name("fast.toml"), other.with_name("cut.h5")
    scene.write_text('name = "fast"\n[domain]\nspeed = [200.0, 300.0]\ndimension = 2\n')
    ended = run("prune", other, "--scene", scene, "--output", path)
    assert sampler.load(path).columns == ("u", "v", "omega_z")
    assert "the new table stores no accuracy" in ended.err


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        ((), "no option says what to keep; give --scene, --dimension or --variables"),
        (("--variables", "u,x"), "--variables: got 'u,x'"),
        (("--dimension", 2, "--variables", "u,w"), "domain.variables: got ['u', 'w']"),
        (("--scene", "nowhere"), "--scene: there is no .toml file 'nowhere'"),
    ],
)
def test_bad_flags_are_refused(refused, other, words, reason):
    assert reason in refused("prune", other, *words, "--output", other.with_name("cut.h5"))
