"""The C header: clean under every compiler here, and the states of Python at every optimisation."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import toolchain

from sampler.drawing.kernel import draw
from sampler.formats.binary import read_image, write_image
from sampler.formats.binary_layout import HEADER_DTYPE, REASONS, field_offset
from sampler.formats.hdf5 import read_table

HERE = Path(__file__).resolve().parent
VECTORS = HERE.parent / "vectors"
TABLES = sorted(path.stem for path in VECTORS.glob("*.rbt"))
IMPLEMENTATION = '#define REBOUND_SAMPLER_IMPLEMENTATION\n#include "rebound_sampler.h"\n'
HEADER = toolchain.INCLUDE / "rebound_sampler.h"


def check_vectors(program, tolerance):
    for name in TABLES:
        files = VECTORS / f"{name}.rbt", VECTORS / f"{name}.txt"
        cases = len(files[1].read_text(encoding="ascii").splitlines())
        assert toolchain.run(program, *files, tolerance) == f"{cases} cases\n"


def chosen(compilers, flags, quick):
    """Combinations of compilers and flags, all but the ``quick`` ones as a study, for the time."""
    return [
        pytest.param(compiler, flag, marks=() if (compiler, flag) in quick else pytest.mark.study)
        for compiler in compilers
        for flag in flags
    ]


@pytest.mark.parametrize(
    ("compiler", "level"),
    chosen(
        ("gcc", "g++", "clang", "clang++"),
        ("-O0", "-O2", "-O3"),
        {("gcc", "-O0"), ("gcc", "-O3"), ("g++", "-O2"), ("clang", "-O2"), ("clang++", "-O2")},
    ),
)
def test_vectors(compiler, level, tmp_path):
    program = toolchain.build(compiler, [HERE / "vectors.c"], tmp_path / "vectors", [level])
    check_vectors(program, 0)


NATIVE = "-O3 -march=native"
NATIVE_GNU = "-O3 -march=native -std=gnu17"
ONE_COPY = "-O3 -DRBT_NO_CLONES"
SANITIZED = "-O2 -fsanitize=address,undefined -fno-sanitize-recover=all"
READ_WHOLE = "-O2 -DRBT_NO_MMAP"
STATIC = "-O2 -DRBT_API=static -Wno-unused-function"


@pytest.mark.parametrize(
    ("compiler", "flags"),
    chosen(
        ("gcc", "clang"),
        (NATIVE, NATIVE_GNU, ONE_COPY, SANITIZED, READ_WHOLE, STATIC),
        {
            ("gcc", NATIVE_GNU),
            ("gcc", ONE_COPY),
            ("gcc", SANITIZED),
            ("gcc", READ_WHOLE),
            ("clang", NATIVE),
            ("clang", STATIC),
        },
    ),
)
def test_vectors_with_other_flags(compiler, flags, tmp_path):
    source = [HERE / "vectors.c"]
    program = toolchain.build(compiler, source, tmp_path / "vectors", flags.split())
    check_vectors(program, 0)


@pytest.mark.processor
def test_vectors_where_gcc_may_fuse_multiplications_and_additions(tmp_path):
    flags = ["-O3", "-march=native", "-std=gnu17", "-ffp-contract=fast"]
    check_vectors(toolchain.build("gcc", [HERE / "vectors.c"], tmp_path / "vectors", flags), 0)


def test_vectors_where_nan_may_be_optimised_away(tmp_path):
    # all of -ffast-math but the flushing of the smallest numbers to zero, which are among the cases
    flags = "-O3 -ffinite-math-only -fassociative-math -freciprocal-math -fno-signed-zeros"
    flags = [*flags.split(), "-fno-trapping-math"]
    program = toolchain.build("gcc", [HERE / "vectors.c"], tmp_path / "vectors", flags)
    check_vectors(program, 1e-5)


def test_a_wrong_vector_is_found(tmp_path):
    program = toolchain.build("gcc", [HERE / "vectors.c"], tmp_path / "vectors", ["-O0"])
    lines = (VECTORS / "full.txt").read_text(encoding="ascii").splitlines()
    last_digit = lines[0][: lines[0].rindex("p") - 1] + "9" + lines[0][lines[0].rindex("p") :]
    assert last_digit != lines[0]
    wrong = tmp_path / "wrong.txt"
    wrong.write_text(last_digit + "\n", encoding="ascii")
    assert "case 1 fails" in toolchain.run(program, VECTORS / "full.rbt", wrong, 0, status=1)


def test_compiles_for_a_device(tmp_path):
    source = tmp_path / "device.cu"
    source.write_text(
        IMPLEMENTATION
        + "__global__ void kernel(rbt_table table, double *state)\n"
        + "{\n    rbt_draw(&table, 0.5, 100.0, 1, threadIdx.x, 0, state + 6 * threadIdx.x);\n}\n"
    )
    toolchain.compile_with("nvcc", ["-c", source, "-o", tmp_path / "device.o"])


def test_two_files_of_one_program(tmp_path):
    (tmp_path / "library.c").write_text(IMPLEMENTATION)
    (tmp_path / "user.c").write_text(
        '#include "rebound_sampler.h"\n#include <stdio.h>\n'
        "int main(void) { return puts(rbt_strerror(RBT_FORMAT)) < 0; }\n"
    )
    sources = [tmp_path / "library.c", tmp_path / "user.c"]
    program = toolchain.build("gcc", sources, tmp_path / "two")
    assert toolchain.run(program) == f"{REASONS[-14]}\n"


def test_codes_and_reasons_of_python(tmp_path):
    codes = dict(re.findall(r"#define RBT_(\w+) \(?(-?\d+)\)?", HEADER.read_text()))
    codes = {name: int(code) for name, code in codes.items() if int(code) <= -10}
    assert sorted(codes.values()) == sorted(REASONS)
    calls = "".join(f"    puts(rbt_strerror({code}));\n" for code in REASONS)
    source = tmp_path / "reasons.c"
    source.write_text(f"{IMPLEMENTATION}#include <stdio.h>\nint main(void)\n{{\n{calls}}}\n")
    program = toolchain.build("gcc", [source], tmp_path / "reasons")
    assert toolchain.run(program).splitlines() == list(REASONS.values())


def test_header_of_the_file_is_that_of_python(tmp_path):
    names = HEADER_DTYPE.names
    offsets = "".join(f'    printf("%zu\\n", offsetof(rbti_header, {name}));\n' for name in names)
    source = tmp_path / "offsets.c"
    source.write_text(
        f"{IMPLEMENTATION}#include <stdio.h>\nint main(void)\n{{\n{offsets}"
        '    printf("%zu\\n", sizeof(rbti_header));\n}\n'
    )
    program = toolchain.build("gcc", [source], tmp_path / "offsets")
    expected = [field_offset(name) for name in names] + [HEADER_DTYPE.itemsize]
    assert [int(line) for line in toolchain.run(program).split()] == expected


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    folder = tmp_path_factory.mktemp("library")
    (folder / "library.c").write_text(IMPLEMENTATION)
    return toolchain.load_library(folder / "library.c", ["-O3", "-march=native"])


@pytest.mark.processor
@pytest.mark.parametrize("name", TABLES)
@pytest.mark.parametrize("n", [1, 31, 32, 33, 1000])
def test_batches_have_the_bits_of_python(library, name, n):
    image = VECTORS / f"{name}.rbt"
    alpha1, speed, index, hit = toolchain.random_conditions(n)
    expected = np.zeros((n, 8))
    arrays = read_image(image).arrays
    codes = [
        draw(arrays, a, v, np.uint64(5), i, h, row)
        for a, v, i, h, row in zip(alpha1, speed, index, hit, expected, strict=True)
    ]
    states, report = np.zeros((n, 6)), toolchain.Report()
    with toolchain.opened(library, image) as table:
        code = library.rbt_draw_batch(table, n, alpha1, speed, 5, index, hit, states, report)
    clamped = np.flatnonzero(codes)
    assert code == (clamped.size > 0)
    assert (report.row, report.clamped) == (n, clamped.size)
    assert report.clamped_row == (clamped[0] if clamped.size else n)
    np.testing.assert_array_equal(states, expected[:, :6])


def test_no_speed_is_outside_where_rebounds_do_not_depend_on_it(library, tmp_path):
    contents = read_table(VECTORS / "full.h5")
    speed = np.array([1e-6, 5.0, 60.0, 1e5, 0.0, np.nan, np.inf])
    n = len(speed)
    alpha1, index, hit = np.full(n, 1.0), np.arange(n, dtype=np.uint64), np.zeros(n, np.uint32)
    found = {}
    for free in (False, True):
        image = tmp_path / f"{free}.rbt"
        write_image(image, replace(contents, speed_independent=free))
        states, report = np.zeros((n, 6)), toolchain.Report()
        with toolchain.opened(library, image) as table:
            given = speed[:4].copy(), 5, index, hit, states, report
            codes = [library.rbt_draw_batch(table, 4, alpha1, *given)]
            found[free] = states.copy(), report.clamped
            for k in range(4, n):
                given = speed[k : k + 1].copy(), 5, index, hit, states, None
                codes.append(library.rbt_draw_batch(table, 1, alpha1, *given))
        assert codes == [0 if free else 1, -3, -1, -1]
    np.testing.assert_array_equal(found[True][0], found[False][0])
    assert (found[True][1], found[False][1]) == (0, 3)


@pytest.mark.parametrize("bad", [0, 1, 31, 32, 50])
@pytest.mark.parametrize(
    ("alpha1", "speed", "code"), [(np.nan, 100.0, -1), (-1.0, 100.0, -2), (0.5, 0.0, -3)]
)
def test_a_batch_stops_before_the_first_error(library, bad, alpha1, speed, code):
    n = 70
    alphas, speeds, index, hit = toolchain.random_conditions(n)
    states, whole, report = np.full((n, 6), 7.0), np.zeros((n, 6)), toolchain.Report()
    with toolchain.opened(library, VECTORS / "full.rbt") as table:
        library.rbt_draw_batch(table, n, alphas, speeds, 5, index, hit, whole, report)
        for row in (bad, 60):  # only the first is told
            alphas[row], speeds[row] = alpha1, speed
        got = library.rbt_draw_batch(table, n, alphas, speeds, 5, index, hit, states, report)
    assert (got, report.row) == (code, bad)
    np.testing.assert_array_equal(states[:bad], whole[:bad])
    assert (states[bad:] == 7.0).all()


def test_queries(library):
    with toolchain.opened(library, VECTORS / "plane.rbt") as table:
        columns = np.zeros(8, np.int32)
        assert library.rbt_components(table, columns) == 3
        assert columns.tolist() == [0, 1, 5, -1, -1, -1, -1, -1]
        assert library.rbt_components(table, None) == 3
        assert library.rbt_pair(table) == b"made-up"
        ends = np.zeros(2)
        library.rbt_alpha_range(table, ends)
        np.testing.assert_array_equal(ends, np.deg2rad([20.0, 70.0]))
        library.rbt_speed_range(table, ends)
        np.testing.assert_array_equal(ends, [50.0, 120.0])
