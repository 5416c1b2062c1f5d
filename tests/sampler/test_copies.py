"""Copies of a table, as other processes get them: the same draws, and a count of their own."""

import copy
import pickle

import numpy as np
import pytest
from refusals import refused

import sampler
from sampler import OutsideTableWarning

INDEX = np.arange(1000)


def _pickled(table):
    return pickle.loads(pickle.dumps(table))


def _out_of_band(table):
    """As Dask and joblib do it: arrays in buffers of their own, which come back read-only."""
    buffers = []
    data = pickle.dumps(table, protocol=5, buffer_callback=buffers.append)
    # bytes that begin where a cache line does not
    shifted = [memoryview(b"x" + bytes(buffer.raw()))[1:] for buffer in buffers]
    return pickle.loads(data, buffers=shifted)


def _draw(table):
    """States, and how many lay outside."""
    states = table.sample(0.7, 100.0, seed=1, index=INDEX)
    with pytest.warns(OutsideTableWarning):
        table.sample([0.7, 0.7], [100.0, 1e4], seed=1, index=[0, 1])
    return states, table.counts["speed"]


@pytest.mark.parametrize("make", [copy.copy, copy.deepcopy, _pickled, _out_of_band])
def test_copies_draw_the_same_and_count_anew(table_path, make):
    table = sampler.load(table_path)
    states, outside = _draw(table)
    other = make(table)
    assert (outside, other.counts["speed"]) == (1, 0)
    again, outside = _draw(other)
    assert (outside, table.counts["speed"]) == (1, 1)
    np.testing.assert_array_equal(again, states)
    for name in ("columns", "pair", "config", "speed_independent", "outside", "nbytes"):
        assert getattr(other, name) == getattr(table, name)
    assert other.content_sha256 == table.content_sha256
    assert other.accuracy.keys() == table.accuracy.keys()
    strict = make(sampler.load(table_path, outside="raise"))
    refused("speed", strict.sample, 0.7, 1e4, seed=1, index=0)
