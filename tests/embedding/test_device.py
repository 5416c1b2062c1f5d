"""Device code: CUDA and HIP compile it without a warning, its kernels give the vectors' states.

There need be no GPU: the kernels run in loops of the host, from the same source. Where there is
one, the same vectors run on it.
"""

import re
import shutil
import subprocess
from pathlib import Path

import pytest
import toolchain
from known_vectors import VECTORS, check_vectors

HERE = Path(__file__).resolve().parent
SOURCE = HERE / "device_vectors.cu"
KERNELS = toolchain.IMPLEMENTATION + '#include "rebound_device.h"\n'

#: Lowest architecture of CUDA 13, those of the A100 and of the H100.
ARCHITECTURES = ("sm_75", "sm_80", "sm_90")


@pytest.mark.processor
@pytest.mark.parametrize(
    ("compiler", "level"),
    [("g++", "-O1"), pytest.param("clang++", "-O1", marks=pytest.mark.study)],
)
def test_kernels_on_the_host_have_the_bits_of_the_vectors(compiler, level, tmp_path):
    check_vectors(toolchain.build_on_host(SOURCE, tmp_path / "vectors", [level], compiler), 0)


def test_a_wrong_kernel_is_found(tmp_path):
    """One that forgets the hit in the keys."""
    changed = tmp_path / "device_vectors.cu"
    text = (toolchain.INCLUDE / "rebound_device.h").read_text(encoding="utf-8")
    (tmp_path / "rebound_device.h").write_text(text.replace("hit[rbti_row(", "0 & hit[rbti_row("))
    shutil.copy(SOURCE, changed)
    program = toolchain.build_on_host(changed, tmp_path / "vectors", [f"-I{HERE}", "-O0"])
    files = VECTORS / "full.rbt", VECTORS / "full.txt"
    assert "case 2 fails" in toolchain.run(program, *files, 0, status=1)


def build_for_a_device(folder, architecture):
    """Program whose vectors run on a GPU; functions of libc in device code would not be found."""
    program = folder / "vectors"
    toolchain.compile_with("nvcc", [f"-arch={architecture}", f"-I{HERE}", SOURCE], program)
    return program


def test_compiles_with_nvcc(tmp_path):
    # as far as PTX, which is a half of the time; test_registers does the rest
    build_for_a_device(tmp_path, "compute_75")


@pytest.mark.study  # ten seconds of nvcc; test_examples.py runs the example's kernels
def test_without_a_gpu_the_example_says_so(tmp_path, shipped_file):
    """It compiles with nvcc, and ends with one line where there is no device."""
    source, program = toolchain.INCLUDE / "particles.cu", tmp_path / "particles"
    toolchain.compile_with("nvcc", ["-arch=sm_75", source], program)
    if has_gpu():
        pytest.skip("there is a GPU")
    command = [program, shipped_file, "10", "2"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    line = "device: there is none, or it has no room for the table\n"
    assert (done.returncode, done.stdout, done.stderr) == (2, "", line)


def has_gpu():
    """Whether the driver of NVIDIA knows a device."""
    smi = shutil.which("nvidia-smi")
    return bool(smi) and subprocess.run([smi, "-L"], capture_output=True).returncode == 0


def test_vectors_on_a_gpu(tmp_path):
    if not has_gpu():
        pytest.skip("no GPU of NVIDIA on this machine")
    # CUDA's library has a logarithm, sine and cosine of its own, whose last digit may turn that of
    # a number in single precision
    check_vectors(build_for_a_device(tmp_path, "sm_75"), 1e-6)


@pytest.mark.study  # half a minute, for what only a compiler or a kernel's size can change
@pytest.mark.parametrize("architecture", ARCHITECTURES)
def test_registers(architecture, tmp_path):
    """Kernels spill no registers, but for that of rough walls. Prints what each takes (``-s``)."""
    source = tmp_path / "kernels.cu"
    source.write_text(KERNELS)
    command = [toolchain.require("nvcc"), "-std=c++17", "-fmad=false", f"-arch={architecture}"]
    command += [f"-I{toolchain.INCLUDE}", "-Xptxas", "-v", "-cubin", "-o", tmp_path / "cubin"]
    done = subprocess.run([*command, source], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    found = re.findall(
        r"entry function '(\w+)'.*?(\d+) bytes stack frame, (\d+) bytes spill stores.*?"
        r"Used (\d+) registers",
        done.stdout + done.stderr,
        re.S,
    )
    assert len(found) == 6
    for name, stack, spilled, registers in found:
        print(f"{architecture} {name}: {registers} registers, {stack} B stack, {spilled} B spilled")
        assert int(spilled) <= (64 if "rough" in name else 0), name


@pytest.mark.parametrize("real", ["double", pytest.param("float", marks=pytest.mark.study)])
def test_compiles_for_amd_with_clang(real, tmp_path):
    source = tmp_path / "kernels.cpp"
    source.write_text(KERNELS)
    flags = ["-x", "hip", "--cuda-device-only", "-nogpuinc", "-nogpulib", "--offload-arch=gfx90a"]
    flags += ["-O1", "-S", f"-DRBT_REAL={real}", "-include", HERE / "hip_declarations.h"]
    toolchain.compile_with("clang++", [*flags, source], tmp_path / "kernels.s")
    text = (tmp_path / "kernels.s").read_text()
    assert len(re.findall(r"\.amdhsa_kernel rbt_\w+_kernel", text)) == 6
