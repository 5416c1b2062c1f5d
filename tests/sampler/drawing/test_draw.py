"""The draw against an independent implementation, with scripted words at every end."""

import itertools

import numba
import numpy as np
import pytest
from reference_draw import key_words, reference_draw
from sampler.formats.image import _MARGIN, table_arrays
from synthetic_table import ALPHA_DEG, HALF, SPEED, make_contents, make_datasets

import sampler
from sampler import errors
from sampler.compilation.jit import no_refcount_kernel
from sampler.drawing import kernel, steps
from sampler.drawing.batch import draw_batch
from sampler.formats.channels import VARIABLES

pytestmark = pytest.mark.processor

ENDS = (0, 1, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFE, 0xFFFFFFFF)

#: Quantiles of a cell are 16-bit steps, half a step of the largest range of 3.7 at most; what lies
#: between random words and quantiles is in single precision.
TOLERANCE = 0.5 * 3.7 / 65535 + 1e-5
MIDDLE = (0x5A5A5A5A, 0x3C3C3C3D, 0x12345678, 0x9ABCDEF0, 0x0F1E2D3C, 0x4B5A6978, 0x8796A5B4, 1)


@no_refcount_kernel
def _draw_words(arrays, alpha1, speed, words, values):
    kernel.draw_one(arrays, words, alpha1, speed, values)
    return kernel.status_of(arrays, alpha1[0], speed[0])


def _draw(arrays, alpha1, speed, words):
    """Status and state from scripted words."""
    words = np.array(words, dtype=np.uint32)
    # words 8 and 11 belong to no channel
    words = np.concatenate((words[:8], words[9:11], np.zeros(2, dtype=np.uint32)))
    values = np.empty(kernel.N_VALUES)
    code = _draw_words(arrays, np.array([alpha1]), np.array([speed]), words, values)
    return code, values[:6]


def _check(contents, arrays, alpha1, speed, words):
    """A draw is that of the specification."""
    code, state = _draw(arrays, alpha1, speed, words)
    assert code == errors.OK
    expected = reference_draw(contents, alpha1, speed, words)
    np.testing.assert_allclose(state, expected, rtol=0, atol=TOLERANCE)


def _conditions():
    """Nodes, middles of cells and the four corners of the domain."""
    alphas = np.deg2rad([20.0, 27.3, 50.0, 71.9, 90.0])
    return list(itertools.product(alphas, [50.0, 88.8, 120.0, 210.0, 300.0]))


@pytest.mark.parametrize("places", [*range(8), slice(None)])
def test_words_at_their_ends(contents, places):
    """Each at its ends, the others in the middle; and all at the same end."""
    arrays = table_arrays(contents)
    for word, (alpha1, speed) in itertools.product(ENDS, _conditions()):
        words = np.array(MIDDLE)
        words[places] = word
        _check(contents, arrays, alpha1, speed, words)


def test_draws_from_keys(table, contents):
    rng = np.random.default_rng(5)
    n = 200
    alpha1, speed = rng.uniform(0.35, np.pi / 2, n), rng.uniform(50.0, 300.0, n)
    index = rng.integers(0, 2**64, n, dtype=np.uint64)
    hit = rng.integers(0, 2**32, n, dtype=np.uint32)
    seed = 0xFEDCBA9876543210
    states = table.sample(alpha1, speed, seed=seed, index=index, hit=hit)
    for k in range(n):
        words = key_words(seed, int(index[k]), int(hit[k]))
        expected = reference_draw(contents, alpha1[k], speed[k], words)
        np.testing.assert_allclose(states[k], expected, rtol=0, atol=TOLERANCE)


def test_a_draw_takes_eight_words_and_no_more(table, contents):
    """Every word of the first two blocks matters, and no other."""
    alpha1, speed = 0.7, 100.0
    words = key_words(9, 4, 2)
    assert len(words) == 12
    _, state = _draw(table.arrays, alpha1, speed, words)
    np.testing.assert_array_equal(state, table.sample(alpha1, speed, seed=9, index=4, hit=2))
    for place in range(12):
        changed = list(words)
        changed[place] ^= 0xFFFFFFFF
        same = np.array_equal(_draw(table.arrays, alpha1, speed, changed)[1], state)
        assert same == (place >= 8), place


def test_corner_shares_are_the_bilinear_weights():
    # Equally spaced words: a quadrature, not a sample. 2**16 of them resolve 2e-5.
    words = np.arange(2**15, 2**32, 2**16, dtype=np.uint32)
    for t, r in [(0.3, 0.8), (0.5, 0.5), (0.01, 0.99)]:
        counts = np.zeros((2, 2))
        for word in words:
            a, b = steps.choose_corner(word, steps.corner_weights(t, r))
            counts[int(a), int(b)] += 1
        expected = np.outer([1 - t, t], [1 - r, r])
        np.testing.assert_allclose(counts / len(words), expected, atol=1e-4)


@pytest.mark.parametrize("word", ENDS)
def test_corner_of_weight_zero_is_never_chosen(word):
    for t, r in itertools.product([0.0, 1.0], repeat=2):
        chosen = steps.choose_corner(np.uint32(word), steps.corner_weights(t, r))
        assert chosen == (t == 1.0, r == 1.0)


def test_component_shares_are_the_weights(contents):
    arrays = table_arrays(contents)
    probability = contents["dependence/alias_probability"][1, 1] / 65536.0
    index = contents["dependence/alias_index"][1, 1]
    n = len(probability)
    weight = probability / n
    np.add.at(weight, index, (1.0 - probability) / n)
    words = np.arange(2**14, 2**32, 2**15, dtype=np.uint32)
    chosen = []
    for word in words:
        column, fraction = steps.choose_column(word, n)
        chosen.append(steps.choose_component(column, fraction, arrays.alias[4 * n + column]))
    share = np.bincount(chosen, minlength=n) / len(words)
    assert weight.max() - weight.min() > 0.05  # unequal, or any choice would pass
    np.testing.assert_allclose(share, weight, atol=1e-4)


@pytest.mark.parametrize("first", [(0, 2), (0, 0), (0, 5)], ids=["both", "second", "first"])
def test_class_of_a_component(first):
    """A class may be empty; every component belongs to one that is not."""
    datasets = make_datasets()
    datasets["dependence/first_of_class"][1, 1] = first
    contents = make_contents(datasets)
    arrays = table_arrays(contents)
    for words in np.random.default_rng(4).integers(0, 2**32, (100, 8)):
        _check(contents, arrays, np.deg2rad(ALPHA_DEG[1]), SPEED[1], words)


def test_reflection_is_exact(contents):
    arrays = table_arrays(contents)
    rng = np.random.default_rng(11)
    for _ in range(50):
        words = rng.integers(0, 2**32, 8, dtype=np.uint64)
        words[1] = words[1] // 4096 * 4096 + HALF
        _, state = _draw(arrays, 0.9, 130.0, words)
        words[1] -= 1
        _, image = _draw(arrays, 0.9, 130.0, words)
        plane = [VARIABLES.index(name) for name in ("u", "v", "omega_z")]
        odd = [VARIABLES.index(name) for name in ("w", "omega_x", "omega_y")]
        np.testing.assert_array_equal(image[plane], state[plane])
        # The quantile functions were rounded on either side of zero.
        np.testing.assert_allclose(image[odd], -state[odd], rtol=0, atol=2 * TOLERANCE)
        assert np.abs(state[odd]).min() > 2 * TOLERANCE


@pytest.mark.parametrize("stored", [0, 1, 1000, 4095, 4096])
def test_reflection_has_the_stored_probability(stored):
    """Of the 4096 values of the lower bits, as many reflect as the file says."""
    plain, mirrored = (
        table_arrays(make_contents(make_datasets(reflection=r))) for r in (stored, HALF)
    )
    # the quantiles of one table with the reflection of another: only the sign counts here
    arrays = mirrored._replace(components=plain.components)
    words = list(MIDDLE)
    signs = []
    for low in range(4096):
        words[1] = MIDDLE[1] // 4096 * 4096 + low
        signs.append(_draw(arrays, 0.9, 130.0, words)[1][3] > 0.0)
    flips = np.array(signs) != signs[-1]
    assert flips.sum() in (stored % 4096, stored)


@pytest.mark.parametrize(
    ("alpha1", "speed", "code"),
    [
        (np.nan, 100.0, errors.NOT_FINITE),
        (np.inf, 100.0, errors.NOT_FINITE),
        (0.5, np.nan, errors.NOT_FINITE),
        (0.5, -np.inf, errors.NOT_FINITE),
        (0.0, 100.0, errors.NOT_APPROACHING),
        (-0.1, 100.0, errors.NOT_APPROACHING),
        (np.pi / 2 + 1e-9, 100.0, errors.NOT_APPROACHING),
        (0.5, 0.0, errors.SPEED_NOT_POSITIVE),
        (0.5, -1.0, errors.SPEED_NOT_POSITIVE),
    ],
)
def test_refused_conditions_write_nothing(table, alpha1, speed, code):
    state = np.full(6, -7.0)
    assert sampler.draw(table.arrays, alpha1, speed, 1, 2, 3, state) == code
    assert code < 0
    np.testing.assert_array_equal(state, -7.0)


@pytest.mark.parametrize(
    ("alpha1", "speed", "nearest"),
    [
        (1e-9, 100.0, (np.deg2rad(20.0), 100.0)),
        (0.5, 1e-9, (0.5, 50.0)),
        (0.5, 1e9, (0.5, 300.0)),
        (0.1, 301.0, (np.deg2rad(20.0), 300.0)),
    ],
)
def test_outside_takes_the_nearest_condition(table, alpha1, speed, nearest):
    state, expected = np.empty(6), np.empty(6)
    assert sampler.draw(table.arrays, alpha1, speed, 1, 2, 3, state) == errors.CLAMPED
    assert sampler.draw(table.arrays, *nearest, 1, 2, 3, expected) == errors.OK
    np.testing.assert_array_equal(state, expected)


def test_rounding_at_the_edge_is_not_outside(table):
    state = np.empty(6)
    for alpha1 in (np.nextafter(np.deg2rad(20.0), 0.0), np.nextafter(np.pi / 2, 2.0)):
        assert sampler.draw(table.arrays, alpha1, 300.0 * (1 + 1e-15), 1, 2, 3, state) == errors.OK


def test_axis_of_one_node():
    datasets = make_datasets(alpha_deg=ALPHA_DEG[1:2], speed=SPEED[:1])
    contents = make_contents(datasets)
    arrays = table_arrays(contents)
    code, state = _draw(arrays, np.deg2rad(50.0), 50.0, MIDDLE)
    assert code == errors.OK
    assert _draw(arrays, np.deg2rad(51.0), 50.0, MIDDLE)[0] == errors.CLAMPED
    # A cell whose four corners are that node must say the same.
    wide = make_datasets(alpha_deg=[40.0, 50.0], speed=[50.0, 60.0])
    for path, values in datasets.items():
        if not path.startswith("axes/"):
            repeat = values.ndim > 2
            wide[path] = np.tile(values, (2, 2) + (1,) * (values.ndim - 2)) if repeat else values
    _, same = _draw(table_arrays(make_contents(wide)), np.deg2rad(44.0), 57.0, MIDDLE)
    np.testing.assert_allclose(state, same, rtol=0, atol=1e-15)


def test_scalar_draw_in_user_code_equals_the_batch(table):
    draw = sampler.draw

    @numba.njit
    def run(arrays, alpha1, speed, states):
        worst = 0
        for k in range(states.shape[0]):
            # Signed loop counters and literals as keys: what users write.
            worst = min(worst, draw(arrays, alpha1[k], speed[k], 7, k, 3, states[k]))
        return worst

    rng = np.random.default_rng(2)
    alpha1, speed = rng.uniform(0.4, 1.5, 500), rng.uniform(60.0, 290.0, 500)
    states = np.empty((500, 6))
    assert run(table.arrays, alpha1, speed, states) == errors.OK
    np.testing.assert_array_equal(
        states, table.sample(alpha1, speed, seed=7, index=range(500), hit=3)
    )


def test_extreme_quantiles_keep_the_physics():
    """Quantiles as close to their bounds as float32 allows, at every combination of ends."""
    datasets = make_datasets()
    end, tiny = np.nextafter(np.float32(1), np.float32(0)), np.finfo(np.float32).tiny
    quantiles = datasets["marginals/quantiles"]
    n_knots = quantiles.shape[-1]
    quantiles[..., 0, :] = np.where(np.arange(n_knots) < n_knots // 2, tiny, end)
    for channel in (1, 3):
        quantiles[..., channel, :] = np.where(np.arange(n_knots) < n_knots // 2, -end, end)
    arrays = table_arrays(make_contents(datasets))
    for words in itertools.product((0, 0x7FFFFFFF, 0xFFFFFFFF), repeat=5):
        w = [words[0], words[1], words[2], words[3], 5, words[4], 6, 7]
        code, state = _draw(arrays, 0.8, 77.0, w)
        assert code == errors.OK
        assert np.isfinite(state).all()
        assert state[1] > 0.0
        assert (state[:3] ** 2).sum() <= 1.0


@pytest.mark.parametrize(("margin", "stays"), [(_MARGIN, True), (0.0, False)])
def test_rounding_does_not_lead_beyond_the_largest_quantile(contents, margin, stays):
    """All quantiles at their last step: what a draw gives is rounding alone."""
    arrays = table_arrays(contents)
    spans, steps = arrays.spans.copy(), np.full_like(arrays.quantiles, 65535)
    spans[0::2], spans[1::2] = 0.5, 0.25 * (1.0 - margin) / 65535
    rng = np.random.default_rng(6)
    n = 100_000
    alpha1, speed = rng.uniform(0.35, np.pi / 2, n), rng.uniform(50.0, 300.0, n)
    index, hit, states = np.arange(n, dtype=np.uint64), np.zeros(1, np.uint32), np.empty((n, 6))
    changed = arrays._replace(spans=spans, quantiles=steps)
    draw_batch(changed, alpha1, speed, np.uint64(0), index, hit, states, 0, n)
    assert (states[:, 1].max() <= 0.75) == stays
    assert states[:, 1].min() > 0.75 * (1.0 - 2e-6)
