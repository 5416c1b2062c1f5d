"""An array of the user's to write to: the states, or what it held."""

import numpy as np
import pytest

import sampler
from sampler import InputError

N = 50_000


def _conditions():
    rng = np.random.default_rng(1)
    return {"alpha1": rng.uniform(0.36, np.pi / 2, N), "speed": rng.uniform(50.0, 300.0, N)}


@pytest.mark.parametrize(("count", "threads"), [(N, 1), (N, 2), (1001, 1)])
@pytest.mark.parametrize(
    ("outside", "name", "value"),
    [
        ("clamp", "alpha1", np.nan),
        ("clamp", "alpha1", 0.0),
        ("clamp", "alpha1", -0.1),
        ("clamp", "alpha1", 1.6),
        ("clamp", "speed", np.inf),
        ("clamp", "speed", 0.0),
        ("raise", "alpha1", 0.01),
        ("raise", "speed", 1e4),
        ("raise", "speed", np.nan),
    ],
)
def test_is_left_as_it_was_if_a_row_is_refused(table_path, count, threads, outside, name, value):
    table = sampler.load(table_path, outside=outside)
    given = {key: values[:count] for key, values in _conditions().items()}
    given[name][count - 1000] = value
    out = np.full((count, 6), 7.0)
    with pytest.raises(InputError, match=f"{name}: got .* at row {count - 1000} .*, allowed"):
        table.sample(**given, seed=1, index=range(count), threads=threads, out=out)
    assert (out == 7.0).all()


def test_is_left_as_it_was_if_threads_are_refused(table):
    out = np.full(6, 7.0)
    with pytest.raises(InputError, match="threads"):
        table.sample(0.7, 100.0, seed=1, index=0, threads=0, out=out)
    assert (out == 7.0).all()


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize(
    ("alpha1", "speed"),
    [(0.7, 100.0), (0.7, 1e4), (np.pi / 2 * (1 + 1e-13), 5e-324), (5e-324, 1.7e308)],
)
@pytest.mark.filterwarnings("ignore::sampler.OutsideTableWarning")
@pytest.mark.parametrize("count", [0, 10, 3000])
def test_has_the_states_of_any_condition(table, dtype, alpha1, speed, count):
    expected = table.sample(alpha1, speed, seed=1, index=range(count))
    out = np.zeros((count, 6), dtype=dtype)
    assert table.sample(alpha1, speed, seed=1, index=range(count), out=out) is out
    np.testing.assert_array_equal(out, expected.astype(dtype))


def test_may_be_memory_that_is_read(table):
    alpha1, speed = _conditions().values()
    expected = table.sample(alpha1, speed, seed=1, index=range(N))
    room = np.zeros((N, 6))
    room.reshape(-1)[:N] = alpha1
    table.sample(room.reshape(-1)[:N], speed, seed=1, index=range(N), out=room)
    np.testing.assert_array_equal(room, expected)
    room.view(np.uint64).reshape(-1)[:N] = np.arange(N)
    table.sample(alpha1, speed, seed=1, index=room.view(np.uint64).reshape(-1)[:N], out=room)
    np.testing.assert_array_equal(room, expected)


def test_has_no_mask(table):
    out = np.ma.zeros((2, 6))
    with pytest.raises(InputError, match="out: got MaskedArray, allowed: a writable"):
        table.sample(0.7, 100.0, seed=1, index=[0, 1], out=out)
