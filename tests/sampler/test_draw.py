"""The draw against an independent implementation, with scripted words at every end."""

import itertools

import numpy as np
import pytest
from reference_draw import key_words, reference_draw
from scripted import Scripted, build_scripted
from small_tables import SMALL_TABLES
from synthetic_table import ALPHA_DEG, SPEED, make_contents, make_datasets

import sampler
from sampler import errors
from sampler.formats.image import header_of, table_image
from sampler.library import OpenTable

pytestmark = pytest.mark.processor

ENDS = (0, 1, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFE, 0xFFFFFFFF)

#: Quantiles of a cell are 16-bit steps, half a step of the largest range of 3.7 at most; what lies
#: between random words and quantiles is in single precision.
TOLERANCE = 0.5 * 3.7 / 65535 + 1e-5
MIDDLE = (0x5A5A5A5A, 0x3C3C3C3D, 0x12345678, 0x9ABCDEF0, 0x0F1E2D3C, 0x4B5A6978, 0x8796A5B4, 1)


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    return build_scripted(tmp_path_factory.mktemp("scripted"))


@pytest.fixture
def script(library):
    """Make a function that draws from contents by scripted words."""
    return lambda contents: Scripted(library, OpenTable(table_image(contents))).draw


def _check(contents, draw, alpha1, speed, words):
    code, state = draw(alpha1, speed, words)
    assert code == errors.OK
    expected = reference_draw(contents, alpha1, speed, words)
    np.testing.assert_allclose(state, expected, rtol=0, atol=TOLERANCE)


def _conditions():
    """Nodes, middles of cells and the four corners of the domain."""
    alphas = np.deg2rad([20.0, 27.3, 50.0, 71.9, 90.0])
    return list(itertools.product(alphas, [50.0, 88.8, 120.0, 210.0, 300.0]))


@pytest.mark.parametrize("places", [*range(8), slice(None)])
def test_words_at_their_ends(script, contents, places):
    """Each at its ends, the others in the middle; and all at the same end."""
    draw = script(contents)
    for word, (alpha1, speed) in itertools.product(ENDS, _conditions()):
        words = np.array(MIDDLE)
        words[places] = word
        _check(contents, draw, alpha1, speed, words)


@pytest.mark.parametrize("make", SMALL_TABLES.values(), ids=SMALL_TABLES)
def test_draws_from_keys(make):
    contents, rng, n = make(), np.random.default_rng(5), 200
    table = sampler.Table(contents)
    alpha1, speed = (
        rng.uniform(*np.radians(table.alpha_nodes_deg[[0, -1]]), n),
        rng.uniform(*table.speed_nodes[[0, -1]], n),
    )
    index = rng.integers(0, 2**64, n, dtype=np.uint64)
    hit = rng.integers(0, 2**32, n, dtype=np.uint32)
    seed = 0xFEDCBA9876543210
    states = table.sample(alpha1, speed, seed=seed, index=index, hit=hit)
    for k in range(n):
        words = key_words(seed, int(index[k]), int(hit[k]))
        expected = reference_draw(contents, alpha1[k], speed[k], words)
        np.testing.assert_allclose(states[k], expected, rtol=0, atol=TOLERANCE)


def test_shares_of_nodes_and_components(script, contents):
    """Equally spaced words, a quadrature: bilinear weights of the corners, weights of components.

    The quantile of v at the middle of each component differs from node to node, and so tells them.
    """
    draw = script(contents)
    alpha1, speed = np.deg2rad(27.3), 88.8
    words = np.tile(MIDDLE, (2**12, 1))
    words[:, 1] = (np.arange(2**12) << 20) + 2**19
    states = np.array([draw(alpha1, speed, row)[1] for row in words])
    reference = np.array([reference_draw(contents, alpha1, speed, row) for row in words])
    # the corner changes at three words: four plateaus, with the bilinear weights as lengths
    lengths, expected = (
        np.diff(np.flatnonzero(np.r_[True, (np.abs(np.diff(x, axis=0)) > least).any(axis=1), True]))
        for x, least in ((states, 0.0), (reference, 1e-9))
    )
    np.testing.assert_array_equal(lengths, expected)
    assert len(lengths) >= 3


@pytest.mark.parametrize("first", [(0, 2), (0, 0), (0, 5)], ids=["both", "second", "first"])
def test_class_of_a_component(script, first):
    """A class may be empty; every component belongs to one that is not."""
    datasets = make_datasets()
    datasets["dependence/first_of_class"][1, 1] = first
    contents = make_contents(datasets)
    draw = script(contents)
    for words in np.random.default_rng(4).integers(0, 2**32, (100, 8)):
        _check(contents, draw, np.deg2rad(ALPHA_DEG[1]), SPEED[1], words)


@pytest.mark.parametrize(
    ("alpha1", "speed", "nearest", "flags"),
    [
        (1e-9, 100.0, (np.deg2rad(20.0), 100.0), errors.ANGLE),
        (0.5, 1e-9, (0.5, 50.0), errors.SPEED),
        (0.5, 1e9, (0.5, 300.0), errors.SPEED),
        (0.1, 301.0, (np.deg2rad(20.0), 300.0), errors.ANGLE | errors.SPEED),
    ],
)
def test_outside_takes_the_nearest_condition(script, contents, alpha1, speed, nearest, flags):
    draw = script(contents)
    (code, state), (inside, expected) = draw(alpha1, speed, MIDDLE), draw(*nearest, MIDDLE)
    assert (code, inside) == (flags, errors.OK)
    np.testing.assert_array_equal(state, expected)


def test_rounding_at_the_edge_is_not_outside(script, contents):
    draw = script(contents)
    for alpha1 in (np.nextafter(np.deg2rad(20.0), 0.0), np.nextafter(np.pi / 2, 2.0)):
        assert draw(alpha1, 300.0 * (1 + 1e-15), MIDDLE)[0] == errors.OK


def test_axis_of_one_node(script):
    datasets = make_datasets(alpha_deg=ALPHA_DEG[1:2], speed=SPEED[:1])
    contents = make_contents(datasets)
    code, state = script(contents)(np.deg2rad(50.0), 50.0, MIDDLE)
    assert code == errors.OK
    assert script(contents)(np.deg2rad(51.0), 50.0, MIDDLE)[0] == errors.ANGLE
    # A cell whose four corners are that node must say the same.
    wide = make_datasets(alpha_deg=[40.0, 50.0], speed=[50.0, 60.0])
    for path, values in datasets.items():
        if not path.startswith("axes/"):
            repeat = values.ndim > 2
            wide[path] = np.tile(values, (2, 2) + (1,) * (values.ndim - 2)) if repeat else values
    _, same = script(make_contents(wide))(np.deg2rad(44.0), 57.0, MIDDLE)
    np.testing.assert_allclose(state, same, rtol=0, atol=1e-15)


@pytest.mark.parametrize(("short", "stays"), [(1e-6, True), (0.0, False)])
def test_rounding_does_not_lead_beyond_the_largest_quantile(contents, short, stays):
    """All quantiles at their last step: a draw differs from it by rounding alone."""
    image = table_image(contents)
    header = header_of(image)
    spans = image[int(header["at_spans"]) : int(header["at_quantiles"])].view(np.float64)
    steps = image[int(header["at_quantiles"]) :].view(np.uint16)
    spans[0::2], spans[1::2] = 0.5, 0.25 * (1.0 - short) / 65535
    steps[:] = 65535
    table = sampler.Table(contents)
    table._table.image[:] = image  # behind the checks of the library
    rng = np.random.default_rng(6)
    n = 100_000
    alpha1, speed = rng.uniform(0.35, np.pi / 2, n), rng.uniform(50.0, 300.0, n)
    states = table.sample(alpha1, speed, seed=0, index=np.arange(n))
    assert (states[:, 1].max() <= 0.75) == stays
    assert states[:, 1].min() > 0.75 * (1.0 - 2e-6)
