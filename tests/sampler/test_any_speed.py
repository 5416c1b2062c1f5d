"""Tables of laws without speed: no speed is outside, and draws are what they were."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from refusals import refused
from spin_tables import with_spin_law

import sampler
from sampler.formats.binary_layout import SPEED_INDEPENDENT
from sampler.formats.hdf5 import write_table
from sampler.formats.image import header_of, table_image

SPEEDS = np.array([1e-6, 0.3, 49.0, 50.0, 120.0, 300.0, 301.0, 1e5])


@pytest.fixture(scope="module")
def anywhere(contents):
    return replace(contents, speed_independent=True)


def test_every_speed_is_inside_and_has_the_draws_of_the_nearest(anywhere, table):
    free = sampler.Table(anywhere, outside="raise")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        states = free.sample(0.7, SPEEDS, seed=1, index=range(8))
    assert sum(free.counts.values()) == 0
    np.testing.assert_array_equal(states, table.sample(0.7, SPEEDS, seed=1, index=range(8)))
    assert table.counts["speed"] == 5
    velocity = [0.06, -0.08, 0.0]
    np.testing.assert_array_equal(
        *(
            np.hstack(one.rebound(velocity, [0, 1, 0], 1e-5, grain="fresh", seed=1, index=0))
            for one in (free, table)
        ),
    )


def test_what_is_any_speed(anywhere):
    free = sampler.Table(anywhere, outside="raise")
    for speed in (1e-310, 1e301):
        line = refused("speed", free.sample, 0.7, speed, seed=1, index=0)
        assert "allowed: speeds from 1e-300 to 1e+300 m/s, the range of" in line


def test_no_speed_is_outside_the_spin_law(anywhere, contents):
    free, bound = (sampler.Table(with_spin_law(one)) for one in (anywhere, contents))
    given = {"spin": [0.3, 0.0, -0.5], "seed": 1, "index": range(8), "hit": 0}
    with pytest.warns(sampler.OutsideTableWarning):
        np.testing.assert_array_equal(
            free.sample(0.7, SPEEDS, **given), bound.sample(0.7, SPEEDS, **given)
        )
    assert (free.counts["speed"], bound.counts["speed"]) == (0, 4)


def test_the_files_say_so(anywhere, contents, tmp_path):
    for stored, flags in ((anywhere, SPEED_INDEPENDENT), (contents, 0)):
        write_table(tmp_path / "t.h5", stored)
        assert sampler.load(tmp_path / "t.h5").speed_independent == bool(flags)
        assert header_of(table_image(stored))["flags"] == flags
    assert anywhere.content_sha256 != contents.content_sha256
