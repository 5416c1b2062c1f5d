"""Direct simulation in C: an object without Python gives the bits of `tablegen.DirectModel`."""

import ctypes
import subprocess
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import toolchain
from documents import ROOT

from tablegen.config.config import load_config
from tablegen.config.population import MeshShape, Population
from tablegen.simulation import exported_law
from tablegen.simulation.direct import model_without_warnings
from tablegen.simulation.direct_law import (
    VERSION,
    DirectLaw,
    DirectParts,
    LawRecord,
    PopulationRecord,
)
from tablegen.simulation.exported_law import HEADER, OBJECT, Target, direct_files

HERE = Path(__file__).resolve().parent
#: A table without a spin law, with which any population goes.
TABLE = ROOT / "tests" / "vectors" / "full.rbt"
PAIR = "made-up"

CONFIG = load_config("corundum-steel")
COULOMB = {"law": "coulomb", "static": 0.4, "dynamic": 0.3, "source": "a test"}
CORNERS = ((1.0, 0.1, 0.0), (-0.9, 0.5, 0.1), (-0.8, -0.6, 0.2), (0.1, 0.0, 0.7), (0.2, 0.1, -0.6))
MESHES = Population(meshes=(MeshShape(vertices=CORNERS),))

CASES = {
    "each shape": (CONFIG, CONFIG.population),
    "spheres": (load_config("kharaz-2001"), load_config("kharaz-2001").population),
    "a mesh": (CONFIG, MESHES),
    "coulomb": (CONFIG.with_changes({"pair": {"resistance": COULOMB}}), CONFIG.population),
}


#: Cases along three hits, and the roughness of their walls.
HITS = [(case, 0.0) for case in CASES] + [("each shape", 0.2)]


#: The kernel, which is the same for all cases.
KERNEL_TEXT = cache(exported_law.c_function_text)


@pytest.fixture(scope="session")
def objects(tmp_path_factory):
    """Write the object and the header of a case, and return their folder; each is made once."""
    parent, folders = tmp_path_factory.mktemp("direct"), {}

    def make(case):
        if case not in folders:
            config, population = CASES[case]
            parts = DirectParts.from_config(config, population)._replace(pair=PAIR)
            folders[case] = parent / case.replace(" ", "-")
            folders[case].mkdir()
            with pytest.MonkeyPatch.context() as patch:
                patch.setattr(exported_law, "c_function_text", KERNEL_TEXT)
                files = direct_files(parts, Target.of_this_machine())
            for name, data in files.items():
                (folders[case] / name).write_bytes(data)
        return folders[case]

    return make


@pytest.fixture(scope="session")
def built(objects, optimised, tmp_path_factory):
    """Build the program in C with the object of a case, and return it; each is built once."""
    common, programs = tmp_path_factory.mktemp("hits") / "hits.o", {}

    def build(case):
        if case not in programs:
            folder = objects(case)
            if not common.exists():  # the same for all cases
                flags = [f"-I{folder}", "-c", "-O1", toolchain.LINKED]
                toolchain.compile_with("gcc", [*flags, HERE / "direct_hits.c"], common)
            programs[case] = folder / "program"
            objects_of_case = [common, folder / OBJECT, optimised]
            toolchain.compile_with("gcc", [*objects_of_case, "-lm"], programs[case])
        return programs[case]

    return build


def impacts(n):
    """Impacts of n particles: velocities towards walls of random normals, and half-sizes."""
    rng = np.random.default_rng(8)
    normal, velocity = rng.standard_normal((2, n, 3))
    velocity *= -70.0 * np.sign(np.einsum("nk,nk->n", velocity, normal))[:, None]
    return np.column_stack([velocity, normal, rng.uniform(1e-6, 1e-4, n)])


def hits_in_c(program, given, tmp_path, roughness=0.0, batch=512):
    """Results of three hits by the program, (3, n, 10)."""
    (tmp_path / "impacts").write_bytes(given.tobytes())
    words = TABLE, tmp_path / "impacts", len(given), roughness, int(roughness > 0.0), batch
    toolchain.run(program, *words, tmp_path / "results")
    return np.fromfile(tmp_path / "results").reshape(3, len(given), 10)


def hits_in_python(case, given, roughness=0.0):
    """Results of the same hits by `DirectModel`."""
    model, n = model_without_warnings(*CASES[case]), len(given)
    velocity, normal, half_size = given[:, :3], given[:, 3:6], given[:, 6]
    omega, inertia, results = np.zeros((n, 3)), np.zeros(n), np.empty((3, n, 10))
    rough = {"roughness": roughness, "isotropic": True} if roughness else {}
    for hit in range(3):
        codes, works = np.empty(n, np.intc), np.empty((n, 2))
        turning = {"omega": omega, "inertia": inertia, "codes": codes, "works": works} | rough
        keys = {"seed": 7, "index": np.arange(n), "hit": hit}
        velocity, omega, inertia = model.rebound(velocity, normal, half_size, **turning, **keys)
        results[hit] = np.column_stack([velocity, omega, inertia, works, codes])
        x, y, z = velocity.T
        normal = np.column_stack([-x - 0.6 * y, -y + 0.6 * x, -z])
    return results


@pytest.mark.processor
@pytest.mark.parametrize(("case", "roughness"), HITS)
def test_rebounds_along_three_hits_have_the_bits_of_the_model(built, case, roughness, tmp_path):
    given = impacts(1100)
    in_c = hits_in_c(built(case), given, tmp_path, roughness)
    np.testing.assert_array_equal(in_c, hits_in_python(case, given, roughness))
    assert (in_c[..., 9] >= 0.0).all()


@pytest.mark.study
@pytest.mark.parametrize(("case", "roughness"), HITS)
def test_many_rebounds_have_the_bits_of_the_model(built, case, roughness, tmp_path):
    given = impacts(100_000)
    in_c = hits_in_c(built(case), given, tmp_path, roughness)
    np.testing.assert_array_equal(in_c, hits_in_python(case, given, roughness))


def test_batches_do_not_matter(built, tmp_path):
    given = impacts(1100)
    whole = hits_in_c(built("each shape"), given, tmp_path, 0.2, batch=1100)
    for batch in (1, 7, 513):
        part = hits_in_c(built("each shape"), given, tmp_path, 0.2, batch)
        np.testing.assert_array_equal(part, whole)


@pytest.mark.parametrize("compiler", ["gfortran", "g++"])
def test_other_languages_have_the_bits_of_the_model(compiler, objects, tmp_path):
    given, folder = impacts(300), objects("each shape")
    if compiler == "gfortran":
        sources = [HERE / "direct_hit.f90", folder / OBJECT]
        program = toolchain.build_fortran(sources, tmp_path)
    else:
        common, program = tmp_path / "hit.o", tmp_path / "program"
        flags = [*toolchain.QUICK, f"-I{folder}", "-c"]
        toolchain.compile_with(compiler, [*flags, HERE / "direct_hit.cpp"], common)
        toolchain.compile_with(compiler, [common, folder / OBJECT, "-lm"], program)
    (tmp_path / "impacts").write_bytes(given.tobytes())
    toolchain.run(program, TABLE, tmp_path / "impacts", len(given), tmp_path / "results")
    results = np.fromfile(tmp_path / "results").reshape(len(given), 10)
    np.testing.assert_array_equal(results, hits_in_python("each shape", given)[0])


def test_floating_point_traps_end_no_call(objects, optimised, tmp_path):
    """As in test_calls.py; the kernel by itself divides by zero."""
    folder, common = objects("each shape"), tmp_path / "traps.o"
    flags = ["-O1", "-DDIRECT", toolchain.LINKED, f"-I{folder}", "-c"]
    toolchain.compile_with("gcc", [*flags, HERE / "traps.c"], common)
    words = [common, folder / OBJECT, optimised, "-lm"]
    toolchain.compile_with("gcc", words, tmp_path / "traps")
    assert int(toolchain.run(tmp_path / "traps", TABLE)) > 5000


def test_the_command_writes_both_files(call, tmp_path, monkeypatch):
    monkeypatch.setattr(exported_law, "c_function_text", KERNEL_TEXT)
    folder = tmp_path / "direct"
    ended = call("tablegen", "export-direct", "corundum-steel", "--output", folder)
    assert (ended.status, ended.out) == (0, "")
    assert {path.name for path in folder.iterdir()} == {OBJECT, HEADER}
    assert b"corundum-steel\0" in (folder / OBJECT).read_bytes()
    assert "corundum-steel" in (folder / HEADER).read_text()


def test_the_program_needs_no_python(built):
    linked = subprocess.run(["ldd", built("each shape")], capture_output=True, text=True).stdout
    names = {line.split()[0].split(".")[0] for line in linked.splitlines()}
    assert not {name for name in names if "python" in name or "numba" in name or "llvm" in name}
    symbols = subprocess.run(
        ["nm", "--undefined-only", built("each shape").parent / OBJECT],
        capture_output=True,
        text=True,
        check=True,
    ).stdout.split()
    assert {name for name in symbols if name != "U"} <= {"asin", "fma", "memset", "pow", "sqrt"}


def test_an_object_that_does_not_go_with_the_table_has_a_code(library, shipped_file):
    """One of another version of the header, of another pair, or without a shape of the table."""
    record = DirectLaw.from_config(CONFIG)._record

    def code():
        return library.rbt_use_direct(table, ctypes.byref(record))

    with toolchain.opened(library, shipped_file) as table:
        assert library.rbt_use_direct(table, None) == -1
        record.version += 1
        assert code() == -13
        record.version -= 1
        record.population.n_shapes -= 1  # no tetrahedra
        assert code() == -14
        record.population.n_shapes += 1
        assert code() == 0
    with toolchain.opened(library, TABLE) as table:
        assert code() == -14


def test_the_record_is_that_of_the_header(tmp_path):
    """Places of the fields in C and in Python."""
    records = {"rbt_population": PopulationRecord, "rbt_direct_law": LawRecord}
    places = [
        (f"offsetof({kind}, {field[0]})", getattr(record, field[0]).offset)
        for kind, record in records.items()
        for field in record._fields_
    ]
    places += [(f"sizeof({kind})", ctypes.sizeof(r)) for kind, r in records.items()]
    places += [("RBT_DIRECT_VERSION", VERSION), ("RBT_DIRECT_VALUES", 12)]
    checks = "".join(f'_Static_assert({word} == {number}, "");\n' for word, number in places)
    source = tmp_path / "record.c"
    source.write_text(f'#include "rebound_sampler.h"\n{checks}')
    command = ["gcc", f"-I{toolchain.INCLUDE}", "-fsyntax-only", source]
    subprocess.run([toolchain.require("gcc"), *command[1:]], check=True)
