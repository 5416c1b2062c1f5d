"""Mixture parameters as 16-bit integers."""

import numpy as np
import pytest
from tablegen.fitting.fixed_point import MIXTURE_SCALE, from_steps, to_steps


def test_rounding_is_to_the_nearest_step():
    values = np.random.default_rng(1).uniform(-8.0, 7.999, 1000)
    off = np.abs(from_steps(to_steps(values)) - values)
    assert off.max() <= 0.5 / MIXTURE_SCALE
    assert off.max() > 0.49 / MIXTURE_SCALE  # coarser than double precision, or nothing is tested


def test_steps_are_exact():
    steps = np.array([-32768, -1, 0, 1, 32767], dtype=np.int16)
    np.testing.assert_array_equal(to_steps(from_steps(steps)), steps)
    assert from_steps(steps)[0] == -8.0


@pytest.mark.parametrize("value", [8.0, -8.001])
def test_what_does_not_fit_is_refused(value):
    with pytest.raises(OverflowError, match=r"allowed: \[-8, 8\)"):
        to_steps([0.0, value])
