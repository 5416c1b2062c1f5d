"""A refused number never looks like the limit that it lies beyond."""

import math

import pytest
from sampler.arguments import as_reals_up_to, told_apart


@pytest.mark.parametrize(
    ("value", "limits", "digits", "text"),
    [
        (91.0, (90.0,), 6, "91"),
        (90.0000001, (90.0,), 6, "90.0000001"),
        (math.nextafter(90.0, 91.0), (0.5, 90.0), 6, "90.00000000000001"),
        (1.0 / 3.0, (1.0,), 9, "0.333333333"),
        (1.0 / 3.0, (1.0 / 3.0, 1.0), 6, "0.333333"),
        (math.nan, (90.0,), 6, "nan"),
    ],
)
def test_digits(value, limits, digits, text):
    assert told_apart(value, *limits, digits=digits) == text


def test_numbers_of_arrays():
    with pytest.raises(ValueError, match=r"roughness: got 0\.5000000001 .*, allowed: 0 to 0\.5$"):
        as_reals_up_to("roughness", 0.5 + 1e-10, 0.5)
