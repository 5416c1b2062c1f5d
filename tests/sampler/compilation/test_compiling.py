"""What is logged when kernels are compiled: once for each part, and nothing for other kernels."""

import os
import subprocess
import sys

import numba
import pytest
from numba.core import event
from sampler.compilation.compiling import _PARTS, _CompilationLogger


@pytest.fixture
def told():
    """What is said from here on, by a listener that has logged nothing yet."""
    messages = []
    with event.install_listener("numba:compile", _CompilationLogger(messages.append)):
        yield messages


def compile_again(module):
    """Compile a kernel of a module."""

    def twice(x):
        return x + x

    twice.__module__ = module
    assert numba.njit(twice)(3) == 6


def test_each_part_is_named_once(told):
    compile_again("sampler.made_up")
    assert len(told) == 1
    assert "the draw" in told[0]
    assert "once" in told[0]
    compile_again("sampler.another")
    assert len(told) == 1
    compile_again("tablegen.model.made_up")
    assert len(told) == 2
    assert "the direct model" in told[1]


def test_kernels_of_others_are_not_our_concern(told):
    compile_again("flow_code.tracker")
    compile_again("samplers")
    compile_again(None)
    assert told == []


def _square(x):
    return x * x


def test_a_kernel_from_the_cache_says_nothing(told, monkeypatch):
    monkeypatch.setitem(_PARTS, __name__.partition(".")[0], ("made-up kernels", "no time"))
    numba.njit(cache=True)(_square)(2.0)
    told.clear()
    with event.install_listener("numba:compile", _CompilationLogger(told.append)):
        assert numba.njit(cache=True)(_square)(3.0) == 9.0
    assert told == []


def test_it_is_said_on_standard_error_by_default(tmp_path):
    compile_one = (
        "import numpy, sampler.compilation.jit, sampler.drawing.philox;"
        "sampler.compilation.jit.kernel(sampler.drawing.philox.uniform)(numpy.uint32(1))"
    )
    ended = subprocess.run(
        [sys.executable, "-c", compile_one],
        env=os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert ended.stdout == ""
    assert ended.stderr.startswith("compiling the draw ")
    assert ended.stderr.count("\n") == 1
