"""The guide is true: its programs compile and run, and give the rebounds of Python."""

import os
import re
import shutil
import subprocess
import sys
import textwrap
from pathlib import Path

import cupy_on_host
import numpy as np
import pytest
import toolchain

import sampler

PACKAGE = toolchain.INCLUDE.parent
#: The same folder in the repository, from which links may lead out.
SOURCE = Path(__file__).resolve().parents[2] / "sampler"
GUIDE = (PACKAGE / "EMBEDDING.md").read_text(encoding="utf-8")
NOT_RUN = "<!-- not run by the test"
BLOCKS = re.findall(r"(?:(<!-- [^\n]*) -->\n)?```(\w*)\n(.*?)```", GUIDE, re.S)


def blocks(language):
    """Blocks of a language that are run, in order."""
    return [text for mark, found, text in BLOCKS if found == language and not mark]


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
def folder(tmp_path, shipped_file):
    """Folder with the binary table that the programs open, and commands of this Python."""
    shutil.copy(shipped_file, tmp_path)
    commands = tmp_path / "commands"
    commands.mkdir()
    for name, words in {
        "python": f'"{sys.executable}"',
        "sampler": f'"{sys.executable}" -m sampler',
        "tablegen": f'"{sys.executable}" -m tablegen',
        # three copies for three processors would take three times as long
        "gcc": f'"{toolchain.find("gcc")}" {toolchain.ONE_COPY}',
    }.items():
        script = commands / name
        script.write_text(f'#!/bin/sh\nexec {words} "$@"\n')
        script.chmod(0o755)
    return tmp_path


def run_shell(text, folder):
    """What the commands of a block print."""
    root = str(PACKAGE.parent)
    path = f"{folder / 'commands'}{os.pathsep}{os.environ['PATH']}"
    python_path = os.pathsep.join(filter(None, [root, os.environ.get("PYTHONPATH")]))
    done = subprocess.run(
        ["bash", "-euo", "pipefail", "-c", text],
        cwd=folder,
        env=os.environ | {"PATH": path, "PYTHONPATH": python_path},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def check_velocity(printed, expected):
    np.testing.assert_allclose([float(x) for x in printed.split()], expected, atol=1e-6)


def test_every_block_is_checked_by_some_test():
    languages = {language for _, language, _ in BLOCKS}
    assert languages == {"sh", "python", "c", "cpp", "cuda", "fortran", "foam"}
    assert GUIDE.count("```") == 2 * len(BLOCKS)
    assert [mark.startswith(NOT_RUN) for mark, _, _ in BLOCKS if mark] == 4 * [True]


def test_python_and_numba(capsys, expected, tmp_path):
    values = {}
    with cupy_on_host.in_place_of_cupy(tmp_path):
        for number, text in enumerate(blocks("python")):
            exec(compile(text, f"EMBEDDING.md, block {number}", "exec"), values)
    # to the last digits of two libraries' functions
    there = cupy_on_host.asnumpy(values["v_there"])
    np.testing.assert_allclose(there, values["v"], rtol=0, atol=1e-9)
    np.testing.assert_array_equal(values["v"][42], expected)
    assert (values["hits"] == 1).all()
    assert values["outside"] == 0
    np.testing.assert_array_equal(values["after"], values["v"])
    np.testing.assert_array_equal(values["spin"], values["omega"])
    moving, rough = values["moving"], values["rough"]
    assert (moving[:, 1] > 15.0).all()
    assert (rough[:, 1] > 0.0).all()
    assert not np.array_equal(rough, values["v"])
    # what the text says of the half-sizes is what the block printed
    sizes = re.findall(r"a = (\S+) d", capsys.readouterr().out)
    assert "{}, {}, {} and {} diameters".format(*sizes) in GUIDE


@pytest.mark.parametrize("compiler", ["gcc", "clang", "g++", "clang++", "gfortran"])
def test_program(compiler, folder, expected, monkeypatch):
    language, suffix = {"g++": ("cpp", "cpp"), "clang++": ("cpp", "cpp")}.get(compiler, ("c", "c"))
    if compiler == "gfortran":
        language, suffix = "fortran", "f90"
    source = folder / f"bounce.{suffix}"
    source.write_text(only(language))
    if compiler == "gfortran":
        program = toolchain.build_fortran([source], folder)
    else:
        program = toolchain.build(compiler, [source], folder / "strict", [toolchain.ONE_COPY])
    monkeypatch.chdir(folder)
    check_velocity(toolchain.run(program), expected)


MAIN = r"""
int main()
{
    rbt_table *table;
    double v[3 * 50], omega[3 * 50];
    uint32_t hits[50] = {};
    for (int k = 0; k < 50; k++) {
        v[3 * k] = 120.0;
        v[3 * k + 1] = -90.0;
        v[3 * k + 2] = 0.0;
    }
    if (rbt_open("corundum-steel.rbt", &table) != RBT_OK || bounce_all(table, 50, v, omega, hits))
        return 1;
    printf("%.6f %.6f %.6f\n", v[3 * 42], v[3 * 42 + 1], v[3 * 42 + 2]);
    rbt_close(table);
    return hits[42] != 1;
}
"""


def test_kernel(folder, expected, monkeypatch):
    """The kernel of the guide, in loops of the host."""
    source = folder / "bounce.cu"
    source.write_text(f"#include <cstdio>\n{only('cuda')}{MAIN}")
    program = toolchain.build_on_host(source, folder / "bounce")
    monkeypatch.chdir(folder)
    check_velocity(toolchain.run(program), expected)


def check_plane(plane):
    """The pruned table gives u and v of the full one, and nothing out of the plane."""
    assert plane.columns == ("u", "v", "omega_z")
    impact = {"velocity": [120, -90, 0], "normal": [0, 1, 0], "half_size": 20e-6}
    v, omega = plane.rebound(**impact, seed=7, index=np.arange(50))
    full, spin = sampler.load("corundum-steel").rebound(**impact, seed=7, index=np.arange(50))
    np.testing.assert_array_equal(v[:, :2], full[:, :2])
    np.testing.assert_array_equal(omega[:, 2], spin[:, 2])
    assert not v[:, 2].any()
    assert not omega[:, :2].any()


def test_shell(folder, expected):
    toolchain.require("gcc")
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
    assert "measured          at 24 conditions" in run_shell(choose, folder)
    check_plane(sampler.load(folder / "plane.h5"))
    assert 0 < (folder / "plane.rbt").stat().st_size < len(written)


def test_the_block_on_spin_compiles(tmp_path):
    """It is a part of the program above it, with an angular velocity that lives on."""
    (spin,) = [text for mark, language, text in BLOCKS if mark and language == "c"]
    before, call, after = re.split(r"( +code = rbt_rebound\(.*?;\n)", only("c"))
    assert "NULL, NULL" in call
    spin = textwrap.indent(spin, "    ")
    (tmp_path / "spin.c").write_text(before.replace(", omega[3];", ";") + spin + after)
    toolchain.build("gcc", [tmp_path / "spin.c"], tmp_path / "spin", [toolchain.ONE_COPY])


def unrun_shell(about):
    """The shell block that is not run by the test and names a program."""
    marked = [text for mark, language, text in BLOCKS if mark and language == "sh"]
    (text,) = [text for text in marked if f"../{about}" in text]
    return text


def test_openfoam_scripts_exist():
    text = unrun_shell("openfoam")
    scripts = re.findall(r"\$F/(\S+\.sh)", text)
    assert scripts == ["install.sh", "build.sh"]
    assert all((PACKAGE / "openfoam" / name).is_file() for name in scripts)
    subprocess.run(["bash", "-n", "-c", text], check=True)


def test_openfoam_dictionary_has_the_entries_that_the_plugin_reads():
    plugin = (PACKAGE / "openfoam/plugin/TabulatedRebound.C").read_text(encoding="utf-8")
    given = re.findall(r'oeff\w*(?:\(\))?\.[\w ]+(?:<\w+>)?\("(\w+)"', plugin)
    read = {*given, *re.findall(r'required<\w+>\(coeffs, "(\w+)"\)', plugin)}
    text = only("foam")
    body = re.search(r"tabulatedReboundCoeffs\n\{\n(.*?)\}", text, re.S).group(1)
    entries = dict(re.fullmatch(r" +(\w+) +(.*);", line).groups() for line in body.splitlines())
    assert set(entries) == read
    assert len(read) == 7
    header = (PACKAGE / "openfoam/plugin/TabulatedRebound.H").read_text(encoding="utf-8")
    assert 'TypeName("tabulatedRebound")' in header
    assert entries["outOfRange"] in re.search(r"allowed: clamp, error", plugin).group()


def test_code_saturne_files_exist():
    text = unrun_shell("code_saturne")
    folder = PACKAGE / "code_saturne"
    assert list(folder.glob("src/*.[ch]"))
    assert all((folder / name).is_file() for name in re.findall(r"\$S/([\w./]+)", text))
    settings = (folder / "src/rebound_wall.cfg").read_text(encoding="utf-8")
    given = [line.split()[0] for line in settings.splitlines() if not line.startswith("#")]
    assert given == ["table", "seed"]  # the two lines that the guide promises
    subprocess.run(["bash", "-n", "-c", text], check=True)


def test_codes_are_those_of_the_header():
    header = (toolchain.INCLUDE / "rebound_sampler.h").read_text(encoding="utf-8")
    defined = dict(re.findall(r"#define (RBT_\w+) \(?(-?\d+)\)?", header))
    named = re.findall(r"^\| (-?\d+) `(RBT_\w+)`", GUIDE, re.M)
    assert len(named) == 8
    assert all(defined[name] == code for code, name in named)
    files = [int(code) for code in defined.values() if int(code) <= -10]
    assert f"{max(files)} to {min(files)}" in GUIDE


def test_half_size_and_clamping_are_as_said():
    """Half the size, twice the spin; below the table the coefficients of its slowest speed."""
    table = sampler.load("corundum-steel")
    keys = {"seed": 7, "index": np.arange(100)}
    v, omega = table.rebound([1.2, -0.9, 0.0], [0, 1, 0], 20e-6, **keys)
    assert table.clamped == 100
    _, faster_spin = table.rebound([1.2, -0.9, 0.0], [0, 1, 0], 10e-6, **keys)
    np.testing.assert_allclose(faster_spin, 2.0 * omega, rtol=1e-12)
    at_edge, _ = table.rebound([4.0, -3.0, 0.0], [0, 1, 0], 20e-6, **keys)
    np.testing.assert_allclose(v, 0.3 * at_edge, rtol=1e-9)


def test_links_and_files_exist():
    for target in re.findall(r"\]\(([^)#]+)\)", GUIDE):
        assert (SOURCE / target).is_file(), target
    for name in re.findall(r"`((?:fluent|openfoam|code_saturne|c|fortran)/[\w./]*)`", GUIDE):
        assert (PACKAGE / name).exists(), name
    headings = {
        re.sub(r"[^a-z0-9_ -]", "", h.lower()).replace(" ", "-")
        for h in re.findall(r"^#+ (.*)$", GUIDE, re.M)
    }
    assert set(re.findall(r"\]\(#([^)]+)\)", GUIDE)) <= headings
