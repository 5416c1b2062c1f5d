"""The guide is true: its programs compile and run, and give the rebounds of Python."""

import os
import re
import shutil
import sys

import cupy_on_host
import numpy as np
import pytest
import toolchain

import sampler
from sampler.errors import CODES

PACKAGE = toolchain.INCLUDE.parent
GUIDE = (PACKAGE / "EMBEDDING.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"(?:(<!-- [^\n]*) -->\n)?```(\w*)\n(.*?)```", GUIDE, re.S)
COMPILERS = {"gcc": "c", "clang": "c", "g++": "cpp", "clang++": "cpp", "gfortran": "fortran"}


def blocks(language, marked=False):
    """Blocks of a language, in order: those that run, or those marked as not run."""
    return [text for mark, found, text in BLOCKS if found == language and bool(mark) == marked]


def only(language):
    (text,) = blocks(language)
    return text


@pytest.fixture(scope="module")
def expected():
    """Velocity of the one particle that all programs follow."""
    table = sampler.load("corundum-steel")
    velocity, _ = table.rebound([120, -90, 0], [0, 1, 0], 20e-6, seed=7, index=[42])
    return velocity[0]


@pytest.fixture
def folder(tmp_path, shipped_file, monkeypatch):
    """Working folder with the table that programs open, and commands of this Python."""
    shutil.copy(shipped_file, tmp_path)
    (tmp_path / "commands").mkdir()
    for name, words in {
        "python": f'"{sys.executable}"',
        "sampler": f'"{sys.executable}" -m sampler',
        "tablegen": f'"{sys.executable}" -m tablegen',
        "gcc": f'"{toolchain.find("gcc")}" {toolchain.ONE_COPY}',
    }.items():
        script = tmp_path / "commands" / name
        script.write_text(f'#!/bin/sh\nexec {words} "$@"\n')
        script.chmod(0o755)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run_shell(text, folder):
    """Run the commands of a block; return what they print."""
    path = os.pathsep.join([str(folder / "commands"), os.environ["PATH"]])
    roots = os.pathsep.join(filter(None, [str(PACKAGE.parent), os.environ.get("PYTHONPATH")]))
    words = "bash", "-euo", "pipefail", "-c", text
    return toolchain.run(*words, PATH=path, PYTHONPATH=roots)


def check_velocity(printed, expected):
    np.testing.assert_allclose([float(x) for x in printed.split()], expected, atol=1e-6)


def test_python_numba_and_cupy(capsys, expected, tmp_path):
    values = {}
    with cupy_on_host.in_place_of_cupy(tmp_path):
        for number, text in enumerate(blocks("python")):
            exec(compile(text, f"EMBEDDING.md, block {number}", "exec"), values)
    # to the last digits of two libraries' functions
    there = cupy_on_host.asnumpy(values["v_there"])
    np.testing.assert_allclose(there, values["v"], rtol=0, atol=1e-9)
    np.testing.assert_array_equal(values["v"][42], expected)
    np.testing.assert_array_equal(values["after"], values["v"])
    np.testing.assert_array_equal(values["spin"], values["omega"])
    assert (values["hits"] == 1).all()
    assert values["outside"] == 0
    assert (values["moving"][:, 1] > 15.0).all()
    # the half-sizes in the text are those that the block printed
    sizes = re.findall(r"a = (\S+) d", capsys.readouterr().out)
    assert "{}, {}, {} and {} diameters".format(*sizes) in GUIDE


@pytest.mark.parametrize("compiler", COMPILERS)
def test_program(compiler, folder, expected):
    source = folder / ("bounce.f90" if compiler == "gfortran" else "bounce.c")
    source.write_text(only(COMPILERS[compiler]))
    if compiler == "gfortran":
        program = toolchain.build_fortran([source], folder)
    else:
        program = toolchain.build(compiler, [source], folder / "strict", [toolchain.ONE_COPY])
    check_velocity(toolchain.run(program), expected)


MAIN = r"""
int main()
{
    rbt_table *table;
    double v[150], omega[150] = {};
    uint32_t hits[50] = {};
    for (int k = 0; k < 150; k++)
        v[k] = k % 3 == 0 ? 120.0 : k % 3 == 1 ? -90.0 : 0.0;
    if (rbt_open("corundum-steel.rbt", &table) != RBT_OK || bounce_all(table, 50, v, omega, hits))
        return 1;
    printf("%.6f %.6f %.6f\n", v[126], v[127], v[128]);
    rbt_close(table);
    return hits[42] != 1;
}
"""


def test_kernel(folder, expected):
    (folder / "bounce.cu").write_text(f"#include <cstdio>\n{only('cuda')}{MAIN}")
    program = toolchain.build_on_host(folder / "bounce.cu", folder / "bounce")
    check_velocity(toolchain.run(program), expected)


def test_shell(folder, expected):
    (folder / "bounce.c").write_text(only("c"))
    (folder / "bounce.f90").write_text(only("fortran"))
    export, build_c, build_fortran, choose = blocks("sh")
    written = (folder / "corundum-steel.rbt").read_bytes()
    (folder / "corundum-steel.rbt").unlink()
    run_shell(export, folder)
    assert (folder / "corundum-steel.rbt").read_bytes() == written
    check_velocity(run_shell(build_c, folder), expected)
    if toolchain.find("gfortran"):
        check_velocity(run_shell(build_fortran, folder), expected)
    assert "measured          at 12 conditions" in run_shell(choose, folder)
    assert 0 < (folder / "plane.rbt").stat().st_size < len(written)


def test_codes_are_those_that_programs_get():
    defined = {f"RBT_{code.name}": str(code.number) for code in CODES}
    named = re.findall(r"^\| (-?\d+) `(RBT_\w+)`", GUIDE, re.M)
    assert len(named) == 9
    assert all(defined[name] == code for code, name in named)
