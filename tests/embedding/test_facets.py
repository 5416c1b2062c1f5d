"""Tilts of facets that the C header draws have the densities that it states, at any angle."""

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
"""
COUNT = 100_000


@pytest.fixture(scope="module")
def tilts(tmp_path_factory):
    """Draw tilts by the function of the header."""
    source = tmp_path_factory.mktemp("facets") / "facets.c"
    declaration = "void tilts(size_t n, double alpha1, double roughness, int across, double *);\n"
    source.write_text(toolchain.IMPLEMENTATION + declaration + PROGRAM)
    library = toolchain.load_library(source, toolchain.QUICK)
    ctypes = toolchain.ctypes
    library.tilts.argtypes = [ctypes.c_size_t, ctypes.c_double, ctypes.c_double, ctypes.c_int]
    library.tilts.argtypes += [ctypes.c_void_p]

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
