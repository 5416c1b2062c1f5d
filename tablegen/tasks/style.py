"""Look of the figures: colours that a colour-blind reader can tell, symbols that say it again."""

import io
from typing import Any, NamedTuple

from sampler.errors import InputError
from tablegen.evidence.sample_statistics import MIXTURE

#: Okabe and Ito's colours; each shape has a marker of its own as well.
COLOURS = {
    "ellipsoid": "#0072b2",
    "prism": "#d55e00",
    "truncated-prism": "#009e73",
    "tetrahedron": "#a64d79",
    MIXTURE: "#000000",
}
MARKERS = {"ellipsoid": "o", "prism": "s", "truncated-prism": "^", "tetrahedron": "D", MIXTURE: "."}

#: The table, wherever it is drawn.
TABLE_COLOUR = "#e08a00"

#: Symbols of quantities on axes.
SYMBOLS = {
    "u": r"$u^+/V$",
    "v": r"$v^+/V$",
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
    # without these two, the same figure is another file each time
    "svg.hashsalt": "rebound-tables",
    "axes.formatter.use_mathtext": True,
}


class Picture(NamedTuple):
    """A figure as a file."""

    #: Name of the file.
    name: str
    title: str
    #: What it shows, for those who cannot see it.
    alternative: str
    data: bytes

    @property
    def media_type(self) -> str:
        """What the file is."""
        kinds = {"svg": "image/svg+xml", "pdf": "application/pdf"}
        return kinds.get(self.name.rpartition(".")[2], "image/png")


def require_matplotlib(flag: str) -> None:
    """Refuse to go on without matplotlib.

    Raises
    ------
    InputError
        If it is not installed.
    """
    try:
        import matplotlib  # noqa: F401
    except ImportError as error:
        raise InputError(
            f"{flag}: needs matplotlib, which is not installed, allowed: "
            "pip install 'rebound-tables[plot]'"
        ) from error


def new_figure(width: float, height: float) -> Any:
    """Empty figure [inches]; no window system is asked for."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def settings() -> Any:
    """Context in which figures are drawn and written."""
    import matplotlib

    return matplotlib.rc_context(_SETTINGS)


def numbered(figure: Any, number: int, title: str, alternative: str, kind: str = "svg") -> Picture:
    """Figure of the paper as a file in memory."""
    return written(figure, f"figure-{number:02d}.{kind}", f"Figure {number}. {title}", alternative)


def written(figure: Any, name: str, title: str, alternative: str) -> Picture:
    """Figure as a file in memory, the same bytes each time."""
    kind = name.rpartition(".")[2]
    buffer = io.BytesIO()
    # what would differ each time, or tell of the machine
    metadata = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(kind, {"Software": None})
    figure.savefig(buffer, format=kind, dpi=130, metadata=metadata)
    return Picture(name, title, alternative, buffer.getvalue())
