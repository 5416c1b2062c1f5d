"""The C header as programs use it: several files, codes and their texts, memory, older tables."""

import ctypes
import platform
import re
import subprocess
import sys

import numpy as np
import pytest
import toolchain
from known_vectors import VECTORS

from sampler.errors import CODES, FLAGS

IMPLEMENTATION = toolchain.IMPLEMENTATION


def build_main(folder, body, before="", flags=()):
    source = folder / "main.c"
    main = f"int main(int argc, char **argv)\n{{\n(void)argc; (void)argv;\n{body}}}\n"
    source.write_text(f"{before}{IMPLEMENTATION}#include <stdio.h>\n{main}")
    return toolchain.build("gcc", [source], folder / "main", [*toolchain.QUICK, *flags])


def test_two_files_of_one_program(tmp_path):
    (tmp_path / "library.c").write_text(IMPLEMENTATION)
    (tmp_path / "user.c").write_text(
        '#include "rebound_sampler.h"\n#include <stdio.h>\n'
        "int main(void) { return puts(rbt_strerror(RBT_ERR_NO_MEMORY)) < 0; }\n"
    )
    sources = [tmp_path / "library.c", tmp_path / "user.c"]
    program = toolchain.build("gcc", sources, tmp_path / "two", toolchain.QUICK)
    assert toolchain.run(program) == "there is not enough memory for this table\n"


@pytest.mark.apart
@pytest.mark.parametrize(
    ("compiler", "processor"), [("gcc", "haswell"), ("gcc", "skylake-avx512"), ("g++", "native")]
)
def test_it_compiles_for_one_processor(compiler, processor, tmp_path):
    """gcc inlines no function that may use more features of the processor than its caller."""
    if processor != "native" and platform.machine() != "x86_64":
        pytest.skip("-march of x86-64")
    source = tmp_path / "implementation.c"
    source.write_text(IMPLEMENTATION)
    language = ["-x", "c++"] if compiler == "g++" else []
    # the copies for wide vectors, which other tests leave out
    flags = [*language, "-O0", "-URBT_NO_CLONES", f"-march={processor}", "-c", source]
    toolchain.compile_with(compiler, flags, tmp_path / "implementation.o")


#: Macros of windows.h, X11, Qt, Fluent, R, Arduino, macOS, Boost and old systems, and of users.
MACROS = """
near far NEAR FAR min max small interface ERROR IN OUT OPTIONAL CONST VOID TRUE FALSE BOOL pascal
cdecl CALLBACK DELETE IGNORE NO_ERROR STRICT THIS PASSTHROUGH ABSOLUTE RELATIVE DOMAIN OVERFLOW
UNDERFLOW hyper None Status Bool True False Success Complex signals slots emit foreach real SQR ABS
MIN MAX swap verify require nil likely unlikely unix linux I PI EPS ZERO ONE U V W N F C B0 DIM X Y
Z bit sq
"""
#: Those that take arguments may also be names of ours that are not called.
CALLED_MACROS = ("check", "major", "minor", "error", "length", "sign", "index")


@pytest.mark.parametrize(("compiler", "flag"), [("gcc", "-Wundef"), ("g++", "-Wuseless-cast")])
def test_macros_of_other_headers_meet_no_name(compiler, flag, tmp_path):
    lines = ["fcntl.h", "math.h", "stddef.h", "stdint.h", "stdio.h", "stdlib.h", "string.h"]
    lines = [f"#include <{name}>" for name in (*lines, "sys/mman.h", "sys/stat.h", "unistd.h")]
    for name in MACROS.split():
        lines += [f"#undef {name}", f"#define {name} @ no code @"]
    lines += [f"#undef {name}\n#define {name}(...) @ no code @" for name in CALLED_MACROS]
    source = tmp_path / "main.c"
    source.write_text("\n".join([*lines, IMPLEMENTATION]))
    flags = ["-fsyntax-only", "-Wno-pedantic", flag]
    toolchain.build(compiler, [source], tmp_path / "main.o", flags)


def test_the_library_of_python_calls_its_own_functions(tmp_path):
    """A plugin with another version of the header was loaded first, for all to see."""
    names = ("gas_torque", "spin_after", "half_size", "mean_inertia", "critical_speed", "deposits")
    functions = (f"int rbt_{name}(void) {{ abort(); }}" for name in (*names, "wall_tilt"))
    source = tmp_path / "plugin.c"
    source.write_text("\n".join(["#include <stdlib.h>", *functions, ""]))
    flags = ["-shared", "-fPIC", "-Wno-strict-prototypes"]
    plugin = toolchain.build("gcc", [source], tmp_path / "plugin.so", flags)
    script = f"""
import ctypes
ctypes.CDLL({str(plugin)!r}, ctypes.RTLD_GLOBAL)
import sampler
spheres, grain = sampler.load("kharaz-2001"), [4, 1.0, 1.0]
sampler.spin_after([0.0, 0.0, 1.0], 1e-3, 1e-22, 2e-5, 1.2, 1.8e-5)
sampler.gas_torque([0.0, 0.0, 1.0], 2e-5, 1.2, 1.8e-5)
sampler.half_size(spheres, 2e-5, grain), sampler.mean_inertia(spheres, grain)
sampler.deposits([0.0, -1.0, 0.0], [0.0, 1.0, 0.0], 0.1)
sampler.critical_speed(1e-5, 2650.0, 95e9, 0.1, 200e9, 0.3)
print(sampler.wall_tilt(2.0, 2.5, 50.0, 60.0).round(3))
"""
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert done.stdout == "0.08\n"


def test_a_plugin_of_several_files_keeps_its_functions(tmp_path):
    (tmp_path / "library.c").write_text(IMPLEMENTATION)
    (tmp_path / "user.c").write_text(
        '#include "rebound_sampler.h"\nconst char *text(void);\n'
        "const char *text(void) { return rbt_strerror(RBT_OK); }\n"
    )
    sources = [tmp_path / "library.c", tmp_path / "user.c"]
    hidden = '-DRBT_API=extern __attribute__((visibility("hidden")))'
    flags = ["-shared", "-fPIC", hidden, *toolchain.QUICK]
    plugin = ctypes.CDLL(toolchain.build("gcc", sources, tmp_path / "plugin.so", flags))
    plugin.text.restype = ctypes.c_char_p
    assert plugin.text() == b"no error"
    assert not hasattr(plugin, "rbt_strerror")


def test_texts_of_all_codes(library):
    for code in CODES:
        assert library.rbt_strerror(code.number).decode() == code.text
    assert library.rbt_strerror(-99) == library.rbt_strerror(16) == b"unknown code"


def test_the_text_of_a_sum_names_every_flag(library):
    texts = {code.number: code.text for code in CODES if code.number in FLAGS.values()}
    assert len(texts) == 4
    for total in range(1, 16):
        named = "; ".join(text for flag, text in texts.items() if total & flag)
        assert library.rbt_strerror(total).decode() == named


def test_an_ignored_code_is_a_warning(tmp_path):
    ignored = "rbt_open(argv[1], NULL)", "rbt_grains(NULL, 0, 0, NULL, NULL, NULL)"
    ignored += "rbt_sample(NULL, 0, NULL, 0, NULL, NULL)", "rbt_rebound(NULL, 0, NULL, 0, NULL)"
    with pytest.raises(AssertionError) as error:
        build_main(tmp_path, "".join(f"    {call};\n" for call in ignored))
    assert str(error.value).count("warn_unused_result") == 4


@pytest.mark.parametrize("flags", [["-DRBT_NO_MMAP"], []])
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
    program = build_main(tmp_path, body, before, flags)
    needed = 2 if flags else 1  # the file and the table, or the table only
    expected = "".join("-17 0 " if most < needed else "0 0 " for most in range(3))
    assert toolchain.run(program, VECTORS / "full.rbt") == expected


def test_queries(library):
    columns, covered = np.zeros(10, np.int32), np.zeros((4, 2))
    with toolchain.opened(library, VECTORS / "plane.rbt") as table:
        assert library.rbt_variables(table, columns) == 3
        assert columns.tolist() == [0, 1, 5, *[-1] * 7]
        assert library.rbt_variables(table, None) == 3
        assert library.rbt_pair(table) == b"made-up"
        assert library.rbt_covered(table, covered) == 0
        np.testing.assert_array_equal(covered[:2], [np.deg2rad([20.0, 70.0]), [50.0, 120.0]])
    for name, spin, valid in (("spin", 1, [50.0, 300.0]), ("full", 0, [0.0, 1e300])):
        with toolchain.opened(library, VECTORS / f"{name}.rbt") as table:
            assert library.rbt_has_spin_law(table) == spin
            library.rbt_covered(table, covered)
            assert (covered[2, 1] > 0.0) == spin
            assert covered[3].tolist() == valid


def test_memory_that_is_not_aligned(library):
    good, table = (VECTORS / "full.rbt").read_bytes(), toolchain.ctypes.c_void_p()
    data = np.zeros(len(good) + 128, np.uint8)
    start = -data.ctypes.data % 64
    for shift, code in ((0, 0), (8, -25)):
        place = data[start + shift : start + shift + len(good)]
        place[:] = np.frombuffer(good, np.uint8)
        got = library.rbt_open_memory(place.ctypes.data, len(good), toolchain.ctypes.byref(table))
        assert got == code
        library.rbt_close(table)


SECTIONS = sorted((toolchain.INCLUDE / "src").glob("*.h"))


def test_the_map_names_each_section():
    prelude = (toolchain.INCLUDE / "src" / "prelude.h").read_text(encoding="utf-8")
    table = prelude.partition("What to change for what:")[2].partition("*/")[0]
    named = set(re.findall(r"\b\w+\b", " ".join(re.findall(r" {3,}(\w.*)", table))))
    others = {"public", "end", "queries", "nodes", "spin_draw", "sample", "rebound", "frame"}
    assert {path.stem for path in SECTIONS} - others <= named
