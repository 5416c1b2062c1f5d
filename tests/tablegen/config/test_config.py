"""Files of pairs and scenes: their meaning, and the error line of each that cannot be used."""

import math
import tomllib
from dataclasses import replace

import pytest
import tomli_w
from documents import ROOT
from refusals import refused
from tiny_tables import TINY

from sampler.errors import InputError
from sampler.files import data_directory
from sampler.formats.channels import STATE, VARIABLES, WORKS
from sampler.formats.hdf5 import read_table, write_table
from tablegen.config.config import load_config, parse_config, stored_config
from tablegen.config.population import FixedAspect, TruncatedNormalAspect
from tablegen.config.scenes import merged

PAIR_TEXT = (data_directory() / "corundum-steel.toml").read_text(encoding="utf-8")
SCENE = 'name = "slow"\npair = "corundum-steel"\n'


def changed(changes):
    return tomli_w.dumps(merged(tomllib.loads(PAIR_TEXT), changes))


def line_about(text, directory=None):
    """Check that the text of a file is refused; return the line without the name of the file."""
    with pytest.raises(InputError) as caught:
        parse_config(text, "my.toml", directory)
    name, _, line = str(caught.value).partition(": ")
    assert (name, "\n" in line) == ("my.toml", False)
    return line


class TestShippedPair:
    def test_is_the_pair_of_the_paper(self):
        config = load_config("corundum-steel")
        assert (config.name, config.pair_name) == ("corundum-steel", "corundum-steel")
        law = config.pair.kernel_arguments()
        assert (law.coefficient, law.exponent, law.strength, law.factor) == (0.1, 0.61, 1.0, 1.0)
        assert config.pair.restitution.valid_speed == (50.0, 300.0)
        assert config.domain.alpha_deg == (0.05, 90.0)
        assert config.domain.speed == (5.0, 300.0)
        assert config.population.truncation == 2.0 - math.sqrt(2.0)

    def test_path_and_name_are_the_same_and_the_text_is_the_file(self):
        path = data_directory() / "corundum-steel.toml"
        assert load_config(path) == load_config(str(path)) == load_config("corundum-steel")
        assert load_config("corundum-steel").text == PAIR_TEXT


@pytest.mark.parametrize("name", sorted(path.stem for path in data_directory().glob("*.toml")))
def test_shipped_text_stands_alone(name):
    config = load_config(name)
    again = parse_config(config.text, "stored")
    assert again == config
    assert again.text == config.text
    assert isinstance(tomllib.loads(config.text)["pair"], dict)
    written = tomllib.loads((data_directory() / f"{name}.toml").read_text(encoding="utf-8"))
    # it has the name of its file, and no pair but a scene's has another
    assert written["name"] == name
    of_pair = written["pair"] if isinstance(written["pair"], str) else name
    assert (config.pair.name or config.name) == of_pair


class TestScene:
    def test_changes_only_the_fields_it_names(self):
        base = load_config("corundum-steel")
        scene = parse_config(SCENE + "[table]\nseed = 9\n", "slow.toml")
        assert (scene.name, scene.pair_name) == ("slow", "corundum-steel")
        assert scene.table == base.table.model_copy(update={"seed": 9})
        assert (scene.domain, scene.population) == (base.domain, base.population)
        assert scene.pair.model_copy(update={"name": None}) == base.pair

    def test_refers_to_a_file_beside_it(self, tmp_path, monkeypatch):
        monkeypatch.chdir(data_directory())
        (tmp_path / "mine.toml").write_text(changed({"name": "mine", "table": {"seed": 77}}))
        scene = tmp_path / "scene.toml"
        scene.write_text('name = "scene"\npair = "mine.toml"\n')
        config = load_config(scene)
        assert (config.name, config.pair_name, config.table.seed) == ("scene", "mine", 77)
        assert parse_config(config.text, "stored") == config
        line = line_about('name = "a"\npair = "corundum-steel.toml"\n', tmp_path)
        assert line == f"pair: there is no file {tmp_path / 'corundum-steel.toml'}"

    def test_other_kind_replaces_the_whole_law(self):
        fixed = '[population.aspect]\ndistribution = "fixed"\nvalues = [0.9, 0.7]\n'
        config = parse_config(SCENE + fixed, "slow.toml")
        assert config.population.aspect == FixedAspect(distribution="fixed", values=(0.9, 0.7))
        same = '[population.aspect]\ndistribution = "truncated-normal"\nmean = 0.7\n'
        aspect = parse_config(SCENE + same, "slow.toml").population.aspect
        assert isinstance(aspect, TruncatedNormalAspect)
        assert (aspect.mean, aspect.standard_deviation) == (0.7, 0.2)

    def test_nodes_do_not_outlive_their_range(self, tmp_path):
        nodes = {"alpha_nodes_deg": [0.05, 30.0, 90.0], "speed_nodes": [5.0, 300.0]}
        (tmp_path / "base.toml").write_text(changed({"table": nodes}))
        head = 'name = "s"\npair = "base.toml"\n'
        config = parse_config(f"{head}[domain]\nalpha_deg = [20, 60]\n", "s.toml", tmp_path)
        assert config.table.alpha_nodes_deg is None
        assert config.table.speed_nodes == (5.0, 300.0)

    def test_unusable_scenes(self):
        line = line_about('name = "a"\npair = "gold-glass"\n')
        assert line.startswith("pair: there is no .toml file 'gold-glass'; ")
        line = line_about('name = "a"\npair = "demo"\n')
        assert line.startswith("pair: got 'demo', ")
        assert line_about('pair = "corundum-steel"\n').startswith("name: is missing, ")


def test_with_changes_keeps_text_and_fields_together_and_checks():
    config = load_config("demo").with_changes({"table": {"seed": 2**64 - 1}})
    assert config.table.seed == 2**64 - 1
    assert parse_config(config.text, "stored") == config
    refused("demo, changed: table.seed", config.with_changes, {"table": {"seed": -1}})


def test_values_that_look_like_mistakes_are_doubted():
    domain, aspect = {"alpha_deg": [0.17, 1.05]}, {"standard_deviation": 8.0}
    changes = {"domain": domain, "population": {"aspect": aspect}}
    config = load_config("corundum-steel").with_changes(changes)
    fields = [line.partition(":")[0] for line in config.doubts()]
    assert fields == ["domain.alpha_deg", "population.aspect.standard_deviation"]


class TestDomain:
    @pytest.mark.parametrize(
        ("domain", "columns"),
        [
            ("", STATE),
            ("dimension = 2", ("u", "v", "omega_z")),
            ('variables = ["omega_z", "v"]', ("v", "omega_z")),
            ('dimension = 2\nvariables = ["rotational_energy", "v"]', ("v", "rotational_energy")),
            (f"variables = {list(VARIABLES[7::-1])}", VARIABLES[:8]),
            ('variables = ["work_shear", "work_normal", "v"]', ("v", *WORKS)),
        ],
    )
    def test_columns_come_in_the_order_of_all_variables(self, domain, columns):
        config = parse_config(f"{SCENE}spin = false\n[domain]\n{domain}\n", "scene.toml")
        assert config.domain.columns == columns
        assert parse_config(config.text, "stored") == config

    @pytest.mark.parametrize("speed", [[10.0, 300.0], [50.0, 301.0]])
    def test_extrapolation_must_be_asked_for(self, speed):
        line = line_about(changed({"domain": {"speed": speed, "extrapolate": False}}))
        assert line.startswith(f"domain.speed: got [{speed[0]:g}, {speed[1]:g}], ")
        assert "[50, 300] m/s" in line
        asked = parse_config(changed({"domain": {"speed": speed, "extrapolate": True}}), "my.toml")
        assert asked.domain.speed == tuple(speed)

    def test_scenes_inherit_the_spin_law(self):
        spinning = TINY.with_changes({"spin": True})
        assert spinning.with_changes({"domain": {"dimension": 2, "speed": [60.0, 100.0]}}).spin
        assert not spinning.with_changes({"domain": {"variables": ["u"]}, "spin": False}).spin
        assert not parse_config(TINY.text.replace("spin = false\n", ""), "t.toml").spin


class TestUnusableFiles:
    def test_syntax_error_says_where(self):
        line = line_about(PAIR_TEXT.replace("coefficient = 0.1", "coefficient ="))
        assert "at line 26, column" in line

    def test_tables_in_tables_end(self):
        assert "recursion" in line_about(".".join(["a"] * 3000) + " = 1")

    def test_encodings(self, tmp_path):
        path = tmp_path / "my.toml"
        path.write_bytes(b'name = "\xff"')
        assert "byte 0xff at position 8" in refused("my.toml", load_config, path)
        path.write_bytes(b"\xef\xbb\xbf" + PAIR_TEXT.encode())
        assert load_config(path) == load_config("corundum-steel")


class TestStored:
    """The configuration in a table opens no file."""

    TEXT = load_config("corundum-steel-compact").text

    def naming_a_mesh(self):
        tree = tomllib.loads(PAIR_TEXT)
        tree["population"]["meshes"] = [{"file": "grain.stl"}]
        return tomli_w.dumps(tree)

    def test_texts_that_name_a_file_are_refused(self, monkeypatch):
        for function in ("read_text", "read_mesh"):
            monkeypatch.setattr(f"tablegen.config.config.{function}", None)
        refused("t.h5: pair", stored_config, SCENE, "t.h5")
        refused("t.h5: population.meshes[0].vertices", stored_config, self.naming_a_mesh(), "t.h5")
        assert stored_config(self.TEXT, "t.h5").pair_name == "corundum-steel"

    def test_commands_refuse_a_text_that_is_not_a_configuration(self, run, refuse, tmp_path):
        path = tmp_path / "t.h5"
        contents = read_table(ROOT / "tests" / "vectors" / "full.h5")
        write_table(path, replace(contents, config="[" * 5000))
        assert "config: " in refuse("tablegen", "validate", path)
        assert "declared          cannot be read" in run("inspect", path).out


def test_page_of_laws_has_the_bounds_of_the_code():
    from tablegen.model import model_bounds as bounds

    page = (data_directory() / "LAWS.md").read_text(encoding="utf-8").partition("## Bounds")[2]
    simple = bounds.ASPECT, bounds.ALPHA_DEG, bounds.SPEED, bounds.SPIN, bounds.INERTIA
    words = [bound.words for bound in (*simple, bounds.CONTACT_RESOLUTION, bounds.TOLERANCE)]
    words.append(f"up to {0.5 * bounds.MOST_TURNED:,.0f} sin(angle) V/a")
    size = bounds.MESH_SIZE
    words.append(f"coordinates up to {size.high:g}, extent of at least {size.low:g}")
    assert [cell for cell in words if f"| {cell} |" not in page] == []
