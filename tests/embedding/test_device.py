"""Draws on a GPU equal those of the table and refuse the same input; GPU compilers accept the code.

If there is no CuPy with a GPU, the stand-in `cupy_on_host` runs the same kernels on the host.
"""

import ctypes
import re
import sys
from pathlib import Path

import cupy_on_host
import numpy as np
import pytest
import toolchain
from refusals import refused

import sampler
from sampler.device.program import options, source
from sampler.errors import OutsideTableWarning

pytestmark = pytest.mark.filterwarnings("ignore::sampler.OutsideTableWarning")
HERE = Path(__file__).resolve().parent
VECTORS = HERE.parent / "vectors"
N = 300
RNG = np.random.default_rng(1)
KEYS = {
    "index": RNG.integers(0, 2**64, N, dtype=np.uint64),
    "hit": RNG.integers(0, 2**32, N, dtype=np.uint32),
    "seed": 5,
}
CONDITIONS = {"alpha1": RNG.uniform(0.4, 1.2, N), "speed": RNG.uniform(55.0, 115.0, N)} | KEYS
IMPACTS = {
    "velocity": RNG.uniform([20.0, -90.0, -9.0], [80.0, -60.0, 9.0], (N, 3)),
    "normal": np.array([0.0, 2.0, 0.1]),
    "half_size": RNG.uniform(1e-6, 1e-4, N),
} | KEYS
KERNELS = {f"rbt_{name}_kernel" for name in ("table", "sample", "spin_sample", "rebound")}


@pytest.fixture(scope="module", autouse=True)
def cupy(tmp_path_factory):
    """CuPy, or the stand-in for it."""
    try:
        import cupy

        has_gpu = cupy.cuda.runtime.getDeviceCount() > 0
    except (ImportError, RuntimeError):
        has_gpu = False
    if has_gpu:
        yield cupy
        return
    with cupy_on_host.in_place_of_cupy(tmp_path_factory.mktemp("programs")) as cupy:
        yield cupy


def load(name, **keywords):
    return sampler.load(VECTORS / f"{name}.h5", **keywords)


def there(cupy, given):
    """Copy the arrays among arguments to the device."""
    return {k: cupy.asarray(v) if isinstance(v, np.ndarray) else v for k, v in given.items()}


def same(cupy, actual, expected, error=0.0):
    """Compare an array of the device with one of the host.

    On a GPU, functions such as the sine differ in the last digits.
    """
    assert isinstance(actual, cupy.ndarray)
    assert (actual.shape, actual.dtype) == (expected.shape, expected.dtype)
    allowed = max(error, 0.0 if cupy is cupy_on_host else 1e-5) * np.abs(expected).max(initial=0.0)
    np.testing.assert_allclose(cupy.asnumpy(actual), expected, rtol=0.0, atol=allowed)


@pytest.mark.parametrize("name", ["full", "plane", "all-eight", "works", "pruned"])
def test_draws_have_the_bits_of_the_table(cupy, name):
    table = load(name)
    same(cupy, table.to_device().sample(**there(cupy, CONDITIONS)), table.sample(**CONDITIONS))


@pytest.mark.parametrize("grain", ["own", "fresh"])
def test_draws_with_spin_have_the_bits_of_the_table(cupy, grain):
    table = load("spin")
    given = CONDITIONS | {"spin": RNG.standard_normal((N, 3))}
    states = table.to_device().sample(**there(cupy, given), grain=grain)
    same(cupy, states, table.sample(**given, grain=grain))
    states = table.to_device().sample(**there(cupy, CONDITIONS), grain=grain)
    same(cupy, states, table.sample(**CONDITIONS, grain=grain))
    spheres = sampler.load("kharaz-2001")
    same(cupy, spheres.to_device().sample(**there(cupy, given)), spheres.sample(**given), 1e-5)


@pytest.mark.parametrize(
    "more",
    [
        {},
        {"wall_velocity": np.array([1.0, 5.0, 0.0]), "omega": RNG.standard_normal((N, 3)) * 1e6},
        {"roughness": RNG.uniform(0.0, 0.3, N)},
        {"roughness": 0.1, "omega": RNG.standard_normal((N, 3)) * 1e6},
        {"roughness": 0.3, "grain": "fresh"},
        {"roughness": 0.3, "isotropic": True},
    ],
)
def test_rebounds_are_those_of_the_table(cupy, more):
    table, given = load("spin-works"), IMPACTS | more
    works = np.zeros((N, 2))
    energies = cupy.asarray(works)
    after = table.to_device().rebound(**there(cupy, given), works=energies)
    expected = *table.rebound(**given, works=works), works
    for actual, values in zip((*after, energies), expected, strict=True):
        # last digits of the C library's functions reach features in single precision
        same(cupy, actual, values, 1e-5)
    assert works.any()


def test_numbers_in_single_precision_are_rounded_once(cupy):
    table = load("full")
    given = CONDITIONS | {k: CONDITIONS[k].astype(np.float32) for k in ("alpha1", "speed")}
    states = table.to_device("float32").sample(**there(cupy, given))
    same(cupy, states, table.sample(**given).astype(np.float32))


def test_shapes(cupy):
    """Arguments broadcast and may be on the host; calls may have no row, or many."""
    table = load("plane")
    device = table.to_device()
    for alpha1, index in (([[0.5], [0.9]], [[3, 4, 5]]), (0.5, np.arange(4200)), ([], 0)):
        given = {"alpha1": alpha1, "speed": 100.0, "seed": 1, "index": index}
        same(cupy, device.sample(**given), table.sample(**given))
    keys = {"grain": "fresh", "seed": 1, "index": 2}
    one = device.rebound([60.0, -60.0, 0.0], [0.0, 1.0, 0.0], 1e-5, **keys)
    assert one.velocity.shape == one.omega.shape == (3,)


def test_draws_outside_are_counted_and_told_once(cupy):
    table, given = load("full"), CONDITIONS | {"speed": CONDITIONS["speed"].copy()}
    given["speed"][[7, 30]] = 500.0
    device = table.to_device()
    with pytest.warns(OutsideTableWarning) as caught:
        [device.sample(**there(cupy, given)) for _ in range(2)]
    table.sample(**given)
    assert len(caught) == sum(number > 0 for number in table.counts.values())
    assert device.counts == {kind: 2 * number for kind, number in table.counts.items()}
    assert device.counts["speed"] == 4


SAMPLE = {"alpha1": np.full(5, 0.5), "speed": np.full(5, 99.0)}
REBOUND = {"velocity": np.tile([60.0, -60.0, 0.0], (5, 1)), "roughness": np.zeros(5)}
REBOUND |= {"normal": [0.0, 1.0, 0.0], "half_size": 1e-5, "grain": "fresh"}


@pytest.mark.parametrize(
    ("call", "arguments", "name", "value"),
    [
        *(("sample", SAMPLE, *bad) for bad in (("alpha1", np.nan), ("speed", 500.0))),
        *(("sample", SAMPLE, *bad) for bad in (("index", -1), ("hit", 2**32))),
        *(("rebound", REBOUND, *bad) for bad in (("velocity", 60.0), ("roughness", 0.6))),
    ],
)
def test_a_device_refuses_what_the_table_refuses(cupy, call, arguments, name, value):
    """The error line is the same, and names the row."""
    given = arguments | {"index": np.arange(5), "hit": np.zeros(5, np.int64), "seed": 1}
    given[name] = given[name].copy()
    given[name][3] = value
    table = load("full", outside="raise")
    line = refused(name, getattr(table, call), **given)
    device_line = refused(name, getattr(table.to_device(), call), **there(cupy, given))
    line, device_line = (x.replace("row 3 (particle 3)", "index 3") for x in (line, device_line))
    assert device_line == line
    assert "index 3" in line


def test_only_a_device_refuses(monkeypatch):
    table = load("full")
    refused("dtype", table.to_device, "float16")
    keys = {"seed": 1, "index": 0}
    refused("grain", table.to_device().sample, 0.5, 100.0, grain=np.zeros(3), **keys)
    monkeypatch.setattr(sys.modules["cupy"].cuda.runtime, "getDeviceCount", lambda: 0)
    refused("to_device", table.to_device)
    monkeypatch.setitem(sys.modules, "cupy", None)
    assert "pip" in refused("to_device", table.to_device)


def test_nvrtc_compiles_it_as_cupy_does():
    """NVIDIA's run-time compiler needs no GPU."""
    path = toolchain.wheel_file("nvidia-cuda-nvrtc", "lib/libnvrtc.so.13")
    if path is None:
        pytest.skip("no NVRTC on this machine: pip install '.[cuda-test]'")
    library, program, size = ctypes.CDLL(str(path)), ctypes.c_void_p(), ctypes.c_size_t()
    create = library.nvrtcCreateProgram
    assert create(ctypes.byref(program), source().encode(), b"program.cu", 0, None, None) == 0
    words = [word.encode() for word in (*options("float64"), "-arch=compute_75")]
    given = (ctypes.c_char_p * len(words))(*words)
    status, outputs = library.nvrtcCompileProgram(program, len(words), given), []
    for name in ("ProgramLog", "PTX"):
        getattr(library, f"nvrtcGet{name}Size")(program, ctypes.byref(size))
        buffer = ctypes.create_string_buffer(size.value + 1)
        getattr(library, f"nvrtcGet{name}")(program, buffer)
        outputs.append(buffer.value.decode())
    messages, code = outputs
    assert (status, messages.strip("\n ")) == (0, "")
    assert set(re.findall(r"\.entry (\w+)", code)) == KERNELS
    assert ".extern .func" not in code  # nothing of libc
    draw = re.search(r"\.entry rbt_sample_kernel\(.*?\n\}\n", code, re.S).group()
    # it keeps its numbers in registers, but for the arguments of the spin law, which stands for
    # first impacts of another population
    assert draw.count("st.local") <= 16


@pytest.mark.apart
def test_nvcc_compiles_the_example(tmp_path):
    example = toolchain.INCLUDE / "tracker.cu"
    flags = ["-arch=compute_75", "-ptx", "-Xcicc", "-O0"]
    toolchain.compile_with("nvcc", [*flags, example], tmp_path / "tracker.ptx")


@pytest.mark.apart
@pytest.mark.parametrize("real", ["double", pytest.param("float", marks=pytest.mark.study)])
def test_clang_compiles_it_for_amd(real, tmp_path):
    text = toolchain.IMPLEMENTATION + '#include "rebound_device.h"\n'
    (tmp_path / "kernels.cpp").write_text(text)
    flags = ["-x", "hip", "--cuda-device-only", "-nogpuinc", "-nogpulib", "--offload-arch=gfx90a"]
    flags += ["-O1", "-S", f"-DRBT_REAL={real}", "-include", HERE / "hip_declarations.h"]
    toolchain.compile_with("clang++", [*flags, tmp_path / "kernels.cpp"], tmp_path / "kernels.s")
    assembly = (tmp_path / "kernels.s").read_text()
    assert set(re.findall(r"\.amdhsa_kernel (\w+)", assembly)) == KERNELS
