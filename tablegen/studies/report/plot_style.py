"""What the plots of a report share: axes in plain units, menus, and plotly's own exporter."""

import math
from collections.abc import Sequence
from typing import Any

import plotly.graph_objects as go
from markupsafe import Markup

from tablegen.studies.report.labels import quantity_text

#: Opposite of the background, and what is drawn on both.
INK, GRID, FAINT = "#000000", "#d5d9de", "rgba(0, 0, 0, 0.12)"

#: Most labels on an axis; more would overlap on a phone.
_MOST_TICKS = 6

#: Steps within a decade, and of decades, from the finest.
_STEPS: tuple[tuple[tuple[float, ...], int], ...] = (
    ((1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8), 1),
    ((1, 1.5, 2, 3, 5, 7), 1),
    ((1, 2, 5), 1),
    ((1, 3), 1),
    *(((1,), every) for every in range(1, 7)),
)


def axis(title: str, **more: Any) -> dict[str, Any]:
    """Linear axis that cannot be dragged; a finger on it scrolls the page."""
    return {
        "title": {"text": title, "standoff": 8},
        "gridcolor": GRID,
        "zeroline": False,
        "ticks": "outside",
        "tickcolor": GRID,
        "automargin": True,
        "fixedrange": True,
        **more,
    }


def log_ticks(low: float, high: float) -> list[float]:
    """Round numbers from `low` to `high`, as many as find room beside each other."""
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    for steps, every in _STEPS:
        ticks = [s * 10.0**k for k in decades if k % every == 0 for s in steps]
        ticks = [tick for tick in ticks if low <= tick <= high]
        if len(ticks) <= _MOST_TICKS:
            return ticks
    return [low, high]


def log_axis(title: str, values: Sequence[float], unit: str = "", **more: Any) -> dict[str, Any]:
    """Logarithmic axis over the positive ones of `values`, with ticks as "2 µs" or "100 kB"."""
    positive = [value for value in values if value > 0.0] or [1.0]
    ends = math.log10(min(positive)), math.log10(max(positive))
    room = max(0.08, 0.06 * (ends[1] - ends[0]))
    low, high = ends[0] - room, ends[1] + room
    ticks = log_ticks(10.0**low, 10.0**high)
    return axis(
        title,
        type="log",
        range=[low, high],
        tickvals=ticks,
        ticktext=[quantity_text(tick, unit) for tick in ticks],
        **more,
    )


def new_plot(**layout: Any) -> go.Figure:
    """Empty plot on the page's own background."""
    figure = go.Figure()
    set_layout(figure, **layout)
    return figure


def set_layout(figure: go.Figure, **layout: Any) -> None:
    """Give a figure the layout that all plots share, and `layout`."""
    figure.update_layout(
        template="none",
        paper_bgcolor="rgba(0, 0, 0, 0)",
        plot_bgcolor="rgba(0, 0, 0, 0)",
        font={"color": INK, "size": 13, "family": "system-ui, DejaVu Sans, sans-serif"},
        margin={"l": 50, "r": 10, "t": 20, "b": 45},
        dragmode=False,
        hovermode="closest",
        legend={"orientation": "h", "x": 0, "y": -0.2, "yanchor": "top", "font": {"size": 12}},
    )
    figure.update_layout(layout)


def menu(buttons: Sequence[dict[str, Any]], above: int = 8, active: int = 0) -> dict[str, Any]:
    """Menu so many pixels above a plot."""
    return {
        "buttons": list(buttons),
        "active": active,
        "x": 0,
        "xanchor": "left",
        "y": 1,
        "yanchor": "bottom",
        "pad": {"b": above},
        "bgcolor": "#ffffff",
        "bordercolor": "#777777",
        "font": {"size": 13},
    }


def button(label: str, *args: dict[str, Any]) -> dict[str, Any]:
    """Entry of a menu: what it changes of the traces, then of the layout."""
    return {"label": label, "method": "update", "args": list(args)}


def plot_html(figure: go.Figure, identity: str, height: int) -> Markup:
    """Plot as plotly exports it, as wide as the page [height in pixels]."""
    return Markup(
        figure.to_html(
            full_html=False,
            include_plotlyjs=False,
            div_id=f"plot-{identity}",
            default_width="100%",
            default_height=f"{height}px",
            config={"displayModeBar": False, "responsive": True},
        )
    )
