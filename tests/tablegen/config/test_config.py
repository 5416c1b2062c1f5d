"""Pair files and scenes: what they mean, and one clear line for each that cannot be used."""

import math
import pickle
import tomllib
from itertools import pairwise

import numpy as np
import pytest
import tomli_w
from pydantic import ValidationError

from sampler.errors import InputError
from sampler.files import data_directory
from tablegen.config.config import AccuracyTargets, Config, load_config, parse_config
from tablegen.config.metric_table import PRESETS
from tablegen.config.population import FixedAspect, TruncatedNormalAspect
from tablegen.config.scenes import merged

PAIR_TEXT = (data_directory() / "corundum-steel.toml").read_text(encoding="utf-8")


def changed(changes):
    """The shipped pair's text with some fields changed."""
    return tomli_w.dumps(merged(tomllib.loads(PAIR_TEXT), changes))


def refused(text, directory=None):
    """The one line with which a text is refused."""
    with pytest.raises(InputError) as caught:
        parse_config(text, "my.toml", directory)
    line = str(caught.value)
    assert "\n" not in line
    assert line.startswith("my.toml: ")
    return line.removeprefix("my.toml: ")


class TestShippedPair:
    def test_is_the_pair_of_the_paper(self):
        config = load_config("corundum-steel")
        assert (config.name, config.pair_name) == ("corundum-steel", "corundum-steel")
        law = config.pair.kernel_arguments()
        assert (law.coefficient, law.exponent, law.strength, law.factor) == (0.1, 0.61, 1.0, 1.0)
        assert config.pair.restitution.valid_speed == (50.0, 300.0)
        assert "Lashkov 1991" in config.pair.restitution.source
        assert config.domain.alpha_deg == (0.5, 90.0)
        assert config.domain.speed == (5.0, 300.0)
        assert config.domain.extrapolate
        assert config.population.truncation == 2.0 - math.sqrt(2.0)

    def test_declares_the_accuracy_that_is_asked_of_it(self):
        accuracy = load_config("corundum-steel").accuracy
        assert accuracy.ks <= 0.010
        assert accuracy.sliced_wasserstein <= 0.008
        assert accuracy.correlation_error <= 0.02
        assert accuracy.auc <= 0.56

    def test_text_is_the_file(self):
        assert load_config("corundum-steel").text == PAIR_TEXT

    def test_path_and_name_are_the_same(self):
        path = data_directory() / "corundum-steel.toml"
        assert load_config(path) == load_config(str(path)) == load_config("corundum-steel")

    def test_is_frozen_and_travels_between_processes(self):
        config = load_config("corundum-steel")
        with pytest.raises(ValidationError):
            config.name = "other"
        copy = pickle.loads(pickle.dumps(config))
        assert copy == config
        assert copy.text == config.text

    def test_speed_coordinate(self):
        config = load_config("corundum-steel")
        speed = np.array([50.0, 200.0, 300.0])
        expected = [math.exp(-0.1 * v**0.61) for v in speed]
        np.testing.assert_allclose(config.speed_coordinate(speed), expected, rtol=1e-15)
        assert config.speed_coordinate(200.0) == pytest.approx(expected[1], rel=1e-15)
        assert config.speed_coordinate(0.0) == 1.0


@pytest.mark.parametrize("name", sorted(path.stem for path in data_directory().glob("*.toml")))
def test_shipped_text_stands_alone(name):
    config = load_config(name)
    again = parse_config(config.text, "stored")
    assert again == config
    assert again.text == config.text
    assert isinstance(tomllib.loads(config.text)["pair"], dict)


def test_text_of_a_configuration_without_a_file():
    config = Config.from_tree(tomllib.loads(changed({"table": {"speed_nodes": [5, 300]}})))
    assert parse_config(config.text, "stored") == config


class TestScene:
    SCENE = 'name = "slow"\npair = "corundum-steel"\n'

    def test_demo(self):
        demo = load_config("demo")
        assert (demo.name, demo.pair_name) == ("demo", "corundum-steel")
        assert demo.domain.alpha_deg == (20.0, 60.0)
        assert demo.domain.speed == (100.0, 200.0)
        assert demo.population == load_config("corundum-steel").population

    def test_changes_only_what_it_names(self):
        base = load_config("corundum-steel")
        scene = parse_config(self.SCENE + "[table]\nseed = 9\n", "slow.toml")
        assert scene.table == base.table.model_copy(update={"seed": 9})
        assert scene.domain == base.domain
        assert scene.pair.model_copy(update={"name": None}) == base.pair

    def test_refers_to_a_file_beside_it(self, tmp_path, monkeypatch):
        monkeypatch.chdir(data_directory())
        (tmp_path / "mine.toml").write_text(changed({"name": "mine", "table": {"seed": 77}}))
        scene = tmp_path / "scene.toml"
        scene.write_text('name = "scene"\npair = "mine.toml"\n')
        config = load_config(scene)
        assert (config.name, config.pair_name, config.table.seed) == ("scene", "mine", 77)
        assert parse_config(config.text, "stored") == config

    def test_relative_reference_ignores_the_working_folder(self, tmp_path, monkeypatch):
        monkeypatch.chdir(data_directory())
        line = refused('name = "a"\npair = "corundum-steel.toml"\n', tmp_path)
        assert line == f"pair: got {tmp_path / 'corundum-steel.toml'}, allowed: a file that exists"

    def test_other_kind_replaces_the_whole_law(self):
        fixed = '[population.aspect]\ndistribution = "fixed"\nvalues = [0.9, 0.7]\n'
        config = parse_config(self.SCENE + fixed, "slow.toml")
        assert config.population.aspect == FixedAspect(distribution="fixed", values=(0.9, 0.7))
        same = '[population.aspect]\ndistribution = "truncated-normal"\nmean = 0.7\n'
        aspect = parse_config(self.SCENE + same, "slow.toml").population.aspect
        assert isinstance(aspect, TruncatedNormalAspect)
        assert (aspect.mean, aspect.standard_deviation) == (0.7, 0.2)

    def test_nodes_do_not_outlive_their_range(self, tmp_path):
        nodes = {"alpha_nodes_deg": [0.5, 30.0, 90.0], "speed_nodes": [5.0, 300.0]}
        (tmp_path / "base.toml").write_text(changed({"table": nodes}))
        head = 'name = "s"\npair = "base.toml"\n'
        config = parse_config(f"{head}[domain]\nalpha_deg = [20, 60]\n", "s.toml", tmp_path)
        assert config.table.alpha_nodes_deg is None
        assert config.table.speed_nodes == (5.0, 300.0)

    def test_leaves_a_shape_out(self):
        config = parse_config(f"{self.SCENE}[population.shapes]\nprism = 0\n", "slow.toml")
        shapes = config.population.kernel_arguments().shape_codes
        assert shapes.tolist() == [0, 2, 3]

    def test_unknown_pair_lists_the_names(self):
        line = refused('name = "a"\npair = "gold-glass"\n')
        assert line.startswith("pair: got 'gold-glass', allowed: a name (")
        assert "corundum-steel" in line

    def test_scene_of_a_scene(self):
        line = refused('name = "a"\npair = "demo"\n')
        assert line == "pair: got 'demo', which is a scene itself, allowed: a pair file"

    def test_needs_its_own_name(self):
        assert refused('pair = "corundum-steel"\n').startswith("name: missing, allowed: ")

    def test_broken_pair_file_is_the_one_named(self, tmp_path):
        (tmp_path / "base.toml").write_text(changed({"domain": {"alpha_deg": [0.0, 90.0]}}))
        with pytest.raises(InputError, match=r"^base\.toml: domain\.alpha_deg\[0\]: got 0,"):
            parse_config('name = "s"\npair = "base.toml"\n', "s.toml", tmp_path)


class TestWithChanges:
    def test_keeps_text_and_fields_together(self):
        config = load_config("demo").with_changes({"table": {"seed": 2**64 - 1}})
        assert config.table.seed == 2**64 - 1
        assert parse_config(config.text, "stored") == config

    def test_is_checked(self):
        with pytest.raises(InputError, match=r"^demo, changed: table\.seed: got -1, allowed"):
            load_config("demo").with_changes({"table": {"seed": -1}})


class TestDomainAndNodes:
    def test_single_condition(self):
        domain = {"alpha_deg": [45.0, 45.0], "speed": [100.0, 100.0]}
        table = {"alpha_nodes_deg": [45.0], "speed_nodes": [100.0]}
        config = parse_config(changed({"domain": domain, "table": table}), "my.toml")
        assert config.table.alpha_nodes_deg == (45.0,)

    @pytest.mark.parametrize("speed", [[10.0, 300.0], [50.0, 301.0], [1.0, 2.0]])
    def test_extrapolation_must_be_asked_for(self, speed):
        line = refused(changed({"domain": {"speed": speed, "extrapolate": False}}))
        assert line == (
            f"domain.speed: got [{speed[0]:g}, {speed[1]:g}], allowed: inside the restitution "
            "law's validity range [50, 300] m/s, or set domain.extrapolate = true"
        )
        asked = parse_config(changed({"domain": {"speed": speed, "extrapolate": True}}), "my.toml")
        assert asked.domain.speed == tuple(speed)


class TestUnusableFiles:
    def test_syntax_error_says_where(self):
        line = refused(PAIR_TEXT.replace("coefficient = 0.1", "coefficient ="))
        assert line.startswith("not valid TOML: ")
        assert "at line 25, column" in line

    def test_missing_field(self):
        text = PAIR_TEXT.replace('wall = "steel St3"\n', "")
        assert refused(text) == "pair.wall: missing, allowed: a value"

    def test_unknown_name_lists_the_names(self):
        with pytest.raises(InputError, match=r"got 'gold', allowed: a name \(.*corundum-steel"):
            load_config("gold")

    def test_missing_file_and_folder(self, tmp_path):
        with pytest.raises(InputError, match="allowed: a file that exists"):
            load_config(tmp_path / "none.toml")
        with pytest.raises(InputError, match=r"a folder, allowed: a \.toml file"):
            load_config(tmp_path)

    def test_not_text(self, tmp_path):
        path = tmp_path / "binary.toml"
        path.write_bytes(b'name = "\xff"')
        with pytest.raises(
            InputError, match=r"^binary\.toml: got byte 0xff at position 8, allowed"
        ):
            load_config(path)

    def test_byte_order_mark_is_harmless(self, tmp_path):
        path = tmp_path / "marked.toml"
        path.write_bytes(b"\xef\xbb\xbf" + PAIR_TEXT.encode())
        assert load_config(path) == load_config("corundum-steel")


class TestPresets:
    @pytest.mark.parametrize("name", PRESETS)
    def test_name_stands_for_its_numbers(self, name):
        accuracy = AccuracyTargets.model_validate({"preset": name})
        assert accuracy.model_dump() == {"preset": name, **PRESETS[name]}

    def test_standard_is_what_is_meant_without_a_name(self):
        assert AccuracyTargets.model_validate({}).model_dump() == {
            "preset": "standard",
            **PRESETS["standard"],
        }

    def test_numbers_replace_those_of_the_preset(self):
        accuracy = AccuracyTargets.model_validate({"preset": "fine", "ks": 0.007})
        assert accuracy.ks == 0.007
        assert accuracy.auc == PRESETS["fine"]["auc"]

    def test_finer_presets_allow_less(self):
        for coarse, fine in pairwise(("compact", "standard", "fine")):
            for metric, allowed in PRESETS[fine].items():
                assert allowed < PRESETS[coarse][metric], metric

    def test_another_preset_replaces_all_numbers_of_the_old_one(self):
        changed = load_config("corundum-steel").with_changes({"accuracy": {"preset": "fine"}})
        assert changed.accuracy == AccuracyTargets.model_validate({"preset": "fine"})
        same = changed.with_changes({"accuracy": {"preset": "fine", "ks": 0.2}})
        assert (same.accuracy.ks, same.accuracy.auc) == (0.2, PRESETS["fine"]["auc"])
