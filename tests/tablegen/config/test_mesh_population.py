"""Populations, configurations and commands with meshes."""

import pickle
import re
import tomllib

import numpy as np
import pytest
from command_line import BAD_INPUT, DONE, SIMULATE, flags
from mesh_fixtures import POPULATION, box, grain, population_of, rebounds, surface, two_cubes

import tablegen
from sampler.errors import InputError
from sampler.files import data_directory
from tablegen.config.config import load_config, parse_config
from tablegen.config.mesh import MOST_VERTICES, read_mesh
from tablegen.config.population import MeshShape, Population
from tablegen.model.shape_codes import SHAPE_CODES
from tablegen.model.shapes import FIRST_MESH


class TestPopulation:
    def test_shares_codes_and_sizes(self):
        population = population_of(
            grain(50), box(0.5, 0.25), weights=[2.0, 1.0], shapes={"prism": 1.0}
        )
        arguments = population.kernel_arguments()
        mesh = SHAPE_CODES["mesh"]
        assert arguments.shape_codes.tolist() == [
            SHAPE_CODES["prism"],
            FIRST_MESH,
            FIRST_MESH + 1,
        ]
        assert arguments.cumulative_weights.tolist() == [0.25, 0.75, 1.0]
        made = rebounds(population, 20_000, seed=75)
        assert set(made.shape) == {SHAPE_CODES["prism"], mesh}
        boxes = np.isclose(made.aspect, 0.5, rtol=1e-12).all(axis=1)
        # 20,000 particles: five standard deviations of a share are 0.017 (false alarm 6e-7)
        assert np.mean(made.shape == mesh) == pytest.approx(0.75, abs=0.017)
        assert np.mean(boxes) == pytest.approx(0.25, abs=0.017)

    def test_meshes_side_by_side_do_not_disturb_each_other(self):
        together = rebounds(population_of(grain(50), box(0.5, 0.25)), 2000, seed=76)
        for points in (grain(50), box(0.5, 0.25)):
            alone = rebounds(population_of(points), 2000, seed=76)
            same = (together.aspect == alone.aspect[0]).all(axis=1)
            assert 900 < same.sum() < 1100
            np.testing.assert_array_equal(together.state[same], alone.state[same])

    def test_mixture_keeps_meshes_and_a_single_shape_does_not(self):
        population = population_of(grain(50), shapes={"prism": 1.0, "sphere": 1.0})
        assert population.restricted_to("mixture").kernel_arguments().shape_codes.tolist() == [
            1,
            FIRST_MESH,
        ]
        assert population.restricted_to("prism").meshes == ()
        only = population_of(grain(50))
        assert only.restricted_to("mixture") == only
        assert only.with_aspect(0.5, 0.5).meshes == only.meshes

    def test_strata_have_one_form_each_and_its_share(self):
        shapes = {"tetrahedron": 3.0, "sphere": 1.0, "prism": 0.0}
        population = population_of(grain(50), box(0.5, 0.25), weights=[0.0, 4.0], shapes=shapes)
        strata = population.strata()
        assert [(s.code, s.share) for s in strata] == [(3, 0.375), (4, 0.125), (FIRST_MESH, 0.5)]
        # the code is that of the whole population; of its own the only mesh is the first
        codes = population.kernel_arguments().shape_codes
        assert codes.tolist() == [s.code for s in strata]
        for stratum in strata:
            arguments = stratum.population.kernel_arguments()
            assert len(arguments.shape_codes) == 1
        assert strata[1].population == population.restricted_to("sphere")
        assert strata[2].population.meshes[0].vertices == population.meshes[1].vertices

    def test_weightless_meshes_are_left_out(self):
        population = population_of(grain(50), box(0.5, 0.25), weights=[0.0, 1.0])
        assert len(population.kernel_arguments().meshes.moments) == 1
        with pytest.raises(
            InputError, match=r"weight above 0 for at least one of ellipsoid, .*mesh"
        ):
            population_of(grain(50), weights=[0.0])

    def test_body_without_meshes(self):
        arguments = POPULATION.kernel_arguments().meshes
        assert arguments.points.shape == (0, 3)
        assert arguments.moments.shape == (0, 3)


PAIR_TEXT = (data_directory() / "corundum-steel.toml").read_text(encoding="utf-8")


class TestConfig:
    def test_text_stands_alone(self, tmp_path):
        surface(grain(60)).export(tmp_path / "grain.ply")
        text = PAIR_TEXT + '[[population.meshes]]\nfile = "grain.ply"\nweight = 2.0\n'
        config = parse_config(text, "my.toml", tmp_path)
        assert len(config.population.meshes[0].vertices) == 60
        assert config.population.meshes[0].file == "grain.ply"
        (tmp_path / "grain.ply").unlink()
        again = parse_config(config.text, "again")
        assert again == config
        assert again.text == config.text
        assert tomllib.loads(config.text)["population"]["meshes"][0]["weight"] == 2.0
        assert pickle.loads(pickle.dumps(config)) == config
        states = [rebounds(c.population, 500, seed=1).state for c in (config, again)]
        np.testing.assert_array_equal(*states)

    def test_scene_with_meshes(self, tmp_path):
        surface(box(0.5, 0.25)).export(tmp_path / "box.stl")
        scene = 'name = "boxes"\npair = "corundum-steel"\n[[population.meshes]]\nfile = "box.stl"\n'
        path = tmp_path / "scene.toml"
        path.write_text(scene)
        config = load_config(path)
        assert config.population.kernel_arguments().shape_codes.tolist() == [0, 1, 2, 3, FIRST_MESH]
        assert parse_config(config.text, "again") == config

    MESHES_ALONE = '[[population.meshes]]\nfile = "grain.ply"\n'

    def meshes_alone(self, folder, more=""):
        """Pair file whose population has meshes, and nothing else but ``more``."""
        surface(grain(60)).export(folder / "grain.ply")
        before, _, rest = PAIR_TEXT.partition("[population]")
        after = rest.partition("[domain]")[2]
        text = f"{before}{more}{self.MESHES_ALONE}[domain]{after}"
        return parse_config(text, "my.toml", folder)

    def test_meshes_alone_need_neither_shapes_nor_ratios(self, tmp_path):
        config = self.meshes_alone(tmp_path)
        assert config.population.shapes.positive() == {}
        assert config.population.kernel_arguments().shape_codes.tolist() == [FIRST_MESH]
        made = tablegen.simulate(config, 0.7, 200.0, 20, seed=1)
        assert set(made.shape) == {5}
        assert parse_config(config.text, "again") == config
        spheres = config.population.restricted_to("sphere").kernel_arguments()
        assert spheres.shape_codes.tolist() == [4]
        prisms = config.population.restricted_to("prism")
        assert prisms.with_aspect(0.5, 0.5).kernel_arguments().shape_codes.tolist() == [1]
        with pytest.raises(InputError, match=r"^aspect: missing for prism, allowed: "):
            prisms.kernel_arguments()

    def test_shapes_beside_them_need_ratios_unless_they_are_spheres(self, tmp_path):
        config = self.meshes_alone(tmp_path, "[population.shapes]\nsphere = 1.0\n")
        assert config.population.kernel_arguments().shape_codes.tolist() == [4, FIRST_MESH]
        with pytest.raises(InputError, match=r"^my.toml: population\.aspect: missing, allowed: "):
            self.meshes_alone(tmp_path, "[population.shapes]\nprism = 1.0\n")

    def test_page_on_laws_describes_the_population(self, tmp_path):
        """Its example loads, and it names every field and the most vertices."""
        page = (data_directory() / "LAWS.md").read_text(encoding="utf-8")
        section = page.partition("## `[population]`")[2].partition("\n## ")[0]
        for kind in (Population, MeshShape):
            for name in kind.model_fields:
                assert re.search(rf"`\[*(population\.)?{name}\]*`", section), name
        assert f"at most {MOST_VERTICES:,} vertices" in " ".join(section.split())
        (example,) = re.findall(r"```toml\n(.*?)```", section, re.S)
        surface(grain(60)).export(tmp_path / "grain-1.stl")
        surface(box(0.5, 0.25)).export(tmp_path / "grain-2.ply")
        before, _, rest = PAIR_TEXT.partition("[population]")
        text = f"{before}{example}[domain]{rest.partition('[domain]')[2]}"
        population = parse_config(text, "my.toml", tmp_path).population
        assert [mesh.weight for mesh in population.meshes] == [2.0, 1.0]

    def test_text_with_vertices_is_kept(self):
        rows = ", ".join(str(list(row)) for row in box(0.5, 0.25).tolist())
        text = f"{PAIR_TEXT}[[population.meshes]]\nvertices = [{rows}]\n"
        assert parse_config(text, "my.toml").text == text

    def test_most_vertices_is_what_the_message_says(self):
        with pytest.raises(InputError, match=f"allowed: 4 to {MOST_VERTICES} points that span a"):
            population_of(box(0.5, 0.0))


class TestCommand:
    def test_simulate(self, run, tmp_path):
        surface(grain(60)).export(tmp_path / "grain.stl")
        changes = {"--shape": None, "--particle": tmp_path / "grain.stl"}
        output = tmp_path / "r.npz"
        ended = run("simulate", *flags(SIMULATE, changes), "--output", output, "--quiet")
        assert (ended.status, ended.out, ended.err) == (DONE, "", "")
        with np.load(output) as file:
            assert set(file["shape"]) == {5}
            people = POPULATION.of_mesh(read_mesh(tmp_path / "grain.stl"))
            np.testing.assert_array_equal(file["state"], rebounds(people, 300, seed=1).state)

    def test_mesh_that_is_not_convex_is_noted(self, run, tmp_path):
        two_cubes().export(tmp_path / "two.stl")
        changes = {"--shape": None, "--particle": tmp_path / "two.stl"}
        ended = run(
            "simulate", *flags(SIMULATE, changes), "--output", tmp_path / "r.npz", "--quiet"
        )
        assert ended.status == DONE
        assert ended.err == (
            "tablegen: note: two.stl is not convex; its convex hull, which has 1.5 times its "
            "volume, takes its place\n"
        )

    @pytest.mark.parametrize(
        ("changes", "reason"),
        [
            ({"--particle": "grain.stl"}, "'--shape' or '--particle': got both, allowed: one of"),
            ({"--shape": None}, "'--shape' or '--particle': missing, allowed: one of them"),
            ({"--shape": None, "--particle": "none.stl"}, "particle: got none.stl, allowed"),
            (
                {"--shape": None, "--particle": "none.stl", "--aspect": (0.5, 0.5)},
                "aspect: got [0.5, 0.5] with --particle, allowed with --shape only",
            ),
        ],
    )
    def test_refusals(self, run, tmp_path, changes, reason):
        output = tmp_path / "r.npz"
        ended = run("simulate", *flags(SIMULATE, changes), "--output", output)
        assert ended.status == BAD_INPUT
        assert ended.err.startswith(f"tablegen: error: {reason}")
        assert ended.err.count("\n") == 1
        assert not output.exists()
