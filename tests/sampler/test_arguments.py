"""Arguments that numpy would quietly make something else of."""

import enum
import warnings

import numpy as np
import pytest
from refusals import refused

import sampler
from sampler.arguments import as_integer

IMPACT = {"velocity": [60.0, -80.0, 0.0], "normal": [0.0, 1.0, 0.0], "half_size": 1e-5}


class Identity(enum.IntEnum):
    FIRST = 1


def _sample(table, **change):
    return table.sample(**({"alpha1": 0.7, "speed": 100.0, "seed": 1, "index": 0} | change))


MASKED = (np.ma.array([1, 1], mask=[False, True]), np.ma.array([1, 1]), np.ma.masked)


@pytest.mark.parametrize("name", ["alpha1", "speed", "index", "hit", "seed"])
def test_masked_arrays_are_refused(table, name):
    for values in MASKED:
        refused(name, _sample, table, **{name: values})


@pytest.mark.parametrize("name", [*IMPACT, "wall_velocity", "roughness"])
def test_masked_arrays_are_refused_for_impacts(table, name):
    change = {name: np.ma.array(IMPACT.get(name, [0.0, 0.0, 0.0]))}
    refused(name, table.rebound, **(IMPACT | change), grain="fresh", seed=1, index=0)


class WithUnit(np.ndarray):
    """A quantity as of astropy; pint's has ``units``. Numpy makes plain numbers of it."""

    unit = "um"


class Quantity:
    """A quantity as of pint."""

    units = "um"

    def __init__(self, number):
        self.number = number

    def __array__(self, dtype=None, copy=None):
        return np.array(self.number, dtype=dtype)


QUANTITIES = (np.array(1.0).view(WithUnit), Quantity(1.0), [Quantity(1.0)], [[1.0, Quantity(2)]])


@pytest.mark.parametrize("values", QUANTITIES, ids=("unit", "units", "list", "lists"))
def test_quantities_with_units_are_refused(table, values):
    for name in ("alpha1", "speed", "index", "hit"):
        assert "carries the unit 'um'" in refused(name, _sample, table, **{name: values})
    for name in (*IMPACT, "wall_velocity", "roughness"):
        given = IMPACT | {name: values}
        refused(name, table.rebound, **given, grain="fresh", seed=1, index=0)
    refused("alpha1", table.mean, values, 100.0)
    refused("p", table.quantile, values, "u", 0.5, 100.0)
    refused("time", sampler.spin_after, [0.0, 0.0, 1.0], values, 1e-22, 2e-5, 1.2, 1.8e-5)


def test_a_large_half_size_is_warned_of_once(contents):
    table, keys = sampler.Table(contents), {"grain": "fresh", "seed": 1, "index": [0, 1]}
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        for sizes in ([0.1, 0.05], [0.05, 20.0], [20.0, 20.0]):
            given = IMPACT | {"velocity": 2 * [IMPACT["velocity"]], "half_size": sizes}
            table.rebound(**given, **keys)
    (warning,) = (w for w in caught if "half_size" in str(w.message))
    assert str(warning.message) == (
        "half_size: 20 m is very large at row 1 (particle 1); give metres: 20 micrometres are 20e-6"
    )
    assert warning.filename == __file__


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
    for index in (7, [7]):
        refused("index", _sample, table, speed=[60.0, 70.0, 80.0], index=index)
    assert _sample(table, hit=range(3), index=7).shape == (3, 6)


#: Values that are no keys, by the name of the key and by words of their message.
NO_KEYS = {
    ("index", "at index 0"): (2**64, [-1, 2**63], 1 << 16609),
    ("index", "at index 1"): ([3, -2], [1, 2**64], [2**63, -1]),
    ("index", "at index (1, 1)"): ([[1, 2], [3, -4]],),
    ("index", "bool"): (True, [True, 2], [np.True_, 2], np.array([True])),
    ("index", "float64"): ([1, 2.0], 1.0),
    ("index", ""): ([1, None], [[1], [2, 3]]),
    ("hit", "at index 0"): (2**32, [2**64, 0]),
    ("hit", "at index 1"): ([0, -1],),
    ("seed", ""): (-1, 2**64, 1 << 16609, np.float64(1), np.True_, [1], np.zeros((2, 2))),
}


@pytest.mark.parametrize(("name", "words"), NO_KEYS)
def test_keys_are_integers(table, name, words):
    for value in NO_KEYS[name, words]:
        assert words in refused(name, _sample, table, **{name: value}).partition("allowed")[0]


@pytest.mark.parametrize("value", [7, np.uint8(7), np.array(7), Identity(1) + 6])
def test_integers_of_any_kind(value):
    number = as_integer("count", value, 1, 7, "1 to 7")
    assert (number, type(number)) == (7, int)


RAGGED = [[0.1], [0.2, 0.3]]


@pytest.mark.parametrize(
    ("argument", "call"),
    [
        ("alpha1", lambda t: t.quantile(0.5, "v", RAGGED, 100.0)),
        ("speed", lambda t: t.quantile(0.5, "v", 0.5, RAGGED)),
        ("spin", lambda t: t.quantile(0.5, "v", 0.5, 100.0, RAGGED)),
        ("p", lambda t: t.quantile(RAGGED, "v", 0.5, 100.0)),
        ("variable", lambda t: t.quantile(0.5, np.array(["u", "v"]), 0.5, 100.0)),
        ("variable", lambda t: t.quantile(0.5, "u\n" * 9000, 0.5, 100.0)),
        ("outside", lambda _: sampler.load("kharaz-2001", outside=np.array(["clamp", "raise"]))),
        ("table", lambda _: sampler.load("\n\t")),
        ("table", lambda _: sampler.load(None)),
        ("index", lambda t: t.sample(0.5, 100.0, seed=1, index=["wrong"] * 2000)),
    ],
)
def test_odd_arguments_get_one_short_line(table, argument, call):
    assert len(refused(argument, call, table)) < 500
