"""Populations: shapes, meshes, weights and aspect ratios as arguments of the kernels."""

import math

import numpy as np
import pytest
from mesh_fixtures import box, grain, population_of, rebounds
from refusals import refused
from scipy.special import ndtri
from scipy.stats import truncnorm

from sampler.formats.shape_codes import SHAPE_CODES, SHAPE_NAMES
from tablegen.config.config import load_config, load_population, parse_config
from tablegen.config.grains import GRAINS, named_population
from tablegen.config.population import FixedAspect, Population, ShapeWeights
from tablegen.model import shapes
from tablegen.model.shapes import FIRST_MESH

CORUNDUM = load_config("corundum-steel")
POPULATION = CORUNDUM.population


def with_shapes(**weights):
    return CORUNDUM.with_changes({"population": {"shapes": weights}}).population


def test_codes_are_those_of_the_output_files():
    names = ("ellipsoid", "prism", "truncated-prism", "tetrahedron", "sphere")
    assert {name: k for k, name in enumerate(names)} == SHAPE_CODES
    assert FIRST_MESH == 64
    weights = ShapeWeights.model_fields.items()
    assert [field.alias or name for name, field in weights] == list(SHAPE_NAMES)
    for name in SHAPE_NAMES:
        assert getattr(shapes, name.upper().replace("-", "_")) == SHAPE_CODES[name]


def test_shares_add_up_to_exactly_one():
    population = with_shapes(ellipsoid=0.1, prism=0.2, **{"truncated-prism": 0.3}, tetrahedron=0.7)
    arguments = population.kernel_arguments()
    assert arguments.shape_codes.tolist() == [0, 1, 2, 3]
    weights = arguments.cumulative_weights
    assert weights[-1] == 1.0
    np.testing.assert_allclose(np.diff(weights, prepend=0.0), [1 / 13, 2 / 13, 3 / 13, 7 / 13])


def test_truncated_normal_law():
    mean, deviation, low, high = POPULATION.kernel_arguments().aspect.T
    u = np.linspace(2.0**-33, 1.0 - 2.0**-33, 1001)[:, np.newaxis]
    ratios = mean + deviation * ndtri(low + u * (high - low))
    law = truncnorm(-1.5, 1.0, loc=0.8, scale=0.2)
    for column in ratios.T:
        np.testing.assert_allclose(column, law.ppf(u[:, 0]), rtol=1e-12)
    assert ratios.min() >= 0.5
    assert ratios.max() <= 1.0


class TestParts:
    def test_mixture_keeps_weights_and_meshes_and_drops_spheres(self):
        mixture = with_shapes(
            ellipsoid=3.0, sphere=5.0, tetrahedron=1.0, **{"truncated-prism": 1.0}
        ).restricted_to("mixture")
        arguments = mixture.kernel_arguments()
        assert arguments.shape_codes.tolist() == [0, 2, 3]
        assert arguments.cumulative_weights.tolist() == [0.6, 0.8, 1.0]
        population = population_of(grain(50), shapes={"prism": 1.0, "sphere": 1.0})
        codes = population.restricted_to("mixture").kernel_arguments().shape_codes
        assert codes.tolist() == [1, FIRST_MESH]
        assert population.restricted_to("prism").meshes == ()

    def test_spheres(self):
        spheres = POPULATION.restricted_to("sphere")
        assert spheres.aspect == FixedAspect(distribution="fixed", values=(1.0, 1.0))
        assert spheres.with_aspect(1.0, 1.0) == spheres
        refused("aspect", spheres.with_aspect, 0.5, 1.0)
        refused("shape", spheres.restricted_to, "mixture")

    def test_unknown_shapes_and_bad_ratios(self):
        refused("shape", POPULATION.restricted_to, "mesh")
        for ratios in ((0.0, 0.5), (0.5, 1.01), (0.5, math.nan)):
            refused("aspect", POPULATION.with_aspect, *ratios)

    def test_strata_have_one_form_each_and_its_share(self):
        shapes = {"tetrahedron": 3.0, "sphere": 1.0, "prism": 0.0}
        population = population_of(grain(50), box(0.5, 0.25), weights=[0.0, 4.0], shapes=shapes)
        strata = population.strata()
        assert [(s.code, s.share) for s in strata] == [(3, 0.375), (4, 0.125), (FIRST_MESH, 0.5)]
        # the code is that of the whole population; of its own the only mesh is the first
        assert population.kernel_arguments().shape_codes.tolist() == [s.code for s in strata]
        for stratum in strata:
            assert len(stratum.population.kernel_arguments().shape_codes) == 1
        assert strata[1].population == population.restricted_to("sphere")


class TestMeshes:
    def test_shares_codes_and_sizes(self):
        solids = grain(50), box(0.5, 0.25)
        population = population_of(*solids, weights=[2.0, 1.0], shapes={"prism": 1.0})
        arguments = population.kernel_arguments()
        codes = [SHAPE_CODES["prism"], FIRST_MESH, FIRST_MESH + 1]
        assert arguments.shape_codes.tolist() == codes
        assert arguments.cumulative_weights.tolist() == [0.25, 0.75, 1.0]
        simulation = rebounds(population, 20_000, seed=75)
        assert set(simulation.shape) == set(codes)
        boxes = np.isclose(simulation.aspect, 0.5, rtol=1e-12).all(axis=1)
        # 20,000 particles: five standard deviations of a share are 0.017 (false alarm 6e-7)
        assert np.mean(simulation.shape >= FIRST_MESH) == pytest.approx(0.75, abs=0.017)
        assert np.mean(boxes) == pytest.approx(0.25, abs=0.017)

    def test_meshes_do_not_disturb_each_other(self):
        together = rebounds(population_of(grain(50), box(0.5, 0.25)), 2000, seed=76)
        for points in (grain(50), box(0.5, 0.25)):
            alone = rebounds(population_of(points), 2000, seed=76)
            same = (together.aspect == alone.aspect[0]).all(axis=1)
            assert 900 < same.sum() < 1100
            np.testing.assert_array_equal(together.state[same], alone.state[same])

    def test_ratios_are_not_theirs(self):
        meshes = population_of(grain(50))
        assert meshes.with_aspect(0.5, 0.5).meshes == meshes.meshes
        field = "corundum-steel, changed: population"
        refused(f"{field}.shapes", population_of, grain(50), weights=[0.0])
        refused(f"{field}.meshes[0].vertices", population_of, box(0.5, 0.0))


def test_names_of_grains_stand_for_populations_in_any_configuration():
    means = []
    for name in GRAINS:
        config = CORUNDUM.with_changes({"population": name})
        assert load_population(name) == named_population(name)
        assert 'population = "' not in config.text  # a table says what the name meant
        means.append(config.population.aspect.mean)
    assert means == sorted(means)
    changed = {"population": "round"}
    refused("corundum-steel, changed: population", CORUNDUM.with_changes, changed)


def test_shapes_that_a_scene_names_replace_those_of_the_pair():
    assert set(POPULATION.shapes.positive()) == {
        "ellipsoid",
        "prism",
        "truncated-prism",
        "tetrahedron",
    }
    scene = parse_config(
        'name = "s"\npair = "corundum-steel"\n[population.shapes]\nprism = 1\n', "s.toml"
    )
    assert scene.population.shapes.positive() == {"prism": 1.0}
    assert scene.population.aspect == POPULATION.aspect
    assert str(scene.population) == "100 % prism; b/a and c/b 0.8 ± 0.2, cut to 0.5 to 1"
    mesh = {"vertices": grain(50).tolist()}
    with_mesh = CORUNDUM.with_changes({"population": {"meshes": [mesh]}})
    assert str(with_mesh.population) == "100 % a mesh"


def test_grains_are_a_name_a_pair_or_a_file(tmp_path):
    path = tmp_path / "grains.toml"
    path.write_text("[population.shapes]\nsphere = 2.0\n")
    assert load_population(path)["shapes"]["sphere"] == 2.0
    assert Population.from_tree(load_population("corundum-steel")) == POPULATION
    path.write_text("[population.shapes]\nsphere = -1.0\n")
    refused("grains.toml: population.shapes.sphere", load_population, path)
    refused("grains", load_population, "round")
