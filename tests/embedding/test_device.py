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

HERE = Path(__file__).resolve().parent
VECTORS = HERE.parent / "vectors"
TABLES = sorted(path.stem for path in VECTORS.glob("*.rbt"))
SOURCE = HERE / "device_vectors.cu"
ON_HOST = ["-include", HERE / "device_on_host.h", "-DRBTI_GPU", "-ffp-contract=off"]
KERNELS = toolchain.IMPLEMENTATION + '#include "rebound_device.h"\n'

#: Lowest architecture of CUDA 13, those of the A100 and of the H100.
ARCHITECTURES = ("sm_75", "sm_80", "sm_90")


def check_vectors(program, tolerance):
    for name in TABLES:
        files = VECTORS / f"{name}.rbt", VECTORS / f"{name}.txt"
        cases = len(files[1].read_text(encoding="ascii").splitlines())
        assert toolchain.run(program, *files, tolerance) == f"{cases} cases\n"


@pytest.mark.processor
@pytest.mark.parametrize(
    ("compiler", "level"),
    [("g++", "-O1"), pytest.param("clang++", "-O1", marks=pytest.mark.study)],
)
def test_kernels_on_the_host_have_the_bits_of_the_vectors(compiler, level, tmp_path):
    check_vectors(toolchain.build(compiler, [SOURCE], tmp_path / "vectors", [*ON_HOST, level]), 0)


def test_a_wrong_kernel_is_found(tmp_path):
    """One that forgets the hit in the keys."""
    changed = tmp_path / "device_vectors.cu"
    text = (toolchain.INCLUDE / "rebound_device.h").read_text(encoding="utf-8")
    (tmp_path / "rebound_device.h").write_text(text.replace("hit[rbti_row(", "0 & hit[rbti_row("))
    shutil.copy(SOURCE, changed)
    flags = [f"-I{HERE}", *ON_HOST, "-O0"]
    program = toolchain.build("g++", [changed], tmp_path / "vectors", flags)
    files = VECTORS / "full.rbt", VECTORS / "full.txt"
    assert "case 2 fails" in toolchain.run(program, *files, 0, status=1)


def build_for_a_device(folder):
    """Program whose vectors run on a GPU; functions of libc in device code would not be found."""
    program = folder / "vectors"
    toolchain.compile_with("nvcc", ["-arch=sm_75", f"-I{HERE}", SOURCE], program)
    return program


def test_compiles_with_nvcc(tmp_path):
    build_for_a_device(tmp_path)


def test_vectors_on_a_gpu(tmp_path):
    smi = shutil.which("nvidia-smi")
    if smi is None or subprocess.run([smi, "-L"], capture_output=True, check=False).returncode:
        pytest.skip("no GPU of NVIDIA on this machine")
    # the same bits but from functions of CUDA's library, which rebounds call
    check_vectors(build_for_a_device(tmp_path), 0)


@pytest.mark.study  # half a minute, for what only a compiler or a kernel's size can change
@pytest.mark.parametrize("architecture", ARCHITECTURES)
def test_a_draw_keeps_its_numbers_in_registers(architecture, tmp_path):
    """The kernel of draws spills nothing; the others little. Prints what each takes (``-s``)."""
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
