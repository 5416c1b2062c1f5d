"""What the plots of a report share: their look, menus, and plotly's own exporter."""

import math
from collections.abc import Iterable, Sequence
from typing import Any

import plotly.graph_objects as go
from markupsafe import Markup

from tablegen.evidence.labels import quantity_text

#: Opposite of the background, and what is drawn on both.
INK, FAINT = "#000000", "rgba(0, 0, 0, 0.12)"

#: Most ticks of a logarithmic axis; steps within a decade and of decades, the finest first.
_MOST_TICKS = 6
_STEPS: tuple[tuple[tuple[float, ...], int], ...] = (
    ((1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8), 1),
    ((1, 2, 5), 1),
    ((1, 3), 1),
    *(((1,), every) for every in range(1, 7)),
)

#: An axis cannot be dragged: a finger on it scrolls the page.
_AXIS = {
    "automargin": True,
    "fixedrange": True,
    "gridcolor": "#d5d9de",
    "ticks": "outside",
    "tickcolor": "#d5d9de",
    "title": {"standoff": 8},
    "zeroline": False,
}

#: Look of every plot, on the page's own background.
_TEMPLATE = go.layout.Template(
    layout={
        "paper_bgcolor": "rgba(0, 0, 0, 0)",
        "plot_bgcolor": "rgba(0, 0, 0, 0)",
        "font": {"color": INK, "size": 13, "family": "system-ui, DejaVu Sans, sans-serif"},
        "margin": {"l": 40, "r": 10, "t": 20, "b": 45},
        "dragmode": False,
        "hovermode": "closest",
        "legend": {"orientation": "h", "y": -0.2, "yanchor": "top", "font": {"size": 12}},
        "xaxis": _AXIS,
        "yaxis": _AXIS,
        "updatemenudefaults": {
            "x": 0,
            "xanchor": "left",
            "y": 1,
            "yanchor": "bottom",
            "bgcolor": "#ffffff",
            "bordercolor": "#777777",
            "font": {"size": 13},
        },
    }
)

#: Settings by which plotly shows a plot.
_CONFIG = {"displayModeBar": False, "responsive": True}


def log_axis(title: str, values: Iterable[float], unit: str = "") -> dict[str, Any]:
    """Logarithmic axis for positive values with a few ticks, as "2 µs" or "100 kB".

    Plotly's own ticks overlap on a phone, and only some of them have a unit.
    """
    positive = [value for value in values if value > 0.0] or [1.0]
    low, high = min(positive) / 1.3, 1.3 * max(positive)
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    for steps, every in _STEPS:
        ticks = [step * 10.0**k for k in decades if k % every == 0 for step in steps]
        ticks = [tick for tick in ticks if low <= tick <= high]
        if len(ticks) <= _MOST_TICKS:
            break
    texts = [quantity_text(tick, unit) for tick in ticks]
    return {"type": "log", "title": {"text": title}, "tickvals": ticks, "ticktext": texts}


def button(label: str, *args: dict[str, Any]) -> dict[str, Any]:
    """Entry of a menu: what it changes of the traces, then of the layout."""
    return {"label": label, "method": "update", "args": args}


def menu(buttons: Sequence[dict[str, Any]], active: int = 0, above: int = 8) -> dict[str, Any]:
    """Menu so many pixels above a plot."""
    return {"buttons": buttons, "active": active, "pad": {"b": above}}


def press(figure: go.Figure, pressed: dict[str, Any]) -> None:
    """Change a figure as an entry of a menu does."""
    traces, layout = pressed["args"]
    for key, values in traces.items():
        for trace, value in zip(figure.data, values, strict=True):
            trace[key] = value
    figure.update_layout(layout)


def plot_html(figure: go.Figure, identity: str) -> Markup:
    """Plot as plotly exports it, as wide as the page."""
    figure.update_layout(template=_TEMPLATE)
    return Markup(
        figure.to_html(
            full_html=False, include_plotlyjs=False, div_id=f"plot-{identity}", config=_CONFIG
        )
    )
