"""Half-sizes, moments of inertia and sphericities of grains, of shapes and of meshes."""

from dataclasses import replace

import numpy as np
import pytest
from refusals import refused
from scipy.spatial import ConvexHull
from scipy.special import elliprg
from sized_tables import CUT, RATIOS, sized_contents

import sampler
from sampler.formats.shape_codes import FIRST_MESH
from tablegen.model.shapes import inertia, place_vertices

D = 50e-6


CONTENTS = sized_contents()


@pytest.fixture(scope="module")
def sized():
    return sampler.Table(CONTENTS)


def grain_of(code):
    row = CONTENTS["spin/shape_codes"].tolist().index(code)
    return (code, *CONTENTS["spin/ratio_range"][row, :, 0])


@pytest.mark.parametrize("shape", [0, 1, 2, 3])
def test_a_shape_has_the_volume_surface_and_inertia_of_its_hull(sized, shape):
    """Truncated prisms are not cut as by default."""
    corners = np.zeros((24, 3))
    b, c = RATIOS[0], RATIOS[0] * RATIOS[1]
    n, _ = place_vertices(shape, b, c, CUT, corners)
    hull, grain = ConvexHull(corners[:n]) if n else None, (shape, *RATIOS)
    volume = hull.volume if n else 4.0 / 3.0 * np.pi * b * c
    ellipsoid = 4.0 * np.pi * elliprg(b * b, c * c, (b * c) ** 2)  # DLMF 19.33.1
    surface = hull.area if n else ellipsoid
    a = sampler.half_size(sized, D, grain)
    assert volume * a**3 == pytest.approx(np.pi / 6.0 * D**3, rel=1e-12)
    assert sampler.sphericity(sized, grain) * surface * a**2 == pytest.approx(
        np.pi * D**2, rel=1e-12
    )
    assert sampler.mean_inertia(sized, grain) == pytest.approx(
        np.mean(inertia(shape, b, c, CUT)), rel=1e-12
    )


@pytest.mark.parametrize(
    ("mesh", "half_size", "moment", "sphericity", "within"),
    [
        # an octahedron; its principal axes are chosen so that one of them is normal to a face
        (0, np.sqrt(2.0 / 3.0) / (8.0 / np.pi) ** (1 / 3), 0.3, 0.8456, 1e-4),
        (1, (np.pi / 48.0) ** (1 / 3), 2.0 / 3.0, (np.pi / 6.0) ** (1 / 3), 1e-12),  # a cube
        (2, 0.5, 0.4, 1.0, 0.004),  # nearly a sphere
    ],
)
def test_a_mesh_has_its_own_size(sized, mesh, half_size, moment, sphericity, within):
    grain = grain_of(FIRST_MESH + mesh)
    assert sampler.half_size(sized, 1.0, grain) == pytest.approx(half_size, rel=within)
    assert sampler.mean_inertia(sized, grain) == pytest.approx(moment, rel=max(within, 1e-12))
    assert sampler.sphericity(sized, grain) == pytest.approx(sphericity, rel=within)


def test_a_mesh_of_a_box_is_the_prism(sized):
    """The cube of the meshes and a prism of the same ratios."""
    mesh, prism = grain_of(FIRST_MESH + 1), (1, 1.0, 1.0)
    shipped = sampler.load("corundum-steel-compact")
    for size in (sampler.mean_inertia, sampler.sphericity):
        assert size(sized, mesh) == pytest.approx(size(shipped, prism), rel=1e-12)


def test_rows_and_what_is_no_grain(sized):
    shipped = sampler.load("corundum-steel-compact")
    grains = np.column_stack([range(4), np.full((4, 2), 0.8)])
    half_sizes = sampler.half_size(shipped, 1.0, grains)
    np.testing.assert_allclose(half_sizes, [0.62, 0.50, 0.51, 0.73], atol=0.005)
    each = sampler.half_size(shipped, [1.0, 2.0, 1.0, 1.0], grains)
    np.testing.assert_array_equal(each, half_sizes * [1.0, 2.0, 1.0, 1.0])
    for grain in (
        (FIRST_MESH, 0.8, 0.8),
        (0, 1.1, 0.8),
        (1, 0.0, 0.8),
        (0, np.nan, 0.8),
        (0.8, 0.8),
    ):
        refused("grain", sampler.sphericity, shipped, grain)
    refused("diameter", sampler.half_size, shipped, -1.0, (1, 0.8, 0.8))
    with pytest.raises(sampler.InputError, match=r"^grain: got 9, 1, 1 at index 1"):
        sampler.mean_inertia(sized, [(0, *RATIOS), (9, 1, 1)])
    spheres = sampler.load("kharaz-2001")
    assert (
        sampler.half_size(spheres, D, (4, 1, 1))
        == spheres.mean_half_size(D)
        == pytest.approx(D / 2)
    )
    assert sampler.sphericity(spheres, (4, 1, 1)) == pytest.approx(1.0, rel=1e-15)
    assert sampler.mean_inertia(spheres, (4, 1, 1)) == pytest.approx(0.4, rel=1e-15)


@pytest.mark.parametrize("name", ["shipped", "sized"])
def test_the_mean_is_that_of_the_grains(sized, name):
    """The sample of 1e5 has a standard error below 0.0006; 4 of them: 6e-5 false alarms."""
    table = sized if name == "sized" else sampler.load("corundum-steel-compact")
    each = sampler.half_size(table, 1.0, table.grains(7, np.arange(100_000)))
    assert float(table.mean_half_size(D)) == pytest.approx(D * each.mean(), rel=0.0045)


def test_a_table_without_a_spin_law_has_no_grains(table):
    with pytest.raises(sampler.InputError, match=r"^mean_half_size: the table made-up has no spin"):
        table.mean_half_size(D)
    refused("grain", sampler.half_size, table, D, (4, 1, 1))


def test_geometry_is_checked():
    wrong = CONTENTS["spin/shape_geometry"].copy()
    wrong[0, 0] = 0.0
    with pytest.raises(sampler.TableError, match="spin/shape_geometry"):
        replace(CONTENTS, datasets=CONTENTS.datasets | {"spin/shape_geometry": wrong})
