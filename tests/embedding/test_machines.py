"""Other machines: the known answers under emulators, and compilation for other systems.

What is not installed is skipped: cross compilers and emulators (Debian: gcc-aarch64-linux-gnu,
gcc-arm-linux-gnueabihf, gcc-i686-linux-gnu, qemu-user-static), and the ``ziglang`` wheel.
"""

import platform
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest
import toolchain
from known_vectors import check_vectors

SOURCE = Path(__file__).resolve().with_name("vectors.c")

#: Cross compilers, their flags, and the emulators of their machines.
MACHINES = {
    "aarch64-linux-gnu-gcc": ((), "qemu-aarch64"),
    "arm-linux-gnueabihf-gcc": ((), "qemu-arm"),  # 32 bits
    "i686-linux-gnu-gcc": (("-msse2", "-mfpmath=sse"), "qemu-i386"),  # 32 bits
}

#: Systems for which the wheel compiles.
SYSTEMS = ("x86_64-windows-gnu", "aarch64-macos")


def emulator(name):
    """Path of an emulator of another machine's programs, or skip the test."""
    path = shutil.which(f"{name}-static") or shutil.which(name)
    if path is None:
        pytest.skip(f"no {name} on this machine")
    return path


@pytest.mark.parametrize("compiler", MACHINES)
@pytest.mark.parametrize("reading", [(), ("-DRBT_NO_MMAP",)], ids=["mapped", "read"])
def test_known_answers_under_an_emulator(compiler, reading, tmp_path):
    """Draws have the same bits, and tables open, on machines of 32 bits as well."""
    flags, machine = MACHINES[compiler]
    words = toolchain.require(compiler), emulator(machine)
    program = tmp_path / "vectors"
    command = [words[0], "-std=c99", "-O2", "-static", *flags, *reading, f"-I{toolchain.INCLUDE}"]
    command += [str(SOURCE), "-o", str(program), "-lm"]
    subprocess.run(command, check=True, timeout=300)
    emulated = tmp_path / "emulated"
    emulated.write_text(f'#!/bin/sh\nexec "{words[1]}" "{program}" "$@"\n')
    emulated.chmod(0o755)
    check_vectors(emulated, tmp_path, 0)


@pytest.mark.parametrize("system", SYSTEMS)
def test_other_systems_compile(system, tmp_path):
    if find_spec("ziglang") is None:
        pytest.skip("no ziglang: pip install ziglang")
    command = [sys.executable, "-m", "ziglang", "cc", "-target", system, "-std=c99", "-Wall"]
    command += ["-Werror", f"-I{toolchain.INCLUDE}", str(SOURCE), "-o", str(tmp_path / "vectors")]
    # the first run of the wheel also compiles the system's C library, for minutes
    done = subprocess.run(command, capture_output=True, text=True, timeout=900, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    ("flags", "advice"),
    [
        (["-mfpmath=387"], "compile with: -msse2 -mfpmath=sse"),
        (["-U__BYTE_ORDER__", "-D__BYTE_ORDER__=__ORDER_BIG_ENDIAN__"], "Draw on a little-endian"),
    ],
)
def test_machines_with_other_bits_are_refused_by_the_compiler(flags, advice, tmp_path):
    if "387" in flags[0] and platform.machine() != "x86_64":
        pytest.skip("this machine has no x87")
    source = tmp_path / "main.c"
    source.write_text(toolchain.IMPLEMENTATION + "int main(void) { return 0; }\n")
    words = [toolchain.require("gcc"), f"-I{toolchain.INCLUDE}", *flags, "-fsyntax-only"]
    done = subprocess.run(
        [*words, source], capture_output=True, text=True, timeout=300, check=False
    )
    assert done.returncode != 0
    assert advice in done.stderr
