"""A table's arrays in users' compiled code: argument, parallel loop, global, result."""

import numba
import numpy as np
import pytest
from sampler.formats.bounds import TableArrays, same

import sampler


@pytest.fixture(scope="module")
def arrays():
    return sampler.load("corundum-steel").arrays


@numba.njit(parallel=True)
def _gathered(arrays, places, found):
    for k in numba.prange(len(places)):
        found[k] = arrays.quantiles[places[k]] + arrays.alpha.last * len(arrays.channels)


def test_threads_of_a_parallel_loop_get_all_of_it(arrays):
    places = np.random.default_rng(1).integers(0, arrays.quantiles.size, 1000)
    found = np.zeros(1000)
    _gathered(arrays, places, found)
    expected = arrays.quantiles[places] + arrays.alpha.last * len(arrays.channels)
    np.testing.assert_array_equal(found, expected)


def test_it_comes_back_as_it_was(arrays):
    @numba.njit
    def unchanged(arrays):
        return arrays

    found = unchanged(arrays)
    assert type(found) is TableArrays
    assert same(found, arrays)
    assert found.quantiles.ctypes.data == arrays.quantiles.ctypes.data


def test_it_may_be_a_global(arrays):
    @numba.njit
    def of_global():
        return arrays.spans[3], arrays.speed.last, arrays.columns[2], arrays.valid_speed[1]

    expected = arrays.spans[3], arrays.speed.last, arrays.columns[2], arrays.valid_speed[1]
    assert of_global() == expected


def test_tables_of_one_kind_have_one_type_and_others_another(arrays):
    other = arrays._replace(columns=(0, 1))
    assert numba.typeof(arrays) == numba.typeof(arrays._replace(n_knots=3))
    assert numba.typeof(arrays) != numba.typeof(other)
