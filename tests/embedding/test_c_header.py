"""The C header: clean under every compiler here, and the states of Python at every optimisation."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import toolchain
from known_vectors import TABLES, VECTORS, check_vectors
from sampler.formats.image import table_arrays, write_binary_table
from spin_vectors import write_spin_vectors

import sampler
from sampler.drawing.kernel import draw
from sampler.formats.binary_layout import CODES, HEADER_DTYPE, field_offset
from sampler.formats.hdf5 import read_table

HERE = Path(__file__).resolve().parent
IMPLEMENTATION = toolchain.IMPLEMENTATION


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
        {("gcc", "-O3"), ("g++", "-O3"), ("clang", "-O2")},
    ),
)
def test_vectors(compiler, level, tmp_path):
    # versions for three processors are compiled by gcc here, which is enough
    flags = [level] if compiler == "gcc" else [level, toolchain.ONE_COPY]
    program = toolchain.build(compiler, [HERE / "vectors.c"], tmp_path / "vectors", flags)
    check_vectors(program, 0)


NATIVE = "-O3 -march=native"
NATIVE_GNU = f"-O3 -march=native -std=gnu17 {toolchain.ONE_COPY}"
ONE_COPY = f"-O3 {toolchain.ONE_COPY}"
SANITIZED = "-O0 -fsanitize=address,undefined -fno-sanitize-recover=all"
READ_WHOLE = f"-O2 -DRBT_NO_MMAP {toolchain.ONE_COPY}"
STATIC = "-O2 -DRBT_API=static -Wno-unused-function"


@pytest.mark.parametrize(
    ("compiler", "flags"),
    chosen(
        ("gcc", "clang"),
        (NATIVE, NATIVE_GNU, ONE_COPY, SANITIZED, READ_WHOLE, STATIC),
        {
            ("gcc", NATIVE_GNU),
            ("gcc", SANITIZED),
            ("gcc", READ_WHOLE),
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
    flags = [*NATIVE_GNU.split(), "-ffp-contract=fast"]
    check_vectors(toolchain.build("gcc", [HERE / "vectors.c"], tmp_path / "vectors", flags), 0)


def test_vectors_where_nan_may_be_optimised_away(tmp_path):
    # all of -ffast-math but the flushing of the smallest numbers to zero, which are among the cases
    flags = "-O3 -ffinite-math-only -fassociative-math -freciprocal-math -fno-signed-zeros"
    flags = [*flags.split(), "-fno-trapping-math", toolchain.ONE_COPY]
    program = toolchain.build("gcc", [HERE / "vectors.c"], tmp_path / "vectors", flags)
    # on a rough wall a last digit may decide on another bounce
    for name in TABLES:
        lines = (VECTORS / f"{name}.txt").read_text(encoding="ascii").splitlines(keepends=True)
        smooth = [line for line in lines if not line.startswith("rough")]
        (tmp_path / f"{name}.txt").write_text("".join(smooth), encoding="ascii")
    check_vectors(program, 1e-5, tmp_path)


@pytest.mark.processor
@pytest.mark.parametrize(
    ("compiler", "flags"),
    chosen(
        ("gcc", "g++", "clang", "clang++"),
        ("-O0", "-O2", "-O3", NATIVE, SANITIZED, NATIVE_GNU, ONE_COPY),
        {("gcc", "-O3"), ("gcc", SANITIZED), ("g++", ONE_COPY), ("clang", "-O2")},
    ),
)
def test_vectors_of_particles_that_arrive_spinning(compiler, flags, tmp_path):
    flags = [f for f in flags.split() if not (compiler.endswith("++") and f.startswith("-std"))]
    program = toolchain.build(compiler, [HERE / "vectors.c"], tmp_path / "vectors", flags)
    image, vectors, cases = write_spin_vectors(tmp_path)
    assert toolchain.run(program, image, vectors, 0) == f"{cases} cases\n"


def test_a_wrong_vector_is_found(tmp_path):
    program = toolchain.build("gcc", [HERE / "vectors.c"], tmp_path / "vectors", ["-O3"])
    lines = (VECTORS / "full.txt").read_text(encoding="ascii").splitlines()
    last_digit = lines[0][: lines[0].rindex("p") - 1] + "9" + lines[0][lines[0].rindex("p") :]
    assert last_digit != lines[0]
    wrong = tmp_path / "wrong.txt"
    wrong.write_text(last_digit + "\n", encoding="ascii")
    assert "case 1 fails" in toolchain.run(program, VECTORS / "full.rbt", wrong, 0, status=1)


def build_main(folder, body, before="", flags=(), after=""):
    """Program with the header and a main function of these statements."""
    source = folder / "main.c"
    main = f"int main(int argc, char **argv)\n{{\n(void)argc; (void)argv;\n{body}}}\n"
    source.write_text(f"{before}{IMPLEMENTATION}#include <stdio.h>\n{after}{main}")
    return toolchain.build("gcc", [source], folder / "main", [*flags, toolchain.ONE_COPY])


def test_two_files_of_one_program(tmp_path):
    (tmp_path / "library.c").write_text(IMPLEMENTATION)
    (tmp_path / "user.c").write_text(
        '#include "rebound_sampler.h"\n#include <stdio.h>\n'
        "int main(void) { return puts(rbt_strerror(RBT_ERR_NO_MEMORY)) < 0; }\n"
    )
    sources = [tmp_path / "library.c", tmp_path / "user.c"]
    program = toolchain.build("gcc", sources, tmp_path / "two", [toolchain.ONE_COPY])
    assert toolchain.run(program) == "memory: not enough for this table\n"


def test_texts_of_all_codes(library):
    for code in CODES:
        assert library.rbt_strerror(code.number).decode() == code.text
    assert library.rbt_strerror(-99) == b"unknown code"


def test_header_of_the_file_is_that_of_python(tmp_path):
    names = HEADER_DTYPE.names
    offsets = "".join(f'    printf("%zu\\n", offsetof(rbti_header, {name}));\n' for name in names)
    program = build_main(tmp_path, f'{offsets}    printf("%zu\\n", sizeof(rbti_header));\n')
    expected = [field_offset(name) for name in names] + [HEADER_DTYPE.itemsize]
    assert [int(line) for line in toolchain.run(program).split()] == expected


def test_an_ignored_code_is_a_warning(tmp_path):
    with pytest.raises(AssertionError, match="warn_unused_result"):
        build_main(tmp_path, "    rbt_table *table;\n    rbt_open(argv[1], &table);\n")


@pytest.mark.parametrize("flags", ["-DRBT_NO_MMAP", "-O1"])
def test_memory_is_taken_and_returned_as_the_program_says(flags, tmp_path):
    before = """#include <stdlib.h>
static int quota, balance;
static void *take(size_t size) { return quota-- > 0 ? balance++, malloc(size) : NULL; }
static void give(void *memory) { balance -= memory != NULL; free(memory); }
#define RBT_MALLOC take
#define RBT_FREE give
"""
    body = """    for (int most = 0; most < 3; most++) {
        rbt_table *table;
        quota = most;
        const int code = rbt_open(argv[1], &table);
        rbt_close(table);
        printf("%d %d ", code, balance);
    }
"""
    program = build_main(tmp_path, body, before, [flags])
    needed = 2 if flags == "-DRBT_NO_MMAP" else 1  # the file and the table, or the table only
    expected = "".join("-12 0 " if most < needed else "0 0 " for most in range(3))
    assert toolchain.run(program, VECTORS / "full.rbt") == expected


@pytest.mark.processor
@pytest.mark.parametrize("name", TABLES)
@pytest.mark.parametrize("n", [1, 31, 32, 33, 1000])
def test_batches_have_the_bits_of_python(library, name, n):
    image = VECTORS / f"{name}.rbt"
    alpha1, speed, index, hit = toolchain.random_conditions(n)
    expected = np.zeros((n, 8))
    arrays = table_arrays(read_table(VECTORS / f"{name}.h5"))
    codes = [
        draw(arrays, a, v, np.uint64(5), i, h, row)
        for a, v, i, h, row in zip(alpha1, speed, index, hit, expected, strict=True)
    ]
    states, report = np.zeros((n, 6)), toolchain.Report()
    with toolchain.opened(library, image) as table:
        code = library.rbt_draw_batch(table, n, alpha1, speed, None, 5, index, hit, states, report)
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
        write_binary_table(image, replace(contents, speed_independent=free))
        states, report = np.zeros((n, 6)), toolchain.Report()
        with toolchain.opened(library, image) as table:
            given = speed[:4].copy(), None, 5, index, hit, states, report
            codes = [library.rbt_draw_batch(table, 4, alpha1, *given)]
            found[free] = states.copy(), report.clamped
            for k in range(4, n):
                given = speed[k : k + 1].copy(), None, 5, index, hit, states, None
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
        library.rbt_draw_batch(table, n, alphas, speeds, None, 5, index, hit, whole, report)
        for row in (bad, 60):  # only the first is told
            alphas[row], speeds[row] = alpha1, speed
        got = library.rbt_draw_batch(table, n, alphas, speeds, None, 5, index, hit, states, report)
    assert (got, report.row) == (code, bad)
    np.testing.assert_array_equal(states[:bad], whole[:bad])
    assert (states[bad:] == 7.0).all()


class Impacts:
    """Impacts at walls of all directions that move, one in five outside of the table."""

    def __init__(self, n, seed=2):
        rng = np.random.default_rng(seed)
        alpha1, speed, self.index, self.hit = toolchain.random_conditions(n, seed)
        self.normal = rng.standard_normal((n, 3))
        unit = self.normal / np.linalg.norm(self.normal, axis=1)[:, None]
        along = np.cross(unit, rng.standard_normal((n, 3)))
        along /= np.linalg.norm(along, axis=1)[:, None]
        self.wall_velocity = rng.standard_normal((n, 3))
        self.velocity = self.wall_velocity + speed[:, None] * (
            np.cos(alpha1)[:, None] * along - np.sin(alpha1)[:, None] * unit
        )
        self.velocity[::7] = (self.wall_velocity - 100.0 * self.normal)[::7]  # normal impacts
        self.half_size = rng.uniform(1e-6, 1e-3, n)
        self.new_velocity, self.omega = np.full((n, 3), 7.0), np.full((n, 3), 7.0)

    def batch(self, library, table, report, wall=True, velocity=None):
        """Code of `rbt_rebound_batch`."""
        velocity = self.velocity if velocity is None else velocity
        given = [velocity, self.normal, self.half_size, self.wall_velocity, self.index, self.hit]
        pointers = [array.ctypes.data for array in given]
        pointers[3] = pointers[3] if wall else None
        impacts, n = toolchain.Impacts(*pointers), len(self.hit)
        return library.rbt_rebound_batch(
            table, n, impacts, 5, self.new_velocity, self.omega, report
        )

    def one_by_one(self, library, table, wall=True):
        """Codes of `rbt_rebound`, velocities and angular velocities."""
        v, omega = np.full_like(self.velocity, 7.0), np.full_like(self.velocity, 7.0)
        codes = [
            library.rbt_rebound(
                table, self.velocity[k], self.normal[k], self.half_size[k],
                self.wall_velocity[k] if wall else None, None,
                5, int(self.index[k]), int(self.hit[k]), v[k], omega[k],
            )
            for k in range(len(self.hit))
        ]  # fmt: skip
        return np.array(codes), v, omega


@pytest.mark.parametrize("wall", [True, False])
@pytest.mark.parametrize("n", [0, 1, 31, 32, 33, 500])
def test_rebounds_of_a_batch_are_those_one_by_one_and_of_python(library, n, wall):
    impacts, report = Impacts(n), toolchain.Report()
    if not wall:
        impacts.velocity -= impacts.wall_velocity
    with toolchain.opened(library, VECTORS / "full.rbt") as table:
        code = impacts.batch(library, table, report, wall)
        codes, v, omega = impacts.one_by_one(library, table, wall)
        np.testing.assert_array_equal(impacts.new_velocity, v)
        np.testing.assert_array_equal(impacts.omega, omega)
        in_place = impacts.velocity.copy()
        impacts.new_velocity = in_place
        assert impacts.batch(library, table, None, wall, in_place) == code
        np.testing.assert_array_equal(in_place, v)
    clamped = np.flatnonzero(codes)
    assert (codes >= 0).all()
    assert code == (clamped.size > 0)
    assert (report.row, report.clamped) == (n, clamped.size)
    assert report.clamped_row == (clamped[0] if clamped.size else n)
    if n:
        python = sampler.load(VECTORS / "full.h5").rebound(
            impacts.velocity, impacts.normal, impacts.half_size, seed=5, index=impacts.index,
            hit=impacts.hit, wall_velocity=impacts.wall_velocity if wall else None,
        )  # fmt: skip
        # to the last digits of the C library's atan2, cos and sin
        np.testing.assert_allclose(v, python[0], rtol=0, atol=1e-11)
        np.testing.assert_allclose(omega, python[1], rtol=1e-11, atol=1e-4)


@pytest.mark.parametrize("bad", [0, 1, 31, 32, 50])
@pytest.mark.parametrize(
    ("name", "value", "code"),
    [
        ("velocity", np.nan, -1),
        ("wall_velocity", 1e4, -2),
        ("normal", 0.0, -4),
        ("half_size", 0.0, -5),
        ("half_size", 1e-310, -5),
    ],
)
def test_a_batch_of_rebounds_stops_before_the_first_error(library, bad, name, value, code):
    impacts, report = Impacts(70), toolchain.Report()
    if name == "wall_velocity":  # flees from the particle
        value = -1e4 * impacts.normal[bad]
    getattr(impacts, name)[bad] = value
    impacts.half_size[60] = -1.0  # only the first is reported
    with toolchain.opened(library, VECTORS / "full.rbt") as table:
        codes, v, omega = impacts.one_by_one(library, table)
        assert impacts.batch(library, table, report) == codes[bad] == code
    assert (report.row, report.clamped) == (bad, (codes[:bad] == 1).sum())
    np.testing.assert_array_equal(impacts.new_velocity[:bad], v[:bad])
    np.testing.assert_array_equal(impacts.omega[:bad], omega[:bad])
    assert (impacts.new_velocity[bad:] == 7.0).all()
    assert (impacts.omega[bad:] == 7.0).all()


def test_queries(library):
    with toolchain.opened(library, VECTORS / "plane.rbt") as table:
        columns = np.zeros(10, np.int32)
        assert library.rbt_components(table, columns) == 3
        assert columns.tolist() == [0, 1, 5, *[-1] * 7]
        assert library.rbt_components(table, None) == 3
        assert library.rbt_pair(table) == b"made-up"
        ends = np.zeros(2)
        library.rbt_alpha_range(table, ends)
        np.testing.assert_array_equal(ends, np.deg2rad([20.0, 70.0]))
        library.rbt_speed_range(table, ends)
        np.testing.assert_array_equal(ends, [50.0, 120.0])
