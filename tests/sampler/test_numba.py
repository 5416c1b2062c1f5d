"""Draws and rebounds inside users' compiled code: the states of a batch, and refused types."""

import os
import subprocess
import sys
from pathlib import Path

import numba
import numpy as np
import pytest
from impacts import impacts
from numba.core.errors import TypingError

import sampler.numba
from sampler import errors

SPINNING = Path(__file__).resolve().parents[1] / "vectors" / "spin-works.h5"


def _sample(handle, **given):
    return sampler.numba.sample(handle, 0.7, 100.0, **given)


def _rebound(handle, **given):
    return sampler.numba.rebound(handle, (60.0, -80.0, 0.0), (0.0, 1.0, 0.0), 1e-5, **given)


def _given(out, **others):
    return {"index": 2, "hit": 3, "seed": 1, "out": out} | others


FROZEN = np.zeros(6)
NUMBERS = {_sample: 6, _rebound: 7}
FROZEN.flags.writeable = False

#: What does not compile, by its name.
WRONG = {
    "out": (
        *(np.zeros((2, 3)), np.zeros(()), np.zeros(6, np.float32), np.zeros(6, complex)),
        *(FROZEN, (0.0,) * 6, None),
    ),
    **dict.fromkeys(("seed", "index", "hit"), (1.0, True, None)),
    "grain": (4.0,),
    "fresh": (1,),
    "inertia": ((0.3,), None),
}


@pytest.mark.parametrize("function", [_sample, _rebound])
@pytest.mark.parametrize(("name", "value"), [(name, x) for name in WRONG for x in WRONG[name]])
def test_other_types_do_not_compile(table, function, name, value):
    """None stands for what is left out, but of the inertia, which is 0 then."""
    given = _given(np.zeros(6)) | {name: value}
    left = {k: v for k, v in given.items() if v is not None or k == "inertia"}
    with pytest.raises(TypingError, match=f"{name}: got .*, allowed: "):
        function(table.handle, **left)


@pytest.mark.parametrize(("function", "sizes"), [(_sample, (0, 5, 10)), (_rebound, (0, 6, 8, 10))])
def test_outputs_of_another_size_are_left_alone(table, function, sizes):
    room = np.full(10, 7.0)
    for size in sizes:
        with pytest.raises(ValueError, match="out: has a wrong length; give "):
            function(table.handle, **_given(room[:size]))
    assert (room == 7.0).all()


@pytest.mark.parametrize("function", [_sample, _rebound])
def test_an_error_is_a_code_and_nan(table, function):
    out = np.zeros(NUMBERS[function])
    assert function(0, **_given(out)) == errors.MISSING
    assert np.isnan(out).all()
    out[:] = 0.0
    assert function(table.handle, **_given(out, grain=(9, 1, 1))) == errors.NO_SPIN_LAW
    assert np.isnan(out).all()


def test_works_of_a_table_without_are_an_error(table):
    out = np.zeros(9)
    assert _rebound(table.handle, **_given(out, fresh=True)) == errors.NO_WORKS
    assert np.isnan(out).all()


def test_a_particle_that_recedes_is_kept(table):
    out, v, omega = np.zeros(7), (60.0, 80.0, 0.0), (1.0, 2.0, 3.0)
    given = {"omega": omega, "inertia": 0.3, **_given(out)}
    code = sampler.numba.rebound(table.handle, v, (0.0, 1.0, 0.0), 1e-5, **given)
    assert code == errors.NOT_APPROACHING
    assert out.tolist() == [*v, *omega, 0.3]


def test_any_stride_and_integer_will_do(table):
    expected, spread = np.zeros(6), np.zeros(12)
    _sample(table.handle, index=np.uint64(2), hit=np.uint32(3), seed=np.uint64(1), out=expected)
    assert expected.all()
    _sample(table.handle, index=2, hit=np.int64(3), seed=np.int8(1), out=spread[::2])
    np.testing.assert_array_equal(spread[::2], expected)
    assert (spread[1::2] == 0.0).all()


@pytest.mark.parametrize("function", [_sample, _rebound])
@pytest.mark.parametrize(
    ("name", "value"), [("seed", -1), ("index", -1), ("hit", -1), ("hit", 2**32)]
)
def test_keys_that_would_wrap_are_refused(table, function, name, value):
    """They would be the keys of another particle or hit. Results are left alone."""
    room = np.full(NUMBERS[function], 7.0)
    with pytest.raises(ValueError, match=f"{name}.*: got .*, allowed: 0 to 2"):
        function(table.handle, **_given(room, fresh=True) | {name: value})
    assert (room == 7.0).all()
    with pytest.raises(ValueError, match=r"hit: got .*, allowed: 0 to"):
        sampler.numba.grain(table.handle, 1, 2, 2**32)
    most = {"seed": np.uint64(2**64 - 1), "index": np.uint64(2**64 - 1), "hit": 2**32 - 1}
    assert function(table.handle, **_given(room, fresh=True) | most) >= 0


@numba.njit(parallel=True, nogil=True)
def _bounce(handle, velocity, normal, omega, inertia, roughness, fresh, isotropic, out):
    wall = (1.0, 2.0, 3.0)
    for k in numba.prange(velocity.shape[0]):
        v = (velocity[k, 0], velocity[k, 1], velocity[k, 2])
        n = (normal[k, 0], normal[k, 1], normal[k, 2])
        others = wall, omega, inertia, roughness, None, k, 2, fresh, isotropic, 7
        sampler.numba.rebound(handle, v, n, 1e-5, *others, out[k])


@pytest.mark.filterwarnings("ignore::sampler.OutsideTableWarning")
@pytest.mark.parametrize(
    ("omega", "inertia", "roughness", "fresh", "isotropic"),
    [
        (None, 0.0, 0.0, False, False), (None, 0.0, 0.0, True, False),
        ((1e6, 0.0, -2e6), 0.25, 0.2, True, False), ((1e6, 0.0, -2e6), 0.0, 0.2, False, True),
    ],
)  # fmt: skip
def test_rebounds_are_those_of_a_batch(omega, inertia, roughness, fresh, isotropic):
    table = sampler.load(SPINNING)
    velocity, normal = impacts(300)
    keep = np.einsum("nk,nk->n", velocity - [1.0, 2.0, 3.0], normal) < 0.0
    velocity, normal = velocity[keep], normal[keep]
    out, works = np.empty((len(velocity), 9)), np.empty((len(velocity), 2))
    _bounce(table.handle, velocity, normal, omega, inertia, roughness, fresh, isotropic, out)
    keys = {"seed": 7, "index": range(len(out)), "hit": 2, "wall_velocity": [1, 2, 3]}
    arguments = keys | {
        "roughness": roughness,
        "isotropic": isotropic,
        "omega": omega,
        "works": works,
    }
    arguments |= {"inertia": inertia}
    expected = table.rebound(velocity, normal, 1e-5, grain="fresh" if fresh else "own", **arguments)
    np.testing.assert_array_equal(out, np.column_stack([*expected, works]))
    assert works.any()


def test_grains_and_their_sizes():
    table = sampler.load(SPINNING)
    grain = sampler.numba.grain(table.handle, 5, 8)
    np.testing.assert_array_equal(grain, table.grains(5, 8))
    assert sampler.numba.grain(table.handle, 5, 8, 0) == grain
    assert sampler.numba.grain(table.handle, 5, 8, 1) != grain
    for name in ("mean_inertia", "sphericity"):
        size = getattr(sampler.numba, name)
        assert size(table.handle, grain) == getattr(sampler, name)(table, grain)
        assert size(table.handle, (9, 1, 1)) == 0.0
    assert sampler.numba.half_size(table.handle, 6e-5, grain) == sampler.half_size(
        table, 6e-5, grain
    )
    assert np.isnan(sampler.numba.grain(0, 5, 8)).all()
    mean = sampler.mean_inertia(table, grain)
    for handle, k, moment in ((table.handle, 0.3, 0.3), (table.handle, 0.0, mean), (0, 0.0, 0.9)):
        given = sampler.numba.moment_of_inertia(handle, 5, 8, k, 2e-12, 1e-5, 3e-5)
        assert given == pytest.approx(moment * 2e-22, rel=1e-14)


CACHED = """
import sys, time, numba, numpy as np, sampler.numba
@numba.njit(cache=True)
def run(handle, out):
    v, n = (9.0, -90.0, 0.0), (0.0, 1.0, 0.0)
    return sampler.numba.rebound(handle, v, n, 1e-5, index=1, hit=0, fresh=True, seed=7, out=out)
table = sampler.load(sys.argv[1])
out = np.empty(7)
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


def test_a_daemon_thread_may_draw_until_the_process_ends(tmp_path):
    script = f"""
import threading, time, numba, numpy as np, sampler, sampler.numba
table = sampler.load({str(SPINNING)!r})
@numba.njit(nogil=True)
def draw(handle, last):
    state = np.zeros(8)
    for index in range(last):
        sampler.numba.sample(handle, 0.7, 100.0, seed=1, index=index, hit=0, out=state)
draw(table.handle, 1)
threading.Thread(target=draw, args=(table.handle, 10**10), daemon=True).start()
time.sleep(0.1)
"""
    assert subprocess.run([sys.executable, "-c", script], check=False).returncode == 0
