"""The examples run, and agree with each other and with Python on what becomes of the particles."""

import re

import numpy as np
import pytest
import toolchain

import sampler
from sampler.formats.binary import write_image
from tablegen.config import load_config
from tablegen.prune import pruned

FORTRAN = toolchain.INCLUDE.parent / "fortran"
PARTICLES, HITS = 2000, 6
WORDS = re.compile(
    r"mean velocity along the plates +(\S+) m/s, mean spin +(\S+) rad/s, failed 0\n"
    r" *([0-9.E+e]+) rebounds per second on (\d) threads\n"
)


@pytest.fixture(scope="module")
def table():
    return sampler.load("corundum-steel")


@pytest.fixture(scope="module")
def image(table, tmp_path_factory):
    path = tmp_path_factory.mktemp("image") / "corundum-steel.rbt"
    write_image(path, table.contents)
    return path


def follow(table):
    """Velocities and spins of the particles after all their walls, from Python."""
    velocity = np.tile([150.0, -80.0, 0.0], (PARTICLES, 1))
    keys = {"seed": 7, "index": np.arange(PARTICLES)}
    for hit in range(HITS):
        side = 1.0 if hit % 2 == 0 else -1.0
        velocity, omega = table.rebound(velocity, [0.0, side, 0.0], 20e-6, hit=hit, **keys)
        velocity += 0.8 * (np.array([150.0, 80.0 * side, 0.0]) - velocity)
    return velocity, omega


@pytest.fixture(scope="module")
def expected(table):
    """Mean velocity along the plates and mean spin, from Python."""
    velocity, omega = follow(table)
    assert table.clamped == 0
    return velocity[:, 0].mean(), omega[:, 2].mean()


def check(program, image, expected, threads):
    printed = toolchain.run(program, image, PARTICLES, HITS, OMP_NUM_THREADS=str(threads))
    along, spin, speed, on = WORDS.fullmatch(printed).groups()
    assert float(along) == pytest.approx(expected[0], abs=6e-4)
    assert float(spin) == pytest.approx(expected[1], rel=6e-4)
    assert float(speed) > 0.0
    assert int(on) == threads


@pytest.fixture(scope="module")
def steep(table, tmp_path_factory):
    """Image of a table of steep impacts only, and how many rebounds it has to clamp."""
    path = tmp_path_factory.mktemp("image") / "steep.rbt"
    scene = load_config("corundum-steel").with_changes({"domain": {"alpha_deg": [30.0, 90.0]}})
    contents = pruned(table.contents, scene)
    write_image(path, contents)
    narrow = sampler.Table(contents)
    follow(narrow)
    assert 0 < narrow.clamped < PARTICLES * HITS
    return path, narrow.clamped


def check_count(program, steep):
    image, clamped = steep
    lines = toolchain.run(program, image, PARTICLES, HITS).splitlines()
    assert lines[2:] == [f"{clamped} rebounds lay outside the table and took its nearest condition"]


@pytest.mark.parametrize("threads", [1, 2])
def test_c(image, steep, expected, threads, tmp_path):
    program = toolchain.build(
        "gcc", [toolchain.INCLUDE / "particles.c"], tmp_path / "particles", ["-O2", "-fopenmp"]
    )
    check(program, image, expected, threads)
    check_count(program, steep)


@pytest.mark.parametrize("threads", [1, 2])
def test_fortran(image, steep, expected, threads, tmp_path):
    library = tmp_path / "library.c"
    library.write_text('#define REBOUND_SAMPLER_IMPLEMENTATION\n#include "rebound_sampler.h"\n')
    toolchain.compile_with("gcc", ["-O2", "-c", library, "-o", tmp_path / "library.o"])
    module = toolchain.INCLUDE / "rebound_sampler.f90"
    program = toolchain.build(
        "gfortran",
        [module, FORTRAN / "particles.f90", tmp_path / "library.o"],
        tmp_path / "particles",
        ["-O2", "-fopenmp", f"-J{tmp_path}"],
    )
    check(program, image, expected, threads)
    check_count(program, steep)
