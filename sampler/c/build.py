"""Put the C header together from its sections, and compile it to the library that Python loads.

    python sampler/c/build.py

`rebound_sampler.h` has all sections of `src/`, one after another, so that a program in C includes
one file. `library.c` adds what Python alone needs.

The compiler is that of the variable CC. If CC is not set, it is gcc, clang or cc, and if none of
these is installed, that of the ``ziglang`` wheel. Flags of the variable CFLAGS come last. No Python
headers are needed.

If the compiler can do it, the hot loops are compiled for several levels of x86-64. The processor
chooses one of them at run time, and all give the same bits. The zig compiler has its own sines and
logarithms, so the last digits of rebounds from rough walls and of exactly normal impacts differ.
"""

import os
import shlex
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

HERE = Path(__file__).resolve().parent
HEADER = HERE / "rebound_sampler.h"
SOURCE = HERE / "library.c"
LIBRARY = HERE.parent / "librebound.so"

#: Sections of the header, in their order.
SECTIONS = (
    "public",
    "prelude",
    "words",
    "nodes",
    "sphere",
    "grains",
    "spin",
    "conditions",
    "experts",
    "outcomes",
    "spin_draw",
    "direct",
    "sample",
    "frame",
    "rough",
    "rebound",
    "checksum",
    "layout",
    "check",
    "read",
    "open",
    "queries",
    "sizes",
    "gas",
    "walls",
    "faces",
    "end",
)

#: No product is fused with a sum, which keeps the bits; nobody reads errno or floating-point traps.
#: The library calls its own functions, whatever other library of the process has the same names.
FLAGS = (
    "-std=gnu11",
    "-O3",
    "-ffp-contract=off",
    "-fno-math-errno",
    "-fno-trapping-math",
    "-fPIC",
    "-fvisibility=protected",
    "-shared",
    "-DREBOUND_SAMPLER_IMPLEMENTATION",
)


def compiler() -> list[str]:
    """Find a C compiler; empty if there is none."""
    if given := os.environ.get("CC"):
        return shlex.split(given)
    for name in ("gcc", "clang", "cc"):
        if found := shutil.which(name):
            return [found]
    # by itself it compiles for the processor at hand alone
    zig = [sys.executable, "-m", "ziglang", "cc", "-mcpu=baseline"]
    return zig if find_spec("ziglang") else []


def header() -> str:
    """Put the header together."""
    sections = (HERE / "src" / f"{name}.h" for name in SECTIONS)
    return "\n".join(section.read_text(encoding="utf-8") for section in sections)


def build(library: Path = LIBRARY, source: Path = SOURCE) -> None:
    """Write header and library; raises `SystemExit` with one line if that cannot be done."""
    HEADER.write_text(header(), encoding="utf-8")
    words = compiler()
    if not words:
        raise SystemExit("no C compiler found: install gcc or clang, or pip install ziglang")
    flags = shlex.split(os.environ.get("CFLAGS", ""))
    command = [*words, *FLAGS, *flags, "-x", "c", str(source), "-o", str(library), "-lm"]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"{shlex.join(command)}\n{done.stderr}the draw was not compiled")


if __name__ == "__main__":
    build()
