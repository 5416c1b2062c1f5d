"""The folder of ``sampler vendor`` builds and runs in C, C++ and Fortran, without Python."""

import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
import toolchain
from documents import blocks
from test_trackers import check, numbers_in

import sampler
from sampler.cli import main

#: Programs that builds may use.
TOOLS = [
    "cmake",
    "make",
    "ninja",
    "cc",
    "gcc",
    "c++",
    "g++",
    "gfortran",
    "ar",
    "ranlib",
    "ld",
    "as",
    "nm",
    "sh",
    "uname",
    "pkg-config",
    "rm",
]

SOLVER = """
cmake_minimum_required(VERSION 3.15)
project(solver LANGUAGES C CXX {fortran})
{package}
add_executable(in_c tracker.c)
add_executable(in_cpp tracker.cpp)
target_link_libraries(in_c rebound_sampler::rebound_sampler)
target_link_libraries(in_cpp rebound_sampler::rebound_sampler)
if(CMAKE_Fortran_COMPILER)
  add_executable(in_fortran tracker.f90)
  target_link_libraries(in_fortran rebound_sampler::fortran)
endif()
"""


@pytest.fixture(scope="module")
def vendored(tmp_path_factory):
    folder = tmp_path_factory.mktemp("vendor") / "rebound"
    assert main(["vendor", str(folder)]) == 0
    return folder


@pytest.fixture
def shell(tmp_path):
    """Run a command line where no Python is on the path."""
    tools = tmp_path / "tools"
    tools.mkdir()
    for name in TOOLS:
        if (path := toolchain.find(name)) is None:
            continue
        if name in ("cc", "gcc", "c++", "g++"):
            (tools / name).write_text(f'#!/bin/sh\nexec {path} "$@" {" ".join(toolchain.QUICK)}\n')
            (tools / name).chmod(0o755)
        else:
            (tools / name).symlink_to(path)
    assert not any(name.startswith("python") for name in os.listdir(tools))

    def run(line, folder, **variables):
        words = ["/bin/sh", "-euc", line]
        environment = {"PATH": str(tools), "HOME": str(tmp_path)} | variables
        done = subprocess.run(
            words, cwd=folder, env=environment, capture_output=True, text=True, timeout=600
        )
        assert done.returncode == 0, f"{line}\n{done.stdout}{done.stderr}"
        return done.stdout

    return run


def solver(folder, vendored, package):
    """Make a project whose programs are the trackers, linked with the library of the folder."""
    folder.mkdir()
    text = (vendored / "tracker.c").read_text().replace("#define REBOUND_SAMPLER_IMPL", "// ")
    (folder / "tracker.c").write_text(text)
    (folder / "tracker.cpp").write_text(text)
    shutil.copy(vendored / "tracker.f90", folder)
    fortran = "Fortran" if toolchain.find("gfortran") else ""
    (folder / "CMakeLists.txt").write_text(SOLVER.format(fortran=fortran, package=package))
    return ["in_c", "in_cpp", "in_fortran"][: 3 if fortran else 2]


def blocks_of_page(vendored):
    return [block.text for block in blocks((vendored / "README.md").read_text(encoding="utf-8"))]


@pytest.mark.apart
def test_add_subdirectory(vendored, shell, tmp_path):
    toolchain.require("cmake")
    package = f"add_subdirectory({vendored} rebound)"
    solver(tmp_path / "solver", vendored, package)
    shell("cmake -S solver -B build && cmake --build build", tmp_path)
    check(shell(str(tmp_path / "build" / "in_c"), vendored))


@pytest.mark.apart
def test_an_installed_folder_is_found(vendored, shell, tmp_path):
    toolchain.require("cmake")
    prefix = tmp_path / "prefix"
    programs = solver(tmp_path / "solver", vendored, "find_package(rebound_sampler 1.0 REQUIRED)")
    install, *_ = (block for block in blocks_of_page(vendored) if "--install" in block)
    shell(install.replace("DIR", str(vendored)).replace("/opt/rebound", str(prefix)), tmp_path)
    assert (tmp_path / "build" / "tracker_c").is_file()
    shell("cmake --build solver-build", tmp_path)
    installed = prefix / "share" / "rebound_sampler"
    for program in programs[1:]:  # in C above
        check(shell(str(tmp_path / "solver-build" / program), installed))
    if toolchain.find("pkg-config"):
        path = str(prefix / "share" / "pkgconfig")
        line = "pkg-config --variable=c_source rebound_sampler"
        source = shell(line, tmp_path, PKG_CONFIG_PATH=path).strip()
        assert Path(source).resolve() == installed / "rebound_sampler.c"


def test_the_package_itself_is_found_by_cmake(shell, tmp_path):
    toolchain.require("cmake")
    (tmp_path / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.15)\nproject(solver LANGUAGES C)\n"
        "find_package(rebound_sampler 1.0 REQUIRED)\n"
        "get_target_property(folders rebound_sampler::rebound_sampler INCLUDE_DIRECTORIES)\n"
        'file(WRITE found.txt "${folders} ${rebound_sampler_VERSION}")\n'
    )
    shell(f'cmake -S . -B build -Drebound_sampler_DIR="{toolchain.INCLUDE}"', tmp_path)
    found = (tmp_path / "found.txt").read_text()
    assert found == f"{toolchain.INCLUDE} {sampler.__version__}"


@pytest.mark.apart
def test_pkg_config(vendored, shell, tmp_path):
    """The commands of the page, on a solver that is the tracker."""
    toolchain.require("pkg-config")
    (block,) = (block for block in blocks_of_page(vendored) if "pkg-config --cflags" in block)
    export, c_line, *fortran_lines = block.replace("DIR", str(vendored)).splitlines()
    for end in ("c", "f90"):
        shutil.copy(vendored / f"tracker.{end}", tmp_path / f"solver.{end}")
    shutil.copy(vendored / "corundum-steel.rbt", tmp_path)
    check(shell(f"{export}\n{c_line}\n./solver", tmp_path))
    if toolchain.find("gfortran"):
        check(shell("\n".join([export, *fortran_lines, "./solver"]), tmp_path))


@pytest.mark.parametrize("compiler", ["gcc -O2 -I.", "gfortran"])
def test_by_hand(compiler, vendored, shell, tmp_path):
    """The commands of the page; CMake builds the tracker as C++ above, and another needs nvcc."""
    toolchain.require(compiler.split()[0])
    shutil.copytree(vendored, tmp_path / "copy")
    (block,) = (block for block in blocks_of_page(vendored) if "nvcc" in block)
    (line,) = (line for line in block.splitlines() if compiler in line)
    printed = shell(line, tmp_path / "copy")
    check(printed)
    (page,) = (block for block in blocks_of_page(vendored) if block.startswith("grains that pass"))
    np.testing.assert_allclose(numbers_in(printed), numbers_in(page), rtol=1e-9)


def test_versions_agree():
    text = (toolchain.INCLUDE / "rebound_sampler.pc").read_text(encoding="utf-8")
    assert f"\nVersion: {sampler.__version__}\n" in text


@pytest.mark.parametrize(
    ("words", "line"),
    [
        (["file"], "folder: file is a file; give a new folder"),
        (["full"], "folder: full exists; give a new folder"),
        (["new", "nothing"], "table: there is no .h5 file 'nothing'; the installed names are "),
        (["new", "file"], "file: this is no HDF5 file"),
        (["new", "corundum-steel", "full/corundum-steel.h5"], "would both become corundum-steel"),
        (["none/new"], "folder: cannot write none/new: there is no folder "),
    ],
)
def test_refusals(words, line, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("kept")
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "corundum-steel.h5").write_text("kept")
    assert main(["vendor", *words]) == 2
    assert line in capsys.readouterr().err
    assert sorted(os.listdir(tmp_path)) == ["file", "full"]
