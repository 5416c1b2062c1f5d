"""The normal quantile against scipy's, an independent implementation (Cephes)."""

import numba
import numpy as np
import pytest
from make_normal_cubics import cubics
from sampler.formats.image import normal_table
from scipy.special import ndtr, ndtri

from sampler.compilation.jit import kernel
from sampler.drawing.normal import normal_cdf, normal_of_word, normal_quantile

# called from Python here
normal_of_word = kernel(normal_of_word)
normal_quantile = kernel(normal_quantile)

pytestmark = pytest.mark.processor

_STEP = 2.0**-32
ENDS = (0.5 * _STEP, 1.5 * _STEP, 1.0 - 1.5 * _STEP, 1.0 - 0.5 * _STEP)


@pytest.mark.parametrize(
    "p",
    [1e-300, 1e-12, 1e-5, 0.075, 0.0750001, 0.2, 0.5, 0.925, 0.9999, *ENDS],
)
def test_quantile_at_chosen_points(p):
    assert normal_quantile(p) == pytest.approx(ndtri(p), rel=2e-14, abs=1e-15)


def test_quantile_on_a_grid_of_words():
    p = (np.arange(0, 2**32, 2**18 + 1) + 0.5) * _STEP
    ours = np.array([normal_quantile(x) for x in p])
    np.testing.assert_allclose(ours, ndtri(p), rtol=2e-14, atol=1e-14)
    assert np.all(np.diff(ours) > 0.0)


def test_quantile_continues_across_its_pieces():
    # 0.075 and 0.925 part centre from tail, exp(-25) near from far tail.
    for edge in (0.075, 0.925, np.exp(-25.0)):
        below, above = normal_quantile(edge * (1 - 1e-13)), normal_quantile(edge * (1 + 1e-13))
        assert abs(above - below) < 1e-11


def test_cdf_over_the_whole_range():
    x = np.linspace(-37.0, 8.0, 1001)
    ours = np.array([normal_cdf(value) for value in x])
    np.testing.assert_allclose(ours, ndtr(x), rtol=1e-12)


@numba.njit
def _normals(table, words):
    normals = np.empty(words.size, np.float32)
    for k in range(words.size):
        normals[k] = normal_of_word(table, words[k])
    return normals


def _words():
    """A grid of words, and neighbours of every end of a cubic."""
    ends = [(1 << octave) + (piece << octave >> 3) for octave in range(31) for piece in range(8)]
    near = [(end + step) % 2**32 for end in (0, *ends, 2**31) for step in (-2, -1, 0, 1, 2)]
    words = np.concatenate([np.arange(0, 2**32, 2**14 + 1), near])
    return np.concatenate([words, 2**32 - 1 - words]).astype(np.uint32)


def test_cubics_are_those_of_the_script():
    """To one step of single precision: their own last bits are those of the machine at hand."""

    def misses(table):
        return np.abs(table - cubics()) > 1.2e-7 * np.abs(cubics()) + 1e-12

    table = normal_table()
    assert table.dtype == np.float32
    assert not misses(table).any()
    table[100, 3] *= np.float32(1.0 + 4e-7)
    assert misses(table).sum() == 1


def test_normals_of_words():
    words = _words()
    ours = _normals(normal_table(), words)
    np.testing.assert_allclose(ours, ndtri((words + 0.5) * _STEP), rtol=0, atol=1e-6)


def test_normals_of_words_are_odd_and_grow():
    words = np.unique(_words())
    table = normal_table()
    ours = _normals(table, words)
    np.testing.assert_array_equal(_normals(table, ~words), -ours)
    # neighbouring cubics may miss each other by twice their error
    assert np.diff(ours).min() > -2e-6
    # a table with a wrong cubic is seen
    wrong = table.copy()
    wrong[100, 1] += 1e-5
    assert np.abs(_normals(wrong, words) - ours).max() > 4e-6
