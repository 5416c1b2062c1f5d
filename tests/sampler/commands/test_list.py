"""``sampler list`` and ``tablegen list``: everything that has a name, in both forms."""

import json

import pytest

import sampler
from sampler.files import available, find_config, find_table
from tablegen import load_config, read_measurements

both = pytest.mark.parametrize("program", ["sampler", "tablegen"])


@pytest.fixture
def listed(call):
    def run(program, *flags):
        ended = call(program, "list", *flags)
        assert (ended.status, ended.err) == (0, "")
        return ended.out

    return run


@both
def test_every_name_has_one_line_below_its_kind(program, listed):
    kinds, found = ("tables", "pairs", "scenes", "measurements"), {}
    for line in listed(program).splitlines():
        if line in kinds:
            names = found[line] = {}
        else:
            name, _, text = line.strip().partition(" ")
            assert text.strip()
            assert name not in names
            names[name] = text.strip()
    assert tuple(found) == kinds
    assert sorted(found["tables"]) == available(".h5")
    assert sorted([*found["pairs"], *found["scenes"]]) == available(".toml")
    assert sorted(found["measurements"]) == available(".csv")
    assert found["measurements"]["kharaz-2001"].startswith("Kharaz, Gorham & Salman (2001)")
    assert found["tables"]["corundum-steel"].startswith("0.5 to 90 degrees, 5 to 300 m/s, u v w")
    assert found["pairs"]["corundum-steel"] == "synthetic corundum on steel St3"
    assert "pair corundum-steel, 20 to 60 degrees, 100 to 200 m/s" in found["scenes"]["demo"]
    assert "2 dimensions" in found["scenes"]["plane-flow"]
    assert found["scenes"]["no-spin"].endswith("u v")


@both
def test_json_says_what_the_files_say(program, listed):
    found = json.loads(listed(program, "--json"))
    for name, facts in found["tables"].items():
        table = sampler.load(name)
        assert facts["pair"] == table.pair
        assert facts["components"] == list(table.columns)
        assert facts["alpha_deg"] == list(table.alpha_nodes_deg[[0, -1]])
        assert facts["speed"] == list(table.speed_range)
        assert facts["bytes"] == find_table(name).stat().st_size
    for name, facts in found["pairs"].items():
        pair = load_config(name).pair
        assert facts == {"particle": pair.particle, "wall": pair.wall}
    for name, facts in found["scenes"].items():
        assert load_config(name).pair_name == facts["pair"]
    for name, facts in found["measurements"].items():
        assert facts == read_measurements(name).about
        assert {"title", "particle", "wall"} <= set(facts)


def test_your_own_files_beside_them_are_listed(monkeypatch, tmp_path, listed):
    """Names are those of the folder, whatever is in it."""
    (tmp_path / "mine.toml").write_bytes(find_config("no-spin").read_bytes())
    monkeypatch.setattr("sampler.files.data_directory", lambda: tmp_path)
    found = json.loads(listed("sampler", "--json"))
    assert found == {
        "tables": {},
        "pairs": {},
        "scenes": {
            "mine": {"pair": "corundum-steel", "spin": False, "domain": {"components": ["u", "v"]}}
        },
        "measurements": {},
    }
    assert "  mine  pair corundum-steel, u v\n" in listed("sampler")


@both
def test_unknown_option_is_one_line(program, refuse):
    assert "--jsn" in refuse(program, "list", "--jsn")
