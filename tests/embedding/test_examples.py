"""The particle loops in C, Fortran, numba and for a GPU do the same, on any number of threads."""

import importlib.util
import re

import pytest
import toolchain
from documents import ROOT
from small_tables import plane

import sampler
from sampler.formats.image import write_binary_table

WORDS = re.compile(
    r"(mean velocity along the plates +\S+ m/s, mean spin +\S+ rad/s, failed 0)\n"
    r" *[0-9.E+e]+ rebounds per second[^\n]*\n"
    r"digest ([0-9A-F]{16})\n(.*)",
    re.S,
)
SHIPPED = sampler.load("corundum-steel")


@pytest.fixture(scope="module")
def numba_loop():
    """The function `run` of docs/examples/particles.py."""
    path = ROOT / "docs" / "examples" / "particles.py"
    spec = importlib.util.spec_from_file_location("particles", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.run


@pytest.fixture(scope="module")
def tables(tmp_path_factory):
    """Tables by name, with their files: with a spin law, and without it and of low speeds."""
    folder, found = tmp_path_factory.mktemp("tables"), {}
    for name, table in {"shipped": SHIPPED, "plane": sampler.Table(plane())}.items():
        write_binary_table(folder / f"{name}.rbt", table.contents)
        found[name] = table, folder / f"{name}.rbt"
    return found


@pytest.fixture(scope="module", params=["c", "f90", "cu"])
def program(request, tmp_path_factory):
    """The loop of a language; that for a GPU in loops of the host."""
    folder, flags = tmp_path_factory.mktemp("program"), ["-O2", "-ffp-contract=off", "-fopenmp"]
    source = toolchain.INCLUDE / f"particles.{request.param}"
    if request.param == "f90":
        source = toolchain.INCLUDE.parent / "fortran" / "particles.f90"
        return toolchain.build_fortran([source], folder, flags)
    if request.param == "cu":
        return toolchain.build_on_host(source, folder / "particles", ["-O1"])
    return toolchain.build("gcc", [source], folder / "particles", [*flags, toolchain.ONE_COPY])


@pytest.mark.parametrize(
    ("name", "particles", "hits", "roughness"),
    [
        ("shipped", 2000, 6, 0.0),
        ("shipped", 500, 4, 0.2),
        ("plane", 2000, 4, 0.0),
        pytest.param("shipped", 50_000, 20, 0.1, marks=pytest.mark.study),
    ],
)
def test_particles(numba_loop, program, tables, name, particles, hits, roughness):
    table, file = tables[name]
    velocity, omega, digest, (failed, clamped) = numba_loop(table, particles, hits, roughness)
    assert failed == 0
    assert clamped > 0 or name != "plane"
    for threads in (1, 2):
        arguments = file, particles, hits, roughness
        printed = toolchain.run(program, *arguments, OMP_NUM_THREADS=str(threads))
        means, found, outside = WORDS.fullmatch(printed).groups()
        assert int(found, 16) == digest
        along, spin = re.findall(r"(\S+) (?:m/s|rad/s)", means)
        assert float(along) == pytest.approx(velocity[:, 0].mean(), abs=6e-4)
        assert float(spin) == pytest.approx(omega[:, 2].mean(), rel=6e-4)
        assert outside.startswith(f"{clamped} rebounds lay outside") == (clamped > 0)
