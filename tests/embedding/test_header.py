"""The C header as programs use it: several files, codes and their texts, memory, older tables."""

from pathlib import Path

import numpy as np
import pytest
import toolchain
from known_vectors import VECTORS

import sampler
from sampler.errors import CODES

IMPLEMENTATION = toolchain.IMPLEMENTATION


def build_main(folder, body, before="", flags=()):
    source = folder / "main.c"
    main = f"int main(int argc, char **argv)\n{{\n(void)argc; (void)argv;\n{body}}}\n"
    source.write_text(f"{before}{IMPLEMENTATION}#include <stdio.h>\n{main}")
    return toolchain.build("gcc", [source], folder / "main", flags)


def test_two_files_of_one_program(tmp_path):
    (tmp_path / "library.c").write_text(IMPLEMENTATION)
    (tmp_path / "user.c").write_text(
        '#include "rebound_sampler.h"\n#include <stdio.h>\n'
        "int main(void) { return puts(rbt_strerror(RBT_ERR_NO_MEMORY)) < 0; }\n"
    )
    sources = [tmp_path / "library.c", tmp_path / "user.c"]
    program = toolchain.build("gcc", sources, tmp_path / "two")
    assert toolchain.run(program) == "memory: not enough for this table\n"


def test_texts_of_all_codes(library):
    for code in CODES:
        assert library.rbt_strerror(code.number).decode() == code.text
    assert library.rbt_strerror(-99) == b"unknown code"


def test_an_ignored_code_is_a_warning(tmp_path):
    ignored = "rbt_open(argv[1], NULL)", "rbt_grains(NULL, 0, 0, NULL, NULL, NULL)"
    ignored += "rbt_sample(NULL, 0, NULL, 0, NULL, NULL)", "rbt_rebound(NULL, 0, NULL, 0, NULL)"
    for call in ignored:
        with pytest.raises(AssertionError, match="warn_unused_result"):
            build_main(tmp_path, f"    {call};\n")


@pytest.mark.parametrize("flags", ["-DRBT_NO_MMAP", "-O0"])
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
    expected = "".join("-22 0 " if most < needed else "0 0 " for most in range(3))
    assert toolchain.run(program, VECTORS / "full.rbt") == expected


def test_queries(library):
    columns, covered = np.zeros(10, np.int32), np.zeros((4, 2))
    with toolchain.opened(library, VECTORS / "plane.rbt") as table:
        assert library.rbt_components(table, columns) == 3
        assert columns.tolist() == [0, 1, 5, *[-1] * 7]
        assert library.rbt_components(table, None) == 3
        assert library.rbt_pair(table) == b"made-up"
        assert library.rbt_covered(table, covered) == 0
        np.testing.assert_array_equal(covered[:2], [np.deg2rad([20.0, 70.0]), [50.0, 120.0]])
    for name, spin, valid in (("spin", 1, [50.0, 300.0]), ("full", 0, [0.0, 1e300])):
        with toolchain.opened(library, VECTORS / f"{name}.rbt") as table:
            assert library.rbt_has_spin_law(table) == spin
            library.rbt_covered(table, covered)
            assert (covered[2, 1] > 0.0) == spin
            assert covered[3].tolist() == valid


def test_tilt_of_a_profile(library):
    tilt = np.full(1, 7.0)
    for lengths in ((2e-6, 3e-6, 2e-5, 1e-6), (2e-6, 3e-6, 2e-5, 1.0), (0.0, 0.0, 1.0, 1.0)):
        assert library.rbt_wall_tilt(*lengths, tilt) == 0
        assert tilt[0] == sampler.wall_tilt(*lengths)
    tilt[0] = 7.0
    for lengths in ((np.nan, 1.0, 9.0, 1.0), (1.0, 1.0, 9.0, np.inf)):
        assert library.rbt_wall_tilt(*lengths, tilt) == -2
    for lengths in ((-1.0, 1.0, 9.0, 1.0), (1.0, 1.0, 0.0, 1.0), (25.0, 1.0, 10.0, 5.0)):
        assert library.rbt_wall_tilt(*lengths, tilt) == -7
    assert tilt[0] == 7.0


def test_memory_that_is_not_aligned(library):
    good, table = (VECTORS / "full.rbt").read_bytes(), toolchain.ctypes.c_void_p()
    data = np.zeros(len(good) + 128, np.uint8)
    start = -data.ctypes.data % 64
    for shift, code in ((0, 0), (8, -30)):
        place = data[start + shift : start + shift + len(good)]
        place[:] = np.frombuffer(good, np.uint8)
        got = library.rbt_open_memory(place.ctypes.data, len(good), toolchain.ctypes.byref(table))
        assert got == code
        library.rbt_close(table)


def test_a_table_that_was_read_is_not_the_file(tmp_path):
    """Without memory maps a file may be cut short while it is open."""
    (tmp_path / "library.c").write_text(IMPLEMENTATION)
    library = toolchain.load_library(tmp_path / "library.c", ["-DRBT_NO_MMAP"])
    path = tmp_path / "t.rbt"
    path.write_bytes((VECTORS / "full.rbt").read_bytes())
    states, alpha1, speed = np.zeros((2, 6)), np.full(1, 0.7), np.full(1, 100.0)
    index, hit = np.ones(1, np.uint64), np.ones(1, np.uint32)
    where = [array.ctypes.data for array in (alpha1, speed, index, hit)]
    given = toolchain.Conditions(*where[:2], None, None, *where[2:])
    with toolchain.opened(library, path) as table:
        for state in states:
            assert library.rbt_sample(table, 1, given, 5, state, None) == 0
            path.write_bytes(bytes(100))
    np.testing.assert_array_equal(*states)
    assert toolchain.open_code(library, Path("/none"))[0] == -20


WALL_F90 = """
program wall
  use, intrinsic :: iso_c_binding, only: c_double
  use rebound_sampler
  implicit none
  type(rbt_table) :: table
  real(c_double), parameter :: v(3) = [9, -1, 0], n(3) = [0, 2, 0], still(3) = 0
  character(len=200) :: path
  call get_command_argument(1, path)
  if (rbt_open(path, table) /= RBT_OK) error stop "no table"
  print *, rbt_half_size(2.0_c_double, [1.0_c_double, 0.8_c_double, 0.7_c_double])
  print *, rbt_mean_half_size(table, 2.0_c_double)
  print *, rbt_deposits(v, n, 1.01_c_double, still), rbt_deposits(v, n, 0.99_c_double, still)
end program wall
"""


def test_fortran_knows_sizes_and_deposits(tmp_path):
    (tmp_path / "wall.f90").write_text(WALL_F90)
    program = toolchain.build_fortran([tmp_path / "wall.f90"], tmp_path)
    found = [float(x) for x in toolchain.run(program, VECTORS / "spin.rbt").split()]
    table = sampler.load(VECTORS / "spin.h5")
    sizes = sampler.half_size(2.0, (1, 0.8, 0.7)), table.mean_half_size(2.0)
    np.testing.assert_allclose(found, [*sizes, 1.0, 0.0], rtol=1e-14)
