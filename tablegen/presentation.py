"""Presentation of results: text tables, and the look and the files of matplotlib figures."""

import io
from collections.abc import Sequence
from typing import Any, NamedTuple

from sampler.errors import InputError

#: Colours of Okabe and Ito, which colour-blind readers can tell; markers repeat the difference.
COLOURS = {
    "ellipsoid": "#0072b2",
    "prism": "#d55e00",
    "truncated-prism": "#009e73",
    "tetrahedron": "#a64d79",
    "mixture": "#000000",
}
MARKERS = {
    "ellipsoid": "o",
    "prism": "s",
    "truncated-prism": "^",
    "tetrahedron": "D",
    "mixture": ".",
}

#: Colour of the table's law.
TABLE_COLOUR = "#e08a00"

#: Symbols of quantities on axes.
SYMBOLS = {
    "u": r"$u^+/V$",
    "v": r"$v^+/V$",
    "w": r"$w^+/V$",
    "omega_x": r"$\Omega_x^+\,a/V$",
    "omega_y": r"$\Omega_y^+\,a/V$",
    "omega_z": r"$\Omega_z^+\,a/V$",
    "translational": r"$E_V^+/E_V^-$",
    "rotational": r"$E_\Omega^+/E_V^-$",
}

ANGLE_LABEL = r"impact angle $\alpha_1$ [°]"

_SETTINGS: Any = {
    "font.family": "DejaVu Sans",
    "font.size": 11,
    "axes.titlesize": 11,
    "axes.grid": True,
    "grid.color": "#dddddd",
    "axes.axisbelow": True,
    "legend.frameon": False,
    "legend.fontsize": 9.5,
    "svg.fonttype": "path",
    # without a fixed salt, the same figure gives different files
    "svg.hashsalt": "rebound-tables",
    "axes.formatter.use_mathtext": True,
}


class Picture(NamedTuple):
    """Figure as a file in memory, with a text that describes it."""

    name: str
    title: str
    alternative: str
    data: bytes

    @property
    def media_type(self) -> str:
        """Media type of the file."""
        kinds = {"svg": "image/svg+xml", "pdf": "application/pdf"}
        return kinds.get(self.name.rpartition(".")[2], "image/png")


def require_matplotlib(flag: str) -> None:
    """Raise InputError if matplotlib, which `flag` needs, is not installed."""
    try:
        import matplotlib  # noqa: F401
    except ImportError as error:
        problem, remedy = "matplotlib is not installed", "run: pip install 'rebound-tables[plot]'"
        raise InputError(flag, problem=problem, remedy=remedy) from error


def new_figure(width: float, height: float) -> Any:
    """Make an empty figure [inches] without a window."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def settings() -> Any:
    """Context in which figures are drawn and written."""
    import matplotlib

    return matplotlib.rc_context(_SETTINGS)


def legend_below(figure: Any, columns: int = 3) -> None:
    """Put one legend of all panels below them; the same label stands there once."""
    handles: dict[str, Any] = {}
    for axes in figure.axes:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            handles.setdefault(label, handle)
    figure.legend(handles.values(), handles, loc="outside lower center", ncols=columns)


def written(figure: Any, name: str, title: str, alternative: str) -> Picture:
    """Write a figure to memory: the same figure gives the same bytes."""
    kind = name.rpartition(".")[2]
    buffer = io.BytesIO()
    # leave out the date and the version of matplotlib
    metadata = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(kind, {"Software": None})
    figure.savefig(buffer, format=kind, dpi=130, metadata=metadata)
    return Picture(name, title, alternative, buffer.getvalue())


def table_lines(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """Lines of a text table: the first column flush left, the others flush right."""
    widths = [max(len(row[k]) for row in (head, *rows)) for k in range(len(head))]
    lines = []
    for row in (head, *rows):
        cells = [row[0].ljust(widths[0])]
        cells += [cell.rjust(width) for cell, width in zip(row[1:], widths[1:], strict=True)]
        lines.append("  ".join(cells))
    return lines


class TextTable(NamedTuple):
    """Table of text; each row has one cell for each head."""

    caption: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    #: "words" if the cells are sentences.
    style: str = ""

    def __str__(self) -> str:
        return "\n".join([self.caption, *table_lines(self.head, self.rows)])
