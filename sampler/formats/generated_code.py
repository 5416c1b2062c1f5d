"""Parts of the C header, of the Fortran module and of a page, made from one description.

Run ``python -m sampler.formats.generated_code`` after a change to `sampler.errors`,
`sampler.formats.channels` or `sampler.formats.binary_layout`, then ``python sampler/c/build.py``;
everything outside the marked parts is written by hand.
"""

import itertools
import math
import textwrap
from collections.abc import Iterable

import numpy as np

from sampler.errors import CODES, LAST_OF_DRAWS
from sampler.files import include_directory, write_text
from sampler.formats import bounds
from sampler.formats.binary_layout import (
    ARRAYS,
    BINARY_VERSION,
    COUNTS,
    FIRST_HEADER_BYTES,
    HEADER,
    INERTIA_ARRAYS,
    LAW_ARRAYS,
    MAGIC,
    MOST_BYTES,
    OTHER_POPULATION,
    SPEED_INDEPENDENT,
    SPHERES,
    SPIN_ARRAYS,
    SPIN_COUNTS,
    SPIN_WORKS,
    Field,
    StoredArray,
)
from sampler.formats.channels import (
    CHANNELS,
    END_MIRRORED,
    FIRST_MIRRORED,
    MOST_NAMES,
    VARIABLES,
    channels_for,
)
from sampler.formats.format_page import filled
from sampler.version import __version__

_WIDTH = 98

#: What the arithmetic of the reader in C may add to the rounding of a node's number.
_REST = 1.001


def _c_type(dtype: str) -> str:
    kind = np.dtype(dtype)
    if kind.kind in "iu":
        return f"{'u' * (kind.kind == 'u')}int{8 * kind.itemsize}_t"
    return "char" if kind.kind == "S" else {4: "float", 8: "double"}[kind.itemsize]


def public_constants() -> str:
    """Versions, codes with their meaning, and how many variables and channels there are, in C."""
    major, minor, _ = __version__.split(".")
    lines = [
        f"#define RBT_VERSION_MAJOR {major}",
        f"#define RBT_VERSION_MINOR {minor}",
        *(f"#define RBT_{code.name} {_number(code.number)}" for code in CODES),
        "/* variables of a state, in this order */",
        *_enumeration([f"RBT_{name.upper()}" for name in (*VARIABLES, "values")]),
        "/* channels, in which these are stored */",
        *_enumeration([f"RBTI_{name.upper()}" for name in (*(f"of_{c}" for c in CHANNELS), "channels")]),
        f"#define RBTI_NAMES {MOST_NAMES} /* most of either that a table has */",
    ]
    return "\n".join(lines) + "\n"


def _enumeration(names: list[str]) -> list[str]:
    return textwrap.wrap(f"enum {{ {', '.join(names)} }};", _WIDTH, subsequent_indent=" " * 7)


def _number(number: int) -> str:
    return f"({number})" if number < 0 else str(number)


def header_struct() -> str:
    """Write the header of the file as a C struct: every field naturally aligned, no padding."""
    lines = ["typedef struct rbti_header {"]
    for kind, fields in itertools.groupby(HEADER, lambda field: _c_type(field.dtype)):
        names = ", ".join(f"{f.name}{_extent(f)}" for f in fields)
        lines += textwrap.wrap(f"    {kind} {names};", _WIDTH, subsequent_indent=" " * 8)
    return "\n".join([*lines, "} rbti_header;"]) + "\n"


def _extent(field: Field) -> str:
    count = int(field.dtype[1:]) if field.dtype.startswith("S") else field.count
    return f"[{count}]" if count > 1 else ""


def spin_constants() -> str:
    """Write the numbers of the spin law, as macros."""
    lines = [
        *(
            f"#define RBTI_{name} {number}"
            for name, number in {
                "CONDITIONS": bounds.N_CONDITIONS,
                "INPUTS": bounds.N_INPUTS,
                "FEATURES": bounds.N_FEATURES,
                "OUTCOMES": bounds.N_OUTCOMES,
                "MOST_OUTCOMES": bounds.N_OUTCOMES_WITH_WORKS,
                "GROUPS": bounds.N_GROUPS,
                "GROUP_SIZE": bounds.GROUP_SIZE,
                "INERTIA": repr(bounds.INERTIA),
                "LEAST_RATIO": repr(bounds.LEAST_RATIO),
                "LEAST_FLATNESS": repr(bounds.LEAST_FLATNESS),
                "LEAST_REST": repr(bounds.LEAST_REST),
                "MOST_POWER": repr(bounds.MOST_POWER),
                "SCORE_MAX": f"{bounds.SCORE_MAX!r}f",
                "PER_SQUARE": f"{np.float32(1.0 / bounds.SCORE_MAX**2):.9g}f",
            }.items()
        ),
        *(
            f"#define RBTI_{name} (1.0f / {getattr(bounds, name)}.0f)"
            for name in ("GATE_UNIT", "MEAN_UNIT", "FACTOR_UNIT")
        ),
    ]
    return "\n".join(lines) + "\n"


def checked_constants() -> str:
    """Write what the reader checks a file against: limits and extents of arrays, as macros."""
    magic = "".join(f"\\{byte:03o}" for byte in MAGIC)
    needs = ", ".join(
        f"0x{sum(1 << CHANNELS.index(c) for c in channels_for([variable])):02x}"
        for variable in VARIABLES
    )
    lines = [
        f'#define RBTI_MAGIC "{magic}"',
        f"#define RBTI_MAJOR {BINARY_VERSION[0]}",
        f"#define RBTI_MOST_BYTES {MOST_BYTES:#x}u",
        f"#define RBTI_SPEED_INDEPENDENT {SPEED_INDEPENDENT}u",
        f"#define RBTI_OTHER_POPULATION {OTHER_POPULATION}u",
        f"#define RBTI_SPIN_WORKS {SPIN_WORKS}u",
        f"#define RBTI_SPHERES {SPHERES}u",
        f"#define RBTI_FIRST_MIRRORED {FIRST_MIRRORED}",
        f"#define RBTI_END_MIRRORED {END_MIRRORED}",
        "/* channels (bits) from which each variable is made */",
        f"#define RBTI_NEEDS {{{needs}}}",
        f"#define RBTI_NORMAL_HAT {1 << CHANNELS.index('normal_hat'):#x}u",
        f"#define RBTI_FIRST_HEADER_BYTES {FIRST_HEADER_BYTES}",
        *_bounds(),
        "/* DO(dimension, least, most) */",
        *_macro("RBTI_DIMENSIONS", _dimensions(COUNTS)),
        *_macro("RBTI_SPIN_DIMENSIONS", _dimensions(SPIN_COUNTS)),
        "/* DO(array, member of rbt_table, type, rows, numbers of a row, extra numbers) */",
        *_macro("RBTI_ARRAYS", [_array_arguments(array) for array in ARRAYS]),
        *_macro("RBTI_SPIN_ARRAYS", [_array_arguments(array) for array in SPIN_ARRAYS]),
        *_macro("RBTI_INERTIA_ARRAYS", [_array_arguments(array) for array in INERTIA_ARRAYS]),
        *_macro("RBTI_LAW_ARRAYS", [_array_arguments(array) for array in LAW_ARRAYS]),
    ]
    return "\n".join(lines) + "\n"


def _bounds() -> list[str]:
    """Bounds of the values; an angle has the rounding of a unit conversion besides."""
    low, high = map(math.radians, bounds.ALPHA_DEG)
    pairs = {
        "ALPHA": (low * (1.0 - bounds.ROUNDING), high * (1.0 + bounds.ROUNDING)),
        "SPEED": bounds.SPEED,
        "ANY_SPEED": bounds.ANY_SPEED,
        "ANY_SPIN": bounds.ANY_SPIN,
        "VARIATE": bounds.VARIATE_MAX,
        "SPIN_SPEED": bounds.SPIN_SPEED,
        "SPEED_COORDINATE": bounds.SPEED_COORDINATE,
        "OUTCOME": bounds.OUTCOME,
    }
    quantiles = {
        "LEAST": ", ".join(f"{bounds.QUANTILES[channel][0]:g}" for channel in CHANNELS),
        "MOST": ", ".join(f"{bounds.QUANTILES[channel][1]:g}" for channel in CHANNELS),
    }
    return [
        "/* least and largest value; see sampler/formats/bounds.py */",
        *(f"#define RBTI_{name}_BOUNDS {low!r}, {high!r}" for name, (low, high) in pairs.items()),
        f"#define RBTI_MOST_NUMBER {bounds.MOST_NUMBER!r}",
        f"#define RBTI_NUMBER_ROUNDING {bounds.NUMBER_ROUNDING * _REST!r}",
        f"#define RBTI_MOST_SPEED_SCALE {bounds.MOST_SPEED_SCALE!r}",
        f"#define RBTI_LEAST_V {bounds.LEAST_V!r}",
        f"#define RBTI_MOST_CUT {bounds.MOST_CUT!r}",
        f"#define RBTI_MOST_MIDDLE {bounds.MOST_MIDDLE!r}f",
        f"#define RBTI_MOST_SCALE {bounds.MOST_SCALE!r}f",
        "/* ends of the open interval of the quantiles of each channel */",
        *(f"#define RBTI_{name}_QUANTILES {{{ends}}}" for name, ends in quantiles.items()),
    ]


def _dimensions(counts: Iterable[str]) -> list[str]:
    """Bounds of the counts that are dimensions of arrays."""
    return [
        f"{name}, {low}, {high}" for name, (low, high) in bounds.LENGTHS.items() if name in counts
    ]


def _macro(name: str, entries: list[str]) -> list[str]:
    lines = [f"#define {name}(DO)"]
    for entry in entries:
        lines += textwrap.wrap(f"    DO({entry})", _WIDTH, subsequent_indent=" " * 7)
    return [f"{line:{_WIDTH}} \\" for line in lines[:-1]] + lines[-1:]


def _array_arguments(array: StoredArray) -> str:
    """Rows are those of the nodes or cells where the array has such; the product fits 64 bits."""
    dims = [f"h->{d}" if isinstance(d, str) else str(d) for d in array.dims]
    outcomes = {"h->n_outcomes": "rbti_outcomes(h)"}
    outcomes["h->expert_stride"] = "rbti_expert_stride(rbti_outcomes(h))"
    dims = [outcomes.get(d, d) for d in dims]
    rows, rest = dims[0], dims[1:]
    if dims[:2] == ["h->n_alpha", "h->n_speed"]:
        rows, rest = "rbti_nodes(h)", dims[2:]
    elif rows == "h->n_cells":
        rows = "rbti_cells(h)"
    member = array.name.replace("_coordinate", ".coordinate")
    if array in (*SPIN_ARRAYS, *INERTIA_ARRAYS):
        member = f"spin.{array.name.removeprefix('spin_')}"
    product = " * ".join([f"(uint64_t){rest[0]}", *rest[1:]]) if rest else "1"
    return f"{array.name}, {member}, {_c_type(array.dtype)}, {rows}, {product}, {array.extra}"


def code_texts() -> str:
    """Write what `rbt_strerror` says, as rows of a C array."""
    lines = []
    for code in CODES:
        first, *rest = textwrap.wrap(code.text, _WIDTH - 36, drop_whitespace=False)
        lines += [f'        {{RBT_{code.name}, "{first}"', *(f'         "{text}"' for text in rest)]
        lines[-1] += "},"
    return "\n".join(lines) + "\n"


def fortran_constants() -> str:
    """Write the codes, and the places of the variables in a state, in Fortran."""
    codes = {code.name: code.number for code in CODES}
    places = {name.upper(): k for k, name in enumerate(VARIABLES, 1)} | {"VALUES": len(VARIABLES)}
    return _parameters("integer(c_int)", codes) + _parameters("integer", places)


def _parameters(kind: str, numbers: dict[str, int]) -> str:
    words = ", ".join(f"RBT_{name}\0=\0{number}" for name, number in numbers.items())
    indent = " " * 6
    lines = textwrap.wrap(words, _WIDTH - 2, initial_indent=indent, subsequent_indent=indent)
    text = " &\n".join(lines).replace("\0", " ")
    return f"  {kind}, parameter, public :: &\n{text}\n"


def codes_table() -> str:
    """Write the codes of draws, which all languages share, as a Markdown table."""
    draws = (code for code in CODES if code.number >= LAST_OF_DRAWS)  # those are of files
    rows = (f"| {code.number} `RBT_{code.name}` | {code.text} |" for code in draws)
    return "\n".join(["| code | meaning |", "|---|---|", *rows]) + "\n"


#: Marked parts by file, below the folder of `include_directory`.
PARTS = {
    "src/public.h": {"constants": public_constants},
    "src/prelude.h": {"spin": spin_constants},
    "src/layout.h": {"header": header_struct, "checks": checked_constants},
    "src/open.h": {"texts": code_texts},
    "../fortran/rebound_sampler.f90": {"constants": fortran_constants},
    "../EMBEDDING.md": {"constants": codes_table},
}


def generated(name: str, text: str) -> str:
    """Text of a file of `PARTS` with its marked parts brought up to date."""
    marks = {".f90": "  ! {} {}", ".md": "<!-- {} {} -->"}
    mark = next((mark for end, mark in marks.items() if name.endswith(end)), "/* {} {} */")
    return filled(text, name, PARTS[name], mark)


def main() -> None:
    """Bring header, module and page up to date."""
    for name in PARTS:
        path = include_directory() / name
        write_text(path, generated(name, path.read_text(encoding="utf-8")))


if __name__ == "__main__":
    main()
