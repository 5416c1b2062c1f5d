"""Arguments that numpy would quietly make something else of."""

import enum
import re

import numpy as np
import pytest

import sampler
from sampler import InputError
from sampler.arguments import as_integer

IMPACT = {"velocity": [60.0, -80.0, 0.0], "normal": [0.0, 1.0, 0.0], "half_size": 1e-5}


class Identity(enum.IntEnum):
    FIRST = 1


def _sample(table, **change):
    return table.sample(**({"alpha1": 0.7, "speed": 100.0, "seed": 1, "index": 0} | change))


@pytest.mark.parametrize("name", ["alpha1", "speed", "index", "hit", "seed"])
@pytest.mark.parametrize(
    "values", [np.ma.array([1, 1], mask=[False, True]), np.ma.array([1, 1]), np.ma.masked]
)
def test_masked_arrays_are_refused(table, name, values):
    with pytest.raises(InputError) as refused:
        _sample(table, **{name: values})
    assert str(refused.value).startswith(f"{name}: got ")
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("name", [*IMPACT, "wall_velocity", "roughness"])
def test_masked_arrays_are_refused_for_impacts(table, name):
    change = {name: np.ma.array(IMPACT.get(name, [0.0, 0.0, 0.0]))}
    with pytest.raises(InputError, match=f"{name}: got a masked array, allowed: real numbers"):
        table.rebound(**(IMPACT | change), grain="fresh", seed=1, index=0)


@pytest.mark.parametrize(
    "index",
    [
        2**64 - 1,
        [0, 2**63],  # of which numpy makes floats
        (0, 2**64 - 1),
        [np.uint64(2**64 - 1), 5],
        [[np.int8(1), 2**63 + 1]],
        Identity.FIRST,
    ],
)
def test_keys_are_exact_up_to_the_largest(table, index):
    whole = np.array([int(k) for k in np.array(index, dtype=object).flat], dtype=np.uint64)
    expected = _sample(table, index=whole.reshape(np.shape(index)))
    np.testing.assert_array_equal(_sample(table, index=index), expected)


def test_one_index_for_many_rows_is_refused(table):
    message = "index: got one number, 7, for 3 rows, allowed: one for each row, such as numpy.ara"
    for index in (7, [7]):
        with pytest.raises(InputError, match=re.escape(message)):
            _sample(table, speed=[60.0, 70.0, 80.0], index=index)
    assert _sample(table, hit=range(3), index=7).shape == (3, 6)


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("index", 2**64, "got 18446744073709551616 at index 0, allowed: integers from 0 to 2**64"),
        ("index", [1, 2**64], "got 18446744073709551616 at index 1, allowed"),
        ("index", [2**63, -1], "got -1 at index 1, allowed"),
        ("index", 1 << 16609, "got an integer of 16610 bits at index 0, allowed"),
        ("index", True, "got bool values, allowed"),
        ("index", [True, 2], "got bool values, allowed"),
        ("index", [np.True_, 2], "got bool values, allowed"),
        ("index", np.array([True]), "got bool values, allowed"),
        ("index", [1, 2.0], "got float64 values, allowed"),
        ("index", 1.0, "got float64 values, allowed"),
        ("index", [1, None], "got object values, allowed"),
        ("index", [[1], [2, 3]], "got rows of unequal length, allowed"),
        ("hit", 2**32, "got 4294967296 at index 0, allowed: integers from 0 to 2**32 - 1"),
        ("hit", [2**64, 0], "got 18446744073709551616 at index 0, allowed"),
        ("seed", 1 << 16609, "got an integer of 16610 bits, allowed"),
        ("seed", np.float64(1), f"got {np.float64(1)!r}, allowed"),
        ("seed", np.True_, f"got {np.True_!r}, allowed"),
        ("seed", [1], "got [1], allowed"),
        ("seed", np.zeros((2, 2)), "got array([[0., 0.], [0., 0.]]), allowed"),
    ],
    ids=range(19),  # pytest would write out the largest
)
def test_keys_are_integers(table, name, value, message):
    with pytest.raises(InputError) as refused:
        _sample(table, **{name: value})
    assert str(refused.value).startswith(f"{name}: {message}")
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("value", [7, np.uint8(7), np.array(7), Identity(1) + 6])
def test_integers_of_any_kind(value):
    number = as_integer("count", value, 1, 7, "1 to 7")
    assert (number, type(number)) == (7, int)


@pytest.mark.parametrize(
    ("name", "value", "got", "allowed"),
    [
        ("alpha1", 1.57079633, "1.57079633 ", "at most pi/2 rad"),
        ("alpha1", np.pi / 2 + 2e-12, "1.5707963268 ", "at most pi/2 rad"),
        ("speed", 300.0000001, "an impact at 40.107 deg, 300.0000001 m/s", "50 to 300 m/s"),
        (
            "speed",
            np.nextafter(50.0 - 1e-10, 0.0),
            "an impact at 40.107 deg, 49.9999999999 ",
            "50 to",
        ),
        ("speed", 301.0, "an impact at 40.107 deg, 301 m/s", "50 to 300 m/s"),
    ],
)
def test_what_is_refused_looks_refused(table_path, name, value, got, allowed):
    with pytest.raises(InputError) as refused:
        _sample(sampler.load(table_path, outside="raise"), **{name: value})
    assert str(refused.value).startswith(f"{name}: got {got}")
    assert allowed in str(refused.value)


def _read_only(values):
    array = np.array(values)
    array.flags.writeable = False
    return array


def test_arrays_that_cannot_be_written_are_taken(table):
    """As pandas and memory maps give them."""
    conditions = {"alpha1": np.full(3, 0.7), "speed": np.full(3, 100.0)}
    keys = {"index": np.arange(3, dtype=np.uint64), "hit": np.zeros(3, dtype=np.uint32)}
    drawn = table.sample(**conditions, **keys, seed=1)
    frozen = {name: _read_only(values) for name, values in (conditions | keys).items()}
    np.testing.assert_array_equal(table.sample(**frozen, seed=1), drawn)
