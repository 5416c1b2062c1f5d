"""Wrong types in users' compiled code: an error while it compiles, and no memory overwritten."""

import numba
import numpy as np
import pytest
from numba.core.errors import TypingError

import sampler

ALLOWED = "allowed: a writable float64 array of one dimension"


def _draw(arrays, seed, index, hit, out):
    return sampler.draw(arrays, 0.7, 100.0, seed, index, hit, out)


def _rebound(arrays, seed, index, hit, out):
    motion = ((60.0, -80.0, 0.0), (0.0, 1.0, 0.0), 1e-5, (0.0, 0.0, 0.0))
    return sampler.rebound(arrays, *motion, seed, index, hit, out)


def _rough_rebound(arrays, seed, index, hit, out):
    motion = ((60.0, -80.0, 0.0), (0.0, 1.0, 0.0), 1e-5, (0.0, 0.0, 0.0))
    return sampler.rough_rebound(arrays, *motion, 0.1, seed, index, hit, out)


FUNCTIONS = (_draw, _rebound, _rough_rebound)


def _frozen():
    array = np.zeros(6)
    array.flags.writeable = False
    return array


#: What stands where an array for the result should.
OUTPUTS = {
    "2d": np.zeros((2, 3)),
    "column": np.zeros((6, 1)),
    "0d": np.zeros(()),
    "float32": np.zeros(6, dtype=np.float32),
    "int64": np.zeros(6, dtype=np.int64),
    "complex": np.zeros(6, dtype=complex),
    "read-only": _frozen(),
    "tuple": (0.0,) * 6,
}
KEYS = {
    f"{name}={value}": {name: value}
    for name in ("seed", "index", "hit")
    for value in (1.0, float("nan"), True, None)
}


def each(mistakes):
    """Every mistake with the first function, and the first with each; the others are a study.

    All functions have the same checks, and each call is compiled for half a second.
    """
    return [
        pytest.param(
            function,
            mistake,
            id=f"{function.__name__}-{name}",
            marks=() if k == 0 or function is FUNCTIONS[0] else pytest.mark.study,
        )
        for function in FUNCTIONS
        for k, (name, mistake) in enumerate(mistakes.items())
    ]


@pytest.mark.parametrize(("function", "out"), each(OUTPUTS))
def test_outputs_of_another_type_do_not_compile(table, function, out):
    with pytest.raises(TypingError, match=ALLOWED) as refused:
        function(table.arrays, 1, 2, 3, out)
    assert f": got {numba.typeof(out)}, {ALLOWED}" in str(refused.value)


@pytest.mark.parametrize(("function", "wrong"), each(KEYS))
def test_keys_that_are_no_integers_do_not_compile(table, function, wrong):
    (name,) = wrong
    keys = {"seed": 1, "index": 2, "hit": 3} | wrong
    with pytest.raises(TypingError, match=f"{name}: got .*, allowed: an integer"):
        function(table.arrays, *keys.values(), np.zeros(6))


def test_compiled_callers_get_the_same_error(table):
    draw = sampler.draw

    @numba.njit
    def caller(arrays, states):
        return draw(arrays, 0.7, 100.0, 1, 2, 3, states)

    with pytest.raises(TypingError, match=ALLOWED):
        caller(table.arrays, np.zeros((2, 3)))
    state = np.zeros((2, 6))
    assert numba.njit(lambda arrays, row: draw(arrays, 0.7, 100.0, 1, 2, 3, row))(
        table.arrays, state[1]
    ) in (sampler.OK, sampler.CLAMPED)
    assert (state[0] == 0.0).all()
    assert state[1].all()


@pytest.mark.parametrize("function", [_rebound, _rough_rebound])
@pytest.mark.parametrize("size", [0, 2, 5])
def test_outputs_that_are_too_short_are_left_alone(table, function, size):
    room = np.full(6, 7.0)
    with pytest.raises(ValueError, match="out: got fewer than 6 numbers"):
        function(table.arrays, 1, 2, 3, room[:size])
    assert (room == 7.0).all()


def test_any_stride_and_integer_will_do(table):
    expected = np.zeros(6)
    _rebound(table.arrays, np.uint64(1), np.uint64(2), np.uint32(3), expected)
    assert expected.all()
    spread = np.zeros(12)
    _rebound(table.arrays, np.int8(1), 2, np.int64(3), spread[::2])
    np.testing.assert_array_equal(spread[::2], expected)
    assert (spread[1::2] == 0.0).all()
