"""Parts of the C header, of the Fortran module and of a page, made from one description.

Run ``python tools/generated_code.py`` after a change to `sampler.errors`,
`sampler.formats.channels`, `sampler.formats.records` or `sampler.formats.binary_layout`, then
``python sampler/c/build.py``; everything outside the marked parts is written by hand.
"""

import functools
import itertools
import textwrap
from collections.abc import Iterable

import numpy as np
from marked_parts import fill_file, filled

from sampler.errors import CODES, FLAGS, LAST_OF_DRAWS, OUTSIDE, Code
from sampler.files import include_directory
from sampler.formats import bounds, records
from sampler.formats.binary_layout import (
    ARRAYS,
    BINARY_VERSION,
    HEADER,
    MAGIC,
    MOST_BYTES,
    SPEED_INDEPENDENT,
    SPHERES,
    Field,
    StoredArray,
)
from sampler.formats.channels import (
    CHANNELS,
    END_MIRRORED,
    FIRST_MIRRORED,
    MOST_NAMES,
    VARIABLES,
)
from sampler.formats.records import RECORDS
from sampler.formats.shape_codes import FIRST_MESH, SHAPE_CODES
from sampler.version import __version__

_WIDTH = 98


def _c_type(dtype: str) -> str:
    kind = np.dtype(dtype)
    if kind.kind in "iu":
        return f"{'u' * (kind.kind == 'u')}int{8 * kind.itemsize}_t"
    return "char" if kind.kind == "S" else {4: "float", 8: "double"}[kind.itemsize]


def public_constants() -> str:
    """Versions, codes with their meaning, and how many variables and channels there are, in C."""
    major, minor, _ = __version__.split(".")
    variables = [f"RBT_{name.upper()}" for name in VARIABLES]
    channels = [f"RBTI_OF_{name.upper()}" for name in CHANNELS]
    lines = [f"#define RBT_VERSION_MAJOR {major}", f"#define RBT_VERSION_MINOR {minor}"]
    lines += [f"#define RBT_{code.name} {_c_number(code.number)}" for code in CODES]
    lines.append(
        f"#define RBT_OUTSIDE {OUTSIDE} /* RBT_ANGLE, RBT_SPEED or RBT_SPIN: outside the table */"
    )
    lines.append("/* codes of shapes */")
    shapes = [f"RBT_{name}" for name in _shapes()]
    lines += _enumeration([*shapes, f"RBT_FIRST_MESH = {FIRST_MESH}"])
    lines.append("/* variables of a state, in this order */")
    lines += _enumeration([*variables, "RBT_VALUES"])
    lines.append("/* channels, in which these are stored */")
    lines += _enumeration([*channels, "RBTI_CHANNELS"])
    lines.append(f"#define RBTI_NAMES {MOST_NAMES} /* most of either that a table has */")
    return "\n".join(lines) + "\n"


def _shapes() -> dict[str, int]:
    """Give the codes of shapes by their names in C and Fortran."""
    return {name.upper().replace("-", "_"): code for name, code in SHAPE_CODES.items()}


def _enumeration(names: list[str]) -> list[str]:
    return _wrapped_list([*names[:-1], f"{names[-1]} }};"], "enum { ", " " * 7, _WIDTH)


def _wrapped_list(items: list[str], head: str, indent: str, width: int) -> list[str]:
    """Break a list into lines between its items only."""
    whole = ", ".join(item.replace(" ", "\0") for item in items)
    lines = textwrap.wrap(whole, width, initial_indent=head, subsequent_indent=indent)
    return [line.replace("\0", " ") for line in lines]


def _c_number(number: int) -> str:
    return f"({number})" if number < 0 else str(number)


#: Types of C in the records, and what they are in Fortran.
_FORTRAN = {"int": "integer(c_int)", "size_t": "integer(c_size_t)"}
#: Types of C that are others on a device.
_DEVICE = {"double": "RBT_REAL"}


def record_struct(name: str) -> str:
    """Write a record of the interface as a C struct, with a comment behind each field."""
    declarations = [_declaration(field) for field in RECORDS[name]]
    column = 4 + max(map(len, declarations)) + 1
    lines = [f"typedef struct rbt_{name} {{"]
    for declaration, field in zip(declarations, RECORDS[name], strict=True):
        indent = " " * (column + 3)
        first = f"    {declaration:{column - 4}}/* "
        text = f"{field.meaning} */"
        lines += textwrap.wrap(text, 110, initial_indent=first, subsequent_indent=indent)
    return "\n".join([*lines, f"}} rbt_{name};"]) + "\n"


def _declaration(field: records.Field) -> str:
    if field.role == records.NUMBER:
        extent = f"[{field.width}]" if field.width > 1 else ""
        return f"{field.kind} {field.name}{extent};"
    return f"{'' if field.role == records.RESULT else 'const '}{field.kind} *{field.name};"


def fortran_records() -> str:
    """Write the records of the interface in Fortran."""
    texts = []
    for name, fields in RECORDS.items():
        lines = [f"  type, bind(c) :: c_{name}"]
        for kind, group in itertools.groupby(fields, lambda f: f.role != records.NUMBER or f.kind):
            pointers = kind is True
            words = [
                f"{f.name} = c_null_ptr"
                if pointers
                else f"{f.name}{f'({f.width})' if f.width > 1 else ''} = 0"
                for f in group
            ]
            head = f"    {'type(c_ptr)' if pointers else _FORTRAN[str(kind)]} :: "
            lines.append(" &\n".join(_wrapped_list(words, head, " " * 8, _WIDTH - 2)))
        texts.append("\n".join([*lines, f"  end type c_{name}\n"]))
    return "\n".join(texts)


def device_records() -> str:
    """Write the records of arguments for kernels, and the place of each array in its record."""
    lines = []
    for name in ("conditions", "impacts"):
        names = records.argument_arrays(name)
        lines += _enumeration([f"RBTI_{name.upper()}_{field.upper()}" for field in names])
        lines.append(f"typedef struct rbt_device_{name} {{")
        fields = [field for field in RECORDS[name] if field.role != records.RESULT]
        for kind, group in itertools.groupby(fields, lambda f: (f.role == records.NUMBER, f.kind)):
            is_number, number = kind
            lines += ["    uint32_t single;"] * is_number
            declared = [field.name if is_number else f"*{field.name}" for field in group]
            head = "    int " if is_number else f"    const {_DEVICE.get(number, number)} "
            lines += _wrapped_list([*declared[:-1], f"{declared[-1]};"], head, " " * 8, _WIDTH)
        lines.append(f"}} rbt_device_{name};\n")
    return "\n".join(lines)


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
    numbers = {
        "INPUTS": bounds.N_INPUTS,
        "DIRECTIONS": bounds.N_DIRECTIONS,
        "FEATURES": bounds.N_FEATURES,
        "OUTCOMES": bounds.N_OUTCOMES,
        "MOST_OUTCOMES": bounds.N_OUTCOMES_WITH_WORKS,
        "GROUPS": bounds.N_GROUPS,
        "GROUP_SIZE": bounds.GROUP_SIZE,
        "KAPPA_QUANTILES": bounds.N_KAPPA_QUANTILES,
        "SPIN_CORE": repr(bounds.SPIN_CORE),
        "PLACE_CORE": repr(bounds.PLACE_CORE),
        "LEAST_WOBBLE": repr(bounds.LEAST_WOBBLE),
        "WOBBLE": repr(bounds.WOBBLE),
        "RISE": repr(bounds.RISE),
        "TILT_CORE": repr(bounds.TILT_CORE),
        "LEAST_TILT": repr(bounds.LEAST_TILT),
        "ROUND_CORE": repr(bounds.ROUND_CORE),
        "LEAST_TAKEN": repr(bounds.LEAST_TAKEN),
        "LEAST_LEFT": repr(bounds.LEAST_LEFT),
        "EQUAL_MOMENTS": repr(bounds.EQUAL_MOMENTS),
        "SINGLE_ROUNDING": repr(bounds.SINGLE_ROUNDING),
        "INERTIA_ROUNDING": repr(bounds.INERTIA_ROUNDING),
        "FOLD": repr(bounds.FOLD),
        "LEAST_RATIO": repr(bounds.LEAST_RATIO),
        "SCORE_MAX": f"{bounds.SCORE_MAX!r}f",
        "PER_SQUARE": f"{np.float32(1.0 / bounds.SCORE_MAX**2):.9g}f",
        "GATE_UNIT": f"(1.0f / {bounds.GATE_UNIT}.0f)",
        "MEAN_UNIT": f"(1.0f / {bounds.MEAN_UNIT}.0f)",
        "FACTOR_UNIT": f"(1.0f / {bounds.FACTOR_UNIT}.0f)",
        **{
            f"SLOW_TAIL_{name}": f"{number!r}f"
            for name, number in zip(
                ("SHIFT", "SQUARE", "FACTOR", "CORE"), bounds.SLOW_TAIL, strict=True
            )
        },
    }
    inputs = (*bounds.CONDITIONS, "square", *bounds.RATIOS, "rows")
    lines = [f"#define RBTI_{name} {number}" for name, number in numbers.items()]
    lines.append(
        "/* rows of a draw: inputs, with the squared spin that trees compare, and outcomes */"
    )
    lines += _enumeration([f"RBTI_IN_{name.upper()}" for name in inputs])
    lines += _enumeration([f"RBTI_OUT_{name.upper()}" for name in bounds.OUTCOMES])
    return "\n".join(lines) + "\n"


def law_codes() -> str:
    """Write the codes of the laws of contact, as enumerations that end with their number."""
    lines = []
    for kind, laws in (
        ("RESTITUTION", bounds.RESTITUTION_LAWS),
        ("RESISTANCE", bounds.RESISTANCE_LAWS),
    ):
        names = [f"RBTI_{kind}_{law.upper().replace('-', '_')}" for law in laws]
        lines += _enumeration([*names, f"RBTI_{kind}_LAWS"])
    return "\n".join(lines) + "\n"


#: Dimensions of arrays by what has them.
_DIMENSIONS = {
    "nodes": "n_alpha n_speed n_alpha_grid n_speed_grid n_knots n_components n_classes n_channels "
    "n_marginals",
    "grains": "n_shapes",
    "law": "n_nodes n_leaves n_spin_knots n_outcomes",
    "spheres": "n_law_parameters",
}


def checked_constants() -> str:
    """Write what the reader checks a file against: limits and extents of arrays, as macros."""
    magic = "".join(f"\\{byte:03o}" for byte in MAGIC)
    low, high = bounds.ANY_SPEED
    lines = [
        f'#define RBTI_MAGIC "{magic}"',
        f"#define RBTI_MAJOR {BINARY_VERSION[0]}",
        f"#define RBTI_MOST_BYTES {MOST_BYTES:#x}u",
        f"#define RBTI_SPEED_INDEPENDENT {SPEED_INDEPENDENT}u",
        f"#define RBTI_SPHERES {SPHERES}u",
        f"#define RBTI_FIRST_MIRRORED {FIRST_MIRRORED}",
        f"#define RBTI_END_MIRRORED {END_MIRRORED}",
        f"#define RBTI_LEAST_ANY_SPEED {low!r}",
        f"#define RBTI_MOST_ANY_SPEED {high!r}",
        f"#define RBTI_MOST_NUMBER {bounds.MOST_NUMBER!r} /* of a node */",
        "/* DO(what has it, dimension, least, most) */",
        *_macro("RBTI_DIMENSIONS", _dimensions()),
        "/* DO(array, member of rbt_table, type, count that is 0 without it, rows, numbers of a",
        "   row, extra numbers) */",
        *_macro("RBTI_ARRAYS", [_array_arguments(array) for array in ARRAYS]),
    ]
    return "\n".join(lines) + "\n"


def _dimensions() -> list[str]:
    """List the bounds of the dimensions of arrays, and of the number of columns."""
    named = [(there, name) for there, names in _DIMENSIONS.items() for name in names.split()]
    named.append(("1", "n_columns"))
    return [", ".join(map(str, (*pair, *bounds.LENGTHS[pair[1]]))) for pair in named]


def _macro(name: str, entries: list[str]) -> list[str]:
    lines = [f"#define {name}(DO)"]
    for entry in entries:
        lines += textwrap.wrap(f"    DO({entry})", _WIDTH, subsequent_indent=" " * 7)
    return [f"{line:{_WIDTH}} \\" for line in lines[:-1]] + lines[-1:]


def _array_arguments(array: StoredArray) -> str:
    """Write what C checks of an array; the numbers of its rows are nodes or cells if it has them.

    The product of the other dimensions fits 64 bits.
    """
    dims = [f"h->{d}" if isinstance(d, str) else str(d) for d in array.dims]
    stride = "rbti_expert_stride(h->n_outcomes)"
    rows, *rest = (stride if d == "h->expert_stride" else d for d in dims)
    if dims[:2] == ["h->n_alpha", "h->n_speed"]:
        rows, rest = "rbti_nodes(h)", dims[2:]
    elif rows == "h->n_cells":
        rows = "rbti_cells(h)"
    member = array.name.replace("_coordinate", ".coordinate")
    if array.count == "n_shapes" or array.name == "shape_inertia":
        member = f"population.{array.name}"
    elif array.count == "n_leaves":
        member = f"spin.{array.name.removeprefix('spin_')}"
    product = " * ".join([f"(uint64_t){rest[0]}", *rest[1:]]) if rest else "1"
    kind, count = _c_type(array.dtype), f"h->{array.count}"
    return f"{array.name}, {member}, {kind}, {count}, {rows}, {product}, {array.extra}"


def code_texts() -> str:
    """Write what `rbt_strerror` says, as rows of a C array."""
    texts = {f"RBT_{code.name}": code.text for code in CODES}
    flags = [code for code in CODES if code.number in FLAGS.values()]
    for count in range(2, len(flags) + 1):
        for several in itertools.combinations(flags, count):
            name = " | ".join(f"RBT_{flag.name}" for flag in several)
            texts[name] = "; ".join(flag.text for flag in several)
    lines = []
    for name, text in texts.items():
        first, *rest = textwrap.wrap(text, _WIDTH - 36, drop_whitespace=False)
        begin = f'        {{{name}, "{first}"'
        if len(begin) > _WIDTH:
            begin = f'        {{{name},\n         "{first}"'
        lines += [begin, *(f'         "{part}"' for part in rest)]
        lines[-1] += "},"
    return "\n".join(lines) + "\n"


def fortran_constants() -> str:
    """Write the codes, and the places of the variables in a state, in Fortran."""
    codes = {code.name: code.number for code in CODES} | {"OUTSIDE": OUTSIDE}
    codes |= _shapes() | {"FIRST_MESH": FIRST_MESH}
    places = {name.upper(): k for k, name in enumerate(VARIABLES, 1)} | {"VALUES": len(VARIABLES)}
    return _parameters("integer(c_int)", codes) + _parameters("integer", places)


def _parameters(kind: str, numbers: dict[str, int]) -> str:
    words = [f"RBT_{name} = {number}" for name, number in numbers.items()]
    text = " &\n".join(_wrapped_list(words, " " * 6, " " * 6, _WIDTH - 2))
    return f"  {kind}, parameter, public :: &\n{text}\n"


def codes_of_rows() -> str:
    """Write the codes of draws and rebounds, which all languages share, as a Markdown table."""
    return _codes_table(code for code in CODES if code.number >= LAST_OF_DRAWS)


def codes_of_files() -> str:
    """Write the codes of binary tables that cannot be used as a Markdown table."""
    return _codes_table(code for code in CODES if code.number < LAST_OF_DRAWS)


def _codes_table(codes: Iterable[Code]) -> str:
    rows = (f"| {code.number} `RBT_{code.name}` | {code.text} |" for code in codes)
    return "\n".join(["| code | meaning |", "|---|---|", *rows]) + "\n"


#: Marked parts by file, below the folder of `include_directory`.
PARTS = {
    "src/public.h": {"constants": public_constants}
    | {name: functools.partial(record_struct, name) for name in RECORDS},
    "src/prelude.h": {"spin": spin_constants},
    "src/sphere.h": {"laws": law_codes},
    "src/layout.h": {"header": header_struct, "checks": checked_constants},
    "src/open.h": {"texts": code_texts},
    "rebound_sampler.f90": {
        "constants": fortran_constants,
        "records": fortran_records,
    },
    "rebound_device.h": {"records": device_records},
    "../CODES.md": {"constants": codes_of_rows, "files": codes_of_files},
}


def generated(name: str, text: str) -> str:
    """Bring the marked parts in the text of a file of `PARTS` up to date."""
    marks = {".f90": "  ! {} {}", ".md": "<!-- {} {} -->"}
    mark = next((mark for end, mark in marks.items() if name.endswith(end)), "/* {} {} */")
    return filled(text, name, PARTS[name], mark)


def main() -> None:
    """Bring header, module and page up to date."""
    for name in PARTS:
        fill_file(include_directory() / name, functools.partial(generated, name))


if __name__ == "__main__":
    main()
