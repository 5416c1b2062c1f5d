"""The examples run, and agree with each other and with Python on what becomes of the particles."""

import re

import numpy as np
import pytest
import toolchain
from spin_tables import with_spin_law

import sampler
from sampler.formats.binary import write_binary_table
from tablegen.config import load_config
from tablegen.prune import pruned

FORTRAN = toolchain.INCLUDE.parent / "fortran"
PARTICLES, HITS = 2000, 6
WORDS = re.compile(
    r"mean velocity along the plates +(\S+) m/s, mean spin +(\S+) rad/s, failed 0\n"
    r" *([0-9.E+e]+) rebounds per second on (\d) threads\n"
)


def follow(table):
    """Velocities and spins of the particles after all their walls, from Python."""
    velocity = np.tile([150.0, -80.0, 0.0], (PARTICLES, 1))
    omega = np.zeros((PARTICLES, 3))
    keys = {"seed": 7, "index": np.arange(PARTICLES)}
    for hit in range(HITS):
        side = 1.0 if hit % 2 == 0 else -1.0
        before = omega if table.contents.has_spin else None
        velocity, omega = table.rebound(
            velocity, [0.0, side, 0.0], 20e-6, omega=before, hit=hit, **keys
        )
        velocity += 0.8 * (np.array([150.0, 80.0 * side, 0.0]) - velocity)
    return velocity, omega


@pytest.fixture(scope="module")
def expected(shipped):
    """Mean velocity along the plates and mean spin, from Python."""
    velocity, omega = follow(shipped)
    assert shipped.clamped == 0
    return velocity[:, 0].mean(), omega[:, 2].mean()


def check(program, file, expected, threads):
    printed = toolchain.run(program, file, PARTICLES, HITS, OMP_NUM_THREADS=str(threads))
    along, spin, speed, on = WORDS.fullmatch(printed).groups()
    assert float(along) == pytest.approx(expected[0], abs=6e-4)
    assert float(spin) == pytest.approx(expected[1], rel=6e-4)
    assert float(speed) > 0.0
    assert int(on) == threads


@pytest.fixture(scope="module")
def steep(shipped, tmp_path_factory):
    """Binary table of steep impacts and without spin, and how many rebounds it has to clamp."""
    path = tmp_path_factory.mktemp("steep") / "steep.rbt"
    changes = {"spin": False, "domain": {"alpha_deg": [30.0, 90.0]}}
    scene = load_config("corundum-steel").with_changes(changes)
    contents = pruned(shipped.contents, scene)
    write_binary_table(path, contents)
    narrow = sampler.Table(contents)
    follow(narrow)
    assert 0 < narrow.clamped < PARTICLES * HITS
    return path, narrow.clamped


@pytest.fixture(scope="module")
def spinning(shipped, tmp_path_factory):
    """Binary table with a random spin law, and the means and clamped rebounds of its particles."""
    path = tmp_path_factory.mktemp("spinning") / "spinning.rbt"
    contents = with_spin_law(shipped.contents)
    write_binary_table(path, contents)
    table = sampler.Table(contents)
    velocity, omega = follow(table)
    return path, (velocity[:, 0].mean(), omega[:, 2].mean()), table.clamped


def check_spinning(program, spinning):
    file, expected, clamped = spinning
    lines = toolchain.run(program, file, PARTICLES, HITS).splitlines(keepends=True)
    along, spin, _, _ = WORDS.fullmatch("".join(lines[:2])).groups()
    assert float(along) == pytest.approx(expected[0], abs=6e-4)
    assert float(spin) == pytest.approx(expected[1], rel=6e-4)
    assert (f"{clamped} rebounds lay outside" in "".join(lines[2:])) == (clamped > 0)


def check_count(program, steep):
    file, clamped = steep
    lines = toolchain.run(program, file, PARTICLES, HITS).splitlines()
    assert lines[2:] == [f"{clamped} rebounds lay outside the table and took its nearest condition"]


def build_c(folder):
    source, flags = [toolchain.INCLUDE / "particles.c"], ["-O2", "-fopenmp"]
    return toolchain.build("gcc", source, folder / "particles", flags)


def build_fortran(folder):
    return toolchain.build_fortran([FORTRAN / "particles.f90"], folder, ["-O2", "-fopenmp"])


@pytest.mark.parametrize("build", [build_c, build_fortran])
def test_particles(build, shipped_file, steep, spinning, expected, tmp_path):
    program = build(tmp_path)
    for threads in (1, 2):
        check(program, shipped_file, expected, threads)
    check_count(program, steep)
    check_spinning(program, spinning)
