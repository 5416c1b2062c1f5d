"""Programs of pages print what the pages show, and trackers agree with Python's."""

import os
import re
import shutil
import sys

import cupy_on_host
import numpy as np
import pytest
import toolchain
from documents import ROOT, SHELL, blocks

PACKAGE = toolchain.INCLUDE.parent

#: File as which a reader saves the program of a page, the first block of it.
PROGRAMS = {
    "PYTHON.md": "rebound.py",
    "NUMBA.md": "rebound.py",
    "c/README.md": "rebound.c",
    "fortran/README.md": "rebound.f90",
}


def blocks_of(page):
    """Blocks of a page, and whether a comment above says that the test leaves them out."""
    text = (PACKAGE / page).read_text(encoding="utf-8")
    left_out = re.findall(r"<!-- not run by the test[^\n]*-->\n```\w*\n(.*?)```", text, re.S)
    return [(block, block.text in left_out) for block in blocks(text)]


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
        quick = " ".join(toolchain.QUICK) if name == "gcc" else ""
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


def numbers_in(printed):
    """Numbers behind the colons of what a tracker prints."""
    return [float(line.partition(":")[2]) for line in printed.splitlines()]


#: What the tracker in Python prints: ends, hits, sums of squared velocity and of spin.
EXPECTED = numbers_in(blocks_of("PYTHON.md")[-1][0].text)


def check(printed):
    """Compare what a tracker prints with `EXPECTED`.

    Counts are equal, and sums to the last digits of atan2, cos and sin over ten hits.
    """
    numbers = numbers_in(printed)[:5]
    np.testing.assert_array_equal(numbers[:3], EXPECTED[:3])
    np.testing.assert_allclose(numbers[3:], EXPECTED[3:], rtol=1e-9)


@pytest.mark.parametrize("compiler", ["gcc", "g++", "gfortran"])
def test_strict_compilers_have_no_warning(compiler, tmp_path):
    """Pages and `test_vendor` run the trackers."""
    flags = ["-fsyntax-only"]
    if compiler == "gfortran":
        sources = [toolchain.MODULE, PACKAGE / "fortran" / "tracker.f90", f"-J{tmp_path}"]
        toolchain.build(compiler, sources, tmp_path / "none", flags)
    else:
        # g++ warns of the records that C begins with {0}
        flags += ["-Wno-missing-field-initializers"] if compiler == "g++" else []
        toolchain.build(compiler, [PACKAGE / "c" / "tracker.c"], tmp_path / "none", flags)


def test_kernel_on_host(folder):
    tracker = PACKAGE / "c" / "tracker.cu"
    check(toolchain.run(toolchain.build_on_host(tracker, folder / "kernel")))


@pytest.mark.parametrize("page", PROGRAMS)
def test_a_page_shows_what_its_programs_print(page, folder):
    """Each block of output is that of the program or of the commands before it."""
    toolchain.require({"c": "gcc", "f": "gfortran"}.get(page[0], "gcc"))
    (program, _), *others = blocks_of(page)
    (folder / PROGRAMS[page]).write_text(program.text)
    (folder / "docs").symlink_to(ROOT / "docs")  # commands of Python's pages begin in a checkout
    printed = run_shell("python rebound.py", folder) if program.language == "python" else None
    outputs = []
    for block, left_out in others:
        # `test_direct_object` makes objects of direct simulation, and links them
        if block.language in SHELL and not left_out and "export-direct" not in block.text:
            printed = run_shell(block.text, folder)
        elif block.language == "text":
            outputs.append((printed, block.text))
    rebound, tracker = outputs
    assert rebound[0].endswith(rebound[1])  # commands print before the program
    np.testing.assert_allclose(*map(numbers_in, tracker), rtol=1e-9)
    check(tracker[0])


#: Declarations before the lines of C in README, the arguments of the program in c/README.md.
BEFORE = """
int main(void)
{
double velocity[3] = {120.0, -90.0, 0.0}, omega[3] = {0}, inertia = 0.0;
const double normal[3] = {0.0, 1.0, 0.0}, half_size = 20e-6;
uint64_t index = 5;
uint32_t hit = 0;
"""
AFTER = """
printf("%d %u %.2f %.2f %.2f", code, hit, velocity[0], velocity[1], velocity[2]);
rbt_close(table);
return 0;
}
"""


def test_the_lines_of_c_in_the_readme_are_the_rebound_of_the_page(folder):
    readme = blocks((ROOT / "README.md").read_text(encoding="utf-8"))
    (lines,) = (block.text for block in readme if block.language == "c")
    includes = f"{toolchain.IMPLEMENTATION}#include <stdio.h>\n"
    (folder / "readme.c").write_text(includes + BEFORE + lines + AFTER)
    program = toolchain.build("gcc", [folder / "readme.c"], folder / "readme", toolchain.QUICK)
    printed = toolchain.run(program).split()
    page = next(b.text for b, _ in blocks_of("c/README.md") if b.text.startswith("velocity"))
    assert printed == ["0", "1", *page.splitlines()[0].partition(":")[2].split()]


def test_cupy(tmp_path, capsys):
    (text,) = (
        block.text for block, _ in blocks_of("device/README.md") if block.language == "python"
    )
    with cupy_on_host.in_place_of_cupy(tmp_path):
        exec(compile(text, "device/README.md", "exec"), values := {})
    velocity = np.tile([120.0, -90.0, 0.0], (1000, 1))
    keys = {"seed": 7, "index": range(1000), "hit": 0}
    host = values["table"].rebound(velocity, [0.0, 1.0, 0.0], 20e-6, **keys)
    np.testing.assert_allclose(values["velocity"].get(), host.velocity, rtol=0, atol=1e-9)
    blocks_of_page = [block for block, _ in blocks_of("device/README.md")]
    outputs = [block.text for block in blocks_of_page if block.language == "text"]
    assert [capsys.readouterr().out] == outputs
