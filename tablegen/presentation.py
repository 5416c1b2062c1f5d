"""Present results: text tables, and the style and the files of matplotlib figures."""

import io
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

from sampler.errors import InputError

#: Colours of the shapes. Colour-blind readers can tell them apart (Okabe and Ito).
COLOURS = {
    "ellipsoid": "#0072b2",
    "prism": "#d55e00",
    "truncated-prism": "#009e73",
    "tetrahedron": "#a64d79",
    "mixture": "#000000",
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
    # Without a fixed salt, the same figure would give another file each time.
    "svg.hashsalt": "rebound-tables",
    "axes.formatter.use_mathtext": True,
}


def require_matplotlib(flag: str) -> None:
    """Import matplotlib for a command; raises `InputError` if the option `flag` cannot have it.

    The command draws to files, whatever backend the environment names, such as that of a notebook.
    """
    os.environ["MPLBACKEND"] = "agg"
    try:
        import matplotlib  # noqa: F401
    except ImportError as error:
        problem, remedy = "matplotlib is not installed", "run: pip install 'rebound-tables[plot]'"
        raise InputError(flag, problem=problem, remedy=remedy) from error
    except Exception as error:  # of a matplotlibrc that is no text, for example
        problem = f"matplotlib cannot be imported ({type(error).__name__}: {error})"
        raise InputError(flag, problem=problem, remedy="look at your matplotlibrc") from error


def new_figure(width: float, height: float) -> Any:
    """Make an empty figure, width by height in inches, without a window."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


@contextmanager
def figure_style() -> Iterator[None]:
    """Draw and write figures in the style of this package, whatever the user's matplotlibrc says.

    Otherwise a picture would depend on the machine, or need LaTeX.
    """
    import matplotlib

    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(_SETTINGS)
        yield


def legend_below(figure: Any, columns: int = 3) -> None:
    """Put one legend below all panels; a label that several panels have appears once."""
    handles: dict[str, Any] = {}
    for axes in figure.axes:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            handles.setdefault(label, handle)
    figure.legend(handles.values(), handles, loc="outside lower center", ncols=columns)


def set_log_ticks(axes: Any) -> None:
    """Write 1, 2, 5, 10, ... on two logarithmic axes."""
    from matplotlib.ticker import LogLocator, NullLocator

    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.set_major_formatter("{x:g}")
        axis.set_minor_locator(NullLocator())


def make_picture(figure: Any, name: str) -> bytes:
    """Return a figure as the bytes of a file; the ending of the name selects the format.

    The same figure gives the same bytes.
    """
    kind = name.rpartition(".")[2]
    buffer = io.BytesIO()
    # Date and version of matplotlib would differ between equal figures, so they are left out.
    metadata = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(kind, {"Software": None})
    figure.savefig(buffer, format=kind, dpi=130, metadata=metadata)
    return buffer.getvalue()


def table_lines(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """Write a text table: the first column is aligned left, the others right."""
    widths = [max(len(row[k]) for row in (head, *rows)) for k in range(len(head))]
    lines = []
    for row in (head, *rows):
        cells = [row[0].ljust(widths[0])]
        cells += [cell.rjust(width) for cell, width in zip(row[1:], widths[1:], strict=True)]
        lines.append("  ".join(cells))
    return lines


class TextTable(NamedTuple):
    """Table of texts with a caption; each row has one cell for each head."""

    caption: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]

    def __str__(self) -> str:
        return "\n".join([self.caption, *table_lines(self.head, self.rows)])
