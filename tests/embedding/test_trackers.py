"""Trackers in each language, with which most pages begin, give the numbers of Python's."""

import os
import re
import runpy
import shutil
import sys

import cupy_on_host
import numpy as np
import pytest
import toolchain
from documents import ROOT, SHELL, blocks

import sampler

PACKAGE = toolchain.INCLUDE.parent
TRACKERS = {
    "PYTHON.md": ROOT / "docs" / "examples" / "tracker.py",
    "NUMBA.md": ROOT / "docs" / "examples" / "tracker_numba.py",
    "c/README.md": PACKAGE / "c" / "tracker.c",
    "fortran/README.md": PACKAGE / "fortran" / "tracker.f90",
}


def blocks_of(page):
    """Blocks of a page, and whether a comment above says that the test leaves them out."""
    text = (PACKAGE / page).read_text(encoding="utf-8")
    left_out = re.findall(r"<!-- not run by the test[^\n]*-->\n```\w*\n(.*?)```", text, re.S)
    return [(block, block.text in left_out) for block in blocks(text)]


@pytest.fixture(scope="module")
def expected():
    """What the tracker in Python returns: ends, hits, sums of squared velocity and of spin."""
    table = sampler.load("corundum-steel")
    with pytest.warns(sampler.OutsideTableWarning):
        return runpy.run_path(str(TRACKERS["PYTHON.md"]))["follow"](table, 2000)


@pytest.fixture
def folder(tmp_path, shipped_file, monkeypatch):
    """Working folder with the table that programs open, and commands of this Python."""
    shutil.copy(shipped_file, tmp_path)
    (tmp_path / "commands").mkdir()
    for name, words in {
        "python": f'"{sys.executable}"',
        "sampler": f'"{sys.executable}" -m sampler',
        "tablegen": f'"{sys.executable}" -m tablegen',
        "gcc": f'"{toolchain.find("gcc")}"',
    }.items():
        quick = f"{toolchain.ONE_COPY} -O0" if name == "gcc" else ""
        script = tmp_path / "commands" / name
        script.write_text(f'#!/bin/sh\nexec {words} "$@" {quick}\n')
        script.chmod(0o755)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run_shell(text, folder):
    path = os.pathsep.join([str(folder / "commands"), os.environ["PATH"]])
    roots = os.pathsep.join(filter(None, [str(PACKAGE.parent), os.environ.get("PYTHONPATH")]))
    words = "bash", "-euo", "pipefail", "-c", text
    return toolchain.run(*words, PATH=path, PYTHONPATH=roots)


def check(printed, expected):
    """Counts are equal, and sums to the last digits of atan2, cos and sin over ten hits."""
    numbers = [float(x) for x in printed.splitlines()[-1].split()[:5]]
    np.testing.assert_array_equal(numbers[:3], expected[:3])
    np.testing.assert_allclose(numbers[3:], expected[3:], rtol=1e-9)


@pytest.mark.parametrize("page", TRACKERS)
def test_page_begins_with_its_tracker(page):
    assert blocks_of(page)[0][0].text == TRACKERS[page].read_text(encoding="utf-8")


def test_numba(folder, expected):
    check(run_shell(f"python {TRACKERS['NUMBA.md']}", folder), expected)


@pytest.mark.parametrize("compiler", ["gcc", "g++", "gfortran", "on host"])
def test_compiled(compiler, folder, expected):
    if compiler == "gfortran":
        program = toolchain.build_fortran([TRACKERS["fortran/README.md"]], folder, ["-O1"])
    elif compiler == "on host":
        program = toolchain.build_on_host(PACKAGE / "c" / "tracker.cu", folder / "kernel")
    else:
        # g++ warns of the records that C begins with {0}
        flags = ["-Wno-missing-field-initializers"] if compiler == "g++" else []
        program = toolchain.build(compiler, [TRACKERS["c/README.md"]], folder / "strict", flags)
    check(toolchain.run(program), expected)


@pytest.mark.parametrize("page", ["c/README.md", "fortran/README.md"])
def test_commands_of_a_page(page, folder, expected):
    shutil.copy(TRACKERS[page], folder)
    toolchain.require("gfortran" if page.startswith("fortran") else "gcc")
    for block, left_out in blocks_of(page):
        if block.language in SHELL and not left_out:
            check(run_shell(block.text, folder), expected)


def test_choosing_a_table(folder):
    ((block, _),) = blocks_of("EMBEDDING.md")
    assert "measured          at 12 conditions" in run_shell(block.text, folder)
    assert (
        0 < (folder / "plane.rbt").stat().st_size < (folder / "corundum-steel.rbt").stat().st_size
    )


def test_cupy(tmp_path, capsys):
    (text,) = (
        block.text for block, _ in blocks_of("device/README.md") if block.language == "python"
    )
    with cupy_on_host.in_place_of_cupy(tmp_path):
        exec(compile(text, "device/README.md", "exec"), values := {})
    keys = {"seed": 7, "index": range(1000)}
    host = values["table"].rebound(values["velocity"], values["normal"], 20e-6, **keys)
    np.testing.assert_allclose(values["v"].get(), host.velocity, rtol=0, atol=1e-9)
    assert capsys.readouterr().out == "0 outside the table\n"
