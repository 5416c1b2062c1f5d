"""Populations: shapes, weights and aspect ratios as kernels get them."""

import math

import numpy as np
import pytest
from scipy.special import ndtri
from scipy.stats import truncnorm

from sampler.errors import InputError
from tablegen.config.config import load_config
from tablegen.config.population import FixedAspect, ShapeWeights
from tablegen.model import shapes
from tablegen.model.shape_codes import SHAPE_CODES, SHAPE_NAMES
from tablegen.model.shapes import FIRST_MESH

POPULATION = load_config("corundum-steel").population


def test_codes_are_those_of_the_output_files():
    assert SHAPE_CODES == {
        "ellipsoid": 0,
        "prism": 1,
        "truncated-prism": 2,
        "tetrahedron": 3,
        "sphere": 4,
        "mesh": 5,
    }
    weights = ShapeWeights.model_fields.items()
    assert [field.alias or name for name, field in weights] == list(SHAPE_NAMES)


def test_kernels_know_every_shape():
    for name in SHAPE_NAMES:
        assert getattr(shapes, name.upper().replace("-", "_")) == SHAPE_CODES[name]
    assert max(SHAPE_CODES.values()) + 1 == FIRST_MESH


def test_kernel_arguments():
    arguments = POPULATION.kernel_arguments()
    assert arguments.shape_codes.dtype == np.int64
    assert arguments.shape_codes.tolist() == [0, 1, 2, 3]
    assert arguments.cumulative_weights.tolist() == [0.25, 0.5, 0.75, 1.0]
    assert arguments.aspect.shape == (2, 4)


def test_last_cumulative_weight_is_exactly_one():
    shapes = {"ellipsoid": 0.1, "prism": 0.2, "truncated-prism": 0.3, "tetrahedron": 0.7}
    config = load_config("corundum-steel").with_changes({"population": {"shapes": shapes}})
    weights = config.population.kernel_arguments().cumulative_weights
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


def test_fixed_aspect_comes_out_exactly():
    rows = POPULATION.with_aspect(0.9, 0.65).kernel_arguments().aspect
    for u in (2.0**-33, 0.5, 1.0 - 2.0**-33):
        ratios = rows[:, 0] + rows[:, 1] * ndtri(rows[:, 2] + u * (rows[:, 3] - rows[:, 2]))
        assert ratios.tolist() == [0.9, 0.65]


@pytest.mark.parametrize("shape", SHAPE_NAMES)
def test_single_shape(shape):
    arguments = POPULATION.restricted_to(shape).kernel_arguments()
    assert arguments.shape_codes.tolist() == [SHAPE_CODES[shape]]
    assert arguments.cumulative_weights.tolist() == [1.0]
    assert arguments.truncation == POPULATION.truncation


def test_mixture_keeps_weights_and_drops_spheres():
    shapes = {"ellipsoid": 3.0, "prism": 0.0, "sphere": 5.0}
    config = load_config("corundum-steel").with_changes({"population": {"shapes": shapes}})
    arguments = config.population.restricted_to("mixture").kernel_arguments()
    assert arguments.shape_codes.tolist() == [0, 2, 3]
    assert arguments.cumulative_weights.tolist() == [0.6, 0.8, 1.0]


def test_mixture_of_spheres_only():
    spheres = POPULATION.restricted_to("sphere")
    assert spheres.aspect == FixedAspect(distribution="fixed", values=(1.0, 1.0))
    with pytest.raises(InputError, match=r"^shape: got 'mixture', allowed: sphere"):
        spheres.restricted_to("mixture")


@pytest.mark.parametrize("shape", ["cube", "mesh", "", "Prism"])
def test_unknown_shape(shape):
    with pytest.raises(InputError, match=f"^shape: got '{shape}', allowed: ellipsoid, .*mixtu"):
        POPULATION.restricted_to(shape)


@pytest.mark.parametrize("ratios", [(0.0, 0.5), (0.5, 1.01), (-0.5, 0.5), (0.5, math.nan)])
def test_bad_ratios(ratios):
    with pytest.raises(InputError, match=r"^aspect: got \[.*\], allowed: two ratios b/a and c"):
        POPULATION.with_aspect(*ratios)


def test_a_sphere_has_no_other_ratios():
    spheres = POPULATION.restricted_to("sphere")
    assert spheres.with_aspect(1.0, 1.0) == spheres
    with pytest.raises(InputError, match=r"^aspect: got \[0.5, 1\], allowed for spheres: \[1,"):
        spheres.with_aspect(0.5, 1.0)
