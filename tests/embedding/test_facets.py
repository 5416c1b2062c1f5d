"""Tilts of facets that the C header draws have the densities that it states, at any angle."""

import itertools

import numpy as np
import pytest
import toolchain
from scipy.integrate import cumulative_simpson
from scipy.stats import kstest

PROGRAM = """
void tilts(size_t n, double alpha1, double roughness, int across, double *tilt)
{
    rbti_cascade facets = {.roughness = roughness};
    for (size_t k = 0; k < n; k++)
        tilt[k] = rbti_find_tilt(&facets, across, alpha1, 7, k, 3);
}

void normals(size_t n, const double velocity[3], double roughness, int isotropic, double *normal)
{
    const double up[3] = {0.0, 2.0, 0.0};
    rbti_cascade facets;
    rbti_impact impact;
    for (size_t k = 0; k < n; k++) {
        int code = rbti_begin_cascade(velocity, up, 1e-5, NULL, roughness, isotropic, &facets);
        code |= rbti_meet_facet(&facets, 3, k, 0, &impact);
        for (size_t c = 0; c < 3; c++)
            normal[3 * k + c] = code == RBT_OK ? impact.e_y[c] : 0.0;
    }
}
"""
COUNT = 100_000


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """Functions of the header as a library."""
    source = tmp_path_factory.mktemp("facets") / "facets.c"
    declarations = (
        "void tilts(size_t n, double alpha1, double roughness, int across, double *);\n"
        "void normals(size_t n, const double v[3], double roughness, int isotropic, double *);\n"
    )
    source.write_text(toolchain.IMPLEMENTATION + declarations + PROGRAM)
    library = toolchain.load_library(source, toolchain.QUICK)
    number, count, flag, array = (
        getattr(toolchain.ctypes, f"c_{name}") for name in ("double", "size_t", "int", "void_p")
    )
    library.tilts.argtypes = [count, number, number, flag, array]
    library.normals.argtypes = [count, array, number, flag, array]
    return library


@pytest.fixture(scope="module")
def tilts(library):
    """Draw tilts."""

    def draw(alpha1, roughness, across):
        drawn = np.empty(COUNT)
        library.tilts(COUNT, alpha1, roughness, across, drawn.ctypes.data)
        return drawn

    return draw


def law(alpha1, roughness, across):
    """Distribution function of the tilt, by integration of its density."""
    end = min(12.0 * roughness, 0.5 * np.pi)
    tilt = np.linspace(-end, end, 200_001)
    seen = np.cos(tilt) if across else np.sin(np.clip(alpha1 + tilt, 0.0, np.pi))
    density = np.exp(-0.5 * (tilt / roughness) ** 2) * seen
    total = cumulative_simpson(density, x=tilt, initial=0.0)
    return lambda x: np.interp(x, tilt, total / total[-1])


@pytest.mark.parametrize("across", [False, True])
@pytest.mark.parametrize("roughness", [1e-3, 0.1, 0.5])
@pytest.mark.parametrize("degrees", [0.0, 0.1, 3.0, 30.0, 90.0])
def test_tilts_follow_their_density(tilts, degrees, roughness, across):
    """False-alarm rate 1e-7 for each of thirty cases."""
    alpha1 = np.radians(degrees)
    result = kstest(tilts(alpha1, roughness, across), law(alpha1, roughness, across))
    assert result.pvalue > 1e-7


def test_a_wrong_density_is_seen(tilts):
    """As if facets were met by their number, and not by the area that the particle sees."""
    alpha1 = np.radians(3.0)
    assert kstest(tilts(alpha1, 0.1, False), law(alpha1, 0.1, True)).pvalue < 1e-7


@pytest.mark.parametrize("isotropic", [False, True])
@pytest.mark.parametrize("alpha_deg", [3.0, 30.0, 90.0])
def test_particles_meet_facets_by_their_projected_area(library, alpha_deg, isotropic):
    """Moments of the normals against quadrature over the facets of a wall; false alarms 1e-5.

    A length of a section of the wall has normal tilts, and its extent along the mean wall is the
    cosine: what lies over it is seen by its area, where it faces the particle.
    """
    n, roughness, alpha = 40_000, 0.4, np.radians(alpha_deg)
    path = np.array([np.cos(alpha), -np.sin(alpha), 0.0])
    g, h = np.meshgrid(*[np.pi * ((np.arange(600) + 0.5) / 600 - 0.5)] * 2)
    h = h if isotropic else 0.0 * h
    normal = np.stack([-np.tan(g), np.ones_like(g), np.tan(h)], axis=-1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    share = np.exp(-(g**2 + h**2) / (2 * roughness**2)) * np.cos(g) * np.cos(h)
    weight = share * np.maximum(-normal @ path, 0.0) / normal[..., 1]

    drawn, velocity = np.empty((n, 3)), 100.0 * path
    library.normals(n, velocity.ctypes.data, roughness, isotropic, drawn.ctypes.data)
    if alpha_deg == 90.0:  # any plane of incidence: about the normal only its own component counts
        drawn, normal = drawn[:, 1:2], normal[..., 1:2]
    parts = range(drawn.shape[1])
    for powers in [(k,) for k in parts] + [*itertools.combinations_with_replacement(parts, 2)]:
        values, expected = drawn[:, powers].prod(axis=1), normal[..., powers].prod(axis=-1)
        mean = np.average(expected, weights=weight)
        error = np.sqrt(np.average((expected - mean) ** 2, weights=weight) / n)
        assert abs(values.mean() - mean) <= 5.0 * error + 1e-12
