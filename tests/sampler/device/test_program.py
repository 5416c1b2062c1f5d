"""The program that CuPy gets: NVIDIA's run-time compiler, which needs no GPU, takes it."""

import ctypes
import re
import sys
from pathlib import Path

import pytest

from sampler.device.program import bits, options, source

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "embedding"))
import toolchain

KERNELS = {
    *("rbt_table_kernel", "rbt_draw_kernel", "rbt_spin_draw_kernel", "rbt_rebound_kernel"),
    *("rbt_spin_rebound_kernel", "rbt_rough_rebound_kernel"),
}


def compiled(text, flags):
    """Status and messages of NVRTC, and what it made: code for the lowest architecture."""
    path = toolchain.wheel_file("nvidia-cuda-nvrtc", "lib/libnvrtc.so.13")
    if path is None:
        pytest.skip("no NVRTC on this machine: pip install '.[cuda-test]'")
    library = ctypes.CDLL(str(path))
    program, size = ctypes.c_void_p(), ctypes.c_size_t()
    assert library.nvrtcCreateProgram(
        ctypes.byref(program), text.encode(), b"program.cu", 0, None, None
    ) == 0  # fmt: skip
    words = [word.encode() for word in (*flags, "-arch=compute_75")]
    status = library.nvrtcCompileProgram(
        program, len(words), (ctypes.c_char_p * len(words))(*words)
    )
    found = []
    for name in ("ProgramLog", "PTX"):
        getattr(library, f"nvrtcGet{name}Size")(program, ctypes.byref(size))
        buffer = ctypes.create_string_buffer(size.value + 1)
        getattr(library, f"nvrtcGet{name}")(program, buffer)
        found.append(buffer.value.decode())
    library.nvrtcDestroyProgram(ctypes.byref(program))
    return status, *found


@pytest.mark.parametrize("dtype", ["float64", pytest.param("float32", marks=pytest.mark.study)])
def test_compiles_as_cupy_compiles_it(dtype):
    status, messages, code = compiled(source(), options(dtype))
    assert (status, messages.strip("\n ")) == (0, "")
    assert set(re.findall(r"\.entry (\w+)", code)) == KERNELS
    assert ".extern .func" not in code  # nothing of libc
    draw = re.search(r"\.entry rbt_draw_kernel\(.*?\n\}\n", code, re.S).group()
    assert "st.local" not in draw  # it keeps its numbers in registers


def test_a_mistake_is_found():
    status, messages, _ = compiled(
        source().replace("RBT_TABLE_ARGUMENT table", "int table", 1), options("float64")
    )
    assert status != 0
    assert "error" in messages


def test_bits_differ_and_are_those_of_the_program():
    assert len(bits()) == 11
    assert bits()["velocity"] == bits()["alpha1"] == 1
    assert all(bit.bit_count() == 1 for bit in bits().values())
