"""The examples run, and agree with each other and with Python on what becomes of the particles."""

import importlib.util
import re

import numpy as np
import pytest
import toolchain
from documents import ROOT
from sampler.formats.image import write_binary_table
from spin_tables import with_spin_law

import sampler
from tablegen.config.config import load_config
from tablegen.tables.prune import pruned

FORTRAN = toolchain.INCLUDE.parent / "fortran"
PARTICLES, HITS = 2000, 6
WORDS = re.compile(
    r"mean velocity along the plates +(\S+) m/s, mean spin +(\S+) rad/s, failed 0\n"
    r" *([0-9.E+e]+) rebounds per second on (\d) threads\n"
    r"digest ([0-9A-F]{16})\n"
)


def follow(table, particles=PARTICLES, hits=HITS, roughness=None):
    """Velocities and spins of the particles after all their walls, from Python."""
    velocity = np.tile([150.0, -80.0, 0.0], (particles, 1))
    omega = np.zeros((particles, 3))
    keys = {"seed": 7, "index": np.arange(particles), "roughness": roughness}
    for hit in range(hits):
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
    along, spin, speed, on, _ = WORDS.fullmatch(printed).groups()
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
    along, spin, *_ = WORDS.fullmatch("".join(lines[:3])).groups()
    assert float(along) == pytest.approx(expected[0], abs=6e-4)
    assert float(spin) == pytest.approx(expected[1], rel=6e-4)
    assert (f"{clamped} rebounds lay outside" in "".join(lines[3:])) == (clamped > 0)


def check_count(program, steep):
    file, clamped = steep
    lines = toolchain.run(program, file, PARTICLES, HITS).splitlines()
    assert lines[3:] == [f"{clamped} rebounds lay outside the table and took its nearest condition"]


def build_c(folder):
    flags = ["-O2", "-ffp-contract=off", "-fopenmp", toolchain.ONE_COPY]
    return toolchain.build("gcc", [toolchain.INCLUDE / "particles.c"], folder / "particles", flags)


def build_fortran(folder):
    flags = ["-O2", "-ffp-contract=off", "-fopenmp"]
    return toolchain.build_fortran([FORTRAN / "particles.f90"], folder, flags)


@pytest.fixture(scope="module")
def programs(tmp_path_factory):
    """The loops in C and in Fortran."""
    builds = {"c": build_c, "fortran": build_fortran}
    return {name: build(tmp_path_factory.mktemp(name)) for name, build in builds.items()}


@pytest.mark.parametrize("language", ["c", "fortran"])
def test_particles(language, programs, shipped_file, steep, spinning, expected):
    program = programs[language]
    for threads in (1, 2):
        check(program, shipped_file, expected, threads)
    check_count(program, steep)
    check_spinning(program, spinning)


def test_particles_of_a_device_are_those_of_c(programs, shipped_file, spinning, tmp_path):
    """The loop for GPUs, in loops of the host: equal means, digests and counts."""
    source = toolchain.INCLUDE / "particles.cu"
    device = toolchain.build_on_host(source, tmp_path / "particles", ["-O1"])
    for arguments in ((shipped_file, 500, 4), (shipped_file, 500, 4, 0.2), (spinning[0], 200, 4)):
        lines = [
            toolchain.run(program, *arguments).splitlines() for program in (programs["c"], device)
        ]
        assert lines[0][1] != lines[1][1]  # the time
        assert [*lines[0][:1], *lines[0][2:]] == [*lines[1][:1], *lines[1][2:]]


@pytest.fixture(scope="module")
def numba_example():
    """The loop of docs/examples/particles.py."""
    path = ROOT / "docs" / "examples" / "particles.py"
    spec = importlib.util.spec_from_file_location("particles", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def digest_of(program, *arguments):
    """Digest of all rebounds that a program prints; it is the same on any number of threads."""
    found = set()
    for threads in (1, 2):
        printed = toolchain.run(program, *arguments, OMP_NUM_THREADS=str(threads))
        found.add(WORDS.match(printed)[5])
    (digest,) = found
    return int(digest, 16)


def check_all_languages(numba_example, programs, spinning, particles, hits, roughness):
    """The same bits in C, Fortran and numba; in Python the same to single precision."""
    file, *_ = spinning
    table = sampler.load("corundum-steel")
    table = sampler.Table(with_spin_law(table.contents))
    velocity, omega, digest, (failed, _) = numba_example.run(table, particles, hits, roughness)
    assert failed == 0
    for program in programs.values():
        assert digest_of(program, file, particles, hits, roughness) == digest
    expected = follow(table, particles, hits, roughness)
    for found, wanted in zip((velocity, omega), expected, strict=True):
        error = np.abs(found - wanted).max(axis=1) / np.abs(wanted).max()
        # a last digit may turn a random choice, after which a particle goes another way
        assert np.mean(error > 1e-6) <= 1e-3
    other = numba_example.run(table, particles, hits, 0.9 * roughness)
    assert other[2] != digest


# a minute of compilation; test_rough.py compares C with Python draw by draw
@pytest.mark.study
def test_thousands_of_rebounds_from_rough_walls(numba_example, programs, spinning):
    check_all_languages(numba_example, programs, spinning, 500, 8, 0.2)


@pytest.mark.study  # what it says of a million, the test above says of thousands
def test_a_million_rebounds_from_rough_walls(numba_example, programs, spinning):
    check_all_languages(numba_example, programs, spinning, 50_000, 20, 0.1)
