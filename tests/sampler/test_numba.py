"""Draws and rebounds inside users' compiled code: the states of a batch, and refused types."""

import os
import subprocess
import sys

import numba
import numpy as np
import pytest
from impacts import impacts
from numba.core.errors import TypingError

import sampler

ALLOWED = "allowed: a writable float64 array of one dimension"


def _draw(handle, seed, index, hit, out):
    return sampler.draw(handle, 0.7, 100.0, None, seed, index, hit, out)


def _rebound(handle, seed, index, hit, out):
    motion = ((60.0, -80.0, 0.0), (0.0, 1.0, 0.0), 1e-5, (0.0, 0.0, 0.0))
    return sampler.rebound(handle, *motion, None, seed, index, hit, out)


def _rough_rebound(handle, seed, index, hit, out):
    motion = ((60.0, -80.0, 0.0), (0.0, 1.0, 0.0), 1e-5, (0.0, 0.0, 0.0))
    return sampler.rough_rebound(handle, *motion, 0.1, None, seed, index, hit, out)


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
    """Every mistake with the first function, and the first with each: all have the same checks."""
    return [
        pytest.param(function, mistake, id=f"{function.__name__}-{name}")
        for function in FUNCTIONS
        for k, (name, mistake) in enumerate(mistakes.items())
        if k == 0 or function is FUNCTIONS[0]
    ]


@pytest.mark.parametrize(("function", "out"), each(OUTPUTS))
def test_outputs_of_another_type_do_not_compile(table, function, out):
    with pytest.raises(TypingError, match=ALLOWED) as refused:
        function(table.handle, 1, 2, 3, out)
    assert f": got {numba.typeof(out)}, {ALLOWED}" in str(refused.value)


@pytest.mark.parametrize(("function", "wrong"), each(KEYS))
def test_keys_that_are_no_integers_do_not_compile(table, function, wrong):
    (name,) = wrong
    keys = {"seed": 1, "index": 2, "hit": 3} | wrong
    with pytest.raises(TypingError, match=f"{name}: got .*, allowed: an integer"):
        function(table.handle, *keys.values(), np.zeros(6))


def test_compiled_callers_get_the_same_error(table):
    draw = sampler.draw

    @numba.njit
    def caller(handle, states):
        return draw(handle, 0.7, 100.0, None, 1, 2, 3, states)

    with pytest.raises(TypingError, match=ALLOWED):
        caller(table.handle, np.zeros((2, 3)))
    state = np.zeros((2, 6))
    assert numba.njit(lambda handle, row: draw(handle, 0.7, 100.0, None, 1, 2, 3, row))(
        table.handle, state[1]
    ) in (sampler.OK, sampler.CLAMPED)
    assert (state[0] == 0.0).all()
    assert state[1].all()


@pytest.mark.parametrize("function", [_rebound, _rough_rebound])
@pytest.mark.parametrize("size", [0, 2, 5])
def test_outputs_that_are_too_short_are_left_alone(table, function, size):
    room = np.full(6, 7.0)
    with pytest.raises(ValueError, match="out: got fewer than 6 numbers"):
        function(table.handle, 1, 2, 3, room[:size])
    assert (room == 7.0).all()


def test_any_stride_and_integer_will_do(table):
    expected = np.zeros(6)
    _rebound(table.handle, np.uint64(1), np.uint64(2), np.uint32(3), expected)
    assert expected.all()
    spread = np.zeros(12)
    _rebound(table.handle, np.int8(1), 2, np.int64(3), spread[::2])
    np.testing.assert_array_equal(spread[::2], expected)
    assert (spread[1::2] == 0.0).all()


@numba.njit
def _follow(handle, alpha1, speed, states):
    for k in range(states.shape[0]):
        # signed loop counters and literals as keys: what users write
        sampler.draw(handle, alpha1[k], speed[k], None, 7, k, 3, states[k])


@numba.njit(parallel=True, nogil=True)
def _bounce(handle, velocity, normal, wall, roughness, isotropic, out):
    for k in numba.prange(velocity.shape[0]):
        v = (velocity[k, 0], velocity[k, 1], velocity[k, 2])
        n = (normal[k, 0], normal[k, 1], normal[k, 2])
        if roughness > 0.0:
            how = wall, roughness, None, 7, k, 0
            sampler.rough_rebound(handle, v, n, 1e-5, *how, out[k], None, isotropic)
        else:
            sampler.rebound(handle, v, n, 1e-5, wall, None, 7, k, 0, out[k])


def test_draws_are_those_of_a_batch(table):
    rng = np.random.default_rng(2)
    alpha1, speed = rng.uniform(0.4, 1.5, 500), rng.uniform(60.0, 290.0, 500)
    states, every = np.empty((500, 6)), np.empty((500, 10))
    expected = table.sample(alpha1, speed, seed=7, index=range(500), hit=3)
    for room in (states, every):
        _follow(table.handle, alpha1, speed, room)
        np.testing.assert_array_equal(room[:, :6], expected)
    np.testing.assert_array_equal(every[:, 6:8], 0.0)


@pytest.mark.parametrize(("roughness", "isotropic"), [(0.0, False), (0.2, False), (0.2, True)])
def test_rebounds_are_those_of_a_batch(table, roughness, isotropic):
    velocity, normal = impacts(300)
    keep = np.einsum("nk,nk->n", velocity - [1.0, 2.0, 3.0], normal) < 0.0
    velocity, normal = velocity[keep], normal[keep]
    out = np.empty((len(velocity), 6))
    _bounce(table.handle, velocity, normal, (1.0, 2.0, 3.0), roughness, isotropic, out)
    keys = {"seed": 7, "index": range(len(out)), "wall_velocity": [1, 2, 3]}
    keys |= {"roughness": roughness, "isotropic": isotropic}
    expected = table.rebound(velocity, normal, 1e-5, **keys)
    np.testing.assert_array_equal(out, np.hstack(expected))


CACHED = """
import sys, time, numba, numpy as np, sampler
@numba.njit(cache=True)
def run(handle, out):
    v, n = (9.0, -90.0, 0.0), (0.0, 1.0, 0.0)
    return sampler.rebound(handle, v, n, 1e-5, None, None, 7, 1, 0, out)
table = sampler.load(sys.argv[1])
out = np.empty(6)
assert run(table.handle, out) >= 0
print(out.tolist(), sum(run.stats.cache_hits.values()))
"""


def test_callers_may_be_cached(table_path, tmp_path):
    """Another process takes the machine code of the caller from disk, and draws the same."""
    (tmp_path / "tracker.py").write_text(CACHED)
    words = [sys.executable, str(tmp_path / "tracker.py"), str(table_path)]
    paths = os.pathsep.join(sys.path)
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path), "PYTHONPATH": paths}
    runs = [
        subprocess.run(words, capture_output=True, text=True, check=True, env=environment).stdout
        for _ in range(2)
    ]
    assert [run.split()[-1] for run in runs] == ["0", "1"]
    assert runs[0].split()[:-1] == runs[1].split()[:-1]
