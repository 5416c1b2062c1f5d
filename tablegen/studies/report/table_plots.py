"""Plots of a report on the table itself: accuracy map, marginals, joint densities."""

import math
from collections.abc import Mapping
from itertools import combinations
from typing import Any

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from sampler.formats.channels import STATE
from tablegen.accuracy.samples import FloatArray
from tablegen.studies.report.accuracy_map import Atlas
from tablegen.studies.report.histograms import View
from tablegen.studies.report.labels import LABELS, SHORT, quantity_text
from tablegen.studies.report.method_styles import LOOKS
from tablegen.studies.report.plot_style import FAINT, INK, axis, button, menu, new_plot, set_layout

#: Little to much by lightness, for those who see no colours; little is nearly the background.
_SHADES = "Blues"

#: Shares of the largest density that a colour bar names.
_TICK_SHARES = (0.0, 0.05, 0.25, 0.5, 1.0)

_ANGLES = (0.5, 5, 15, 30, 50, 70, 90)

#: Cells with fewer states on both sides together are not judged.
_LEAST_STATES = 20


def accuracy_map(
    atlas: Atlas, stored: Mapping[str, FloatArray], declared: Mapping[str, float]
) -> go.Figure:
    """Distances over angle and speed: cells of this run, dots that the table stores.

    Parameters
    ----------
    atlas : Atlas
    stored : dict from name to array
        Accuracy that the table carries.
    declared : dict from metric to float
        Largest distances that the table declares.

    Returns
    -------
    plotly Figure
        A menu chooses the metric.
    """
    figure, buttons = new_plot(), []
    shape = (len(atlas.alpha_deg), len(atlas.speed))
    for k, (metric, limit) in enumerate(declared.items()):
        cells = np.array([getattr(point, metric) for point in atlas.points]).reshape(shape).T
        dots = stored[metric].reshape(len(stored["speed"]), -1).max(axis=1, initial=0.0)
        least = 0.5 if metric == "auc" else 0.0
        scale = {"zmin": least, "zmax": max(limit, cells.max(), dots.max(initial=0.0))}
        figure.add_heatmap(
            x=np.sqrt(atlas.alpha_deg),
            y=atlas.speed,
            z=cells,
            customdata=np.broadcast_to(atlas.alpha_deg, cells.shape),
            hovertemplate="%{customdata}°, %{y} m/s: %{z:.4f}<extra></extra>",
            xgap=1,
            ygap=1,
            colorscale=_SHADES,
            colorbar={"thickness": 12, "xpad": 5},
            visible=k == 0,
            **scale,
        )
        figure.add_scatter(
            x=np.sqrt(stored["alpha_deg"]),
            y=stored["speed"],
            customdata=np.stack([stored["alpha_deg"], dots], axis=1),
            hovertemplate="stored: %{customdata[0]:.2f}°, %{y:.1f} m/s: %{customdata[1]:.4f}"
            "<extra></extra>",
            mode="markers",
            marker={
                "color": dots,
                "cmin": scale["zmin"],
                "cmax": scale["zmax"],
                "colorscale": _SHADES,
                "size": 10,
                "line": {"color": INK, "width": 1.5},
            },
            visible=k == 0,
        )
        shown = [k == other for other in range(len(declared)) for _ in range(2)]
        buttons.append(button(f"{SHORT[metric]}, declared: {limit:g}", {"visible": shown}))
    ticks = {"tickvals": np.sqrt(_ANGLES), "ticktext": [f"{angle:g}" for angle in _ANGLES]}
    figure.update_layout(
        xaxis=axis("impact angle α₁ [°], by its square root", showgrid=False, **ticks),
        yaxis=axis("speed V [m/s]", showgrid=False),
        updatemenus=[menu(buttons)],
        margin={"t": 60},
        showlegend=False,
    )
    return figure


def marginals(view: View) -> go.Figure:
    """Densities of the six variables at one condition, table on direct simulation."""
    figure = make_subplots(rows=3, cols=2, vertical_spacing=0.13, horizontal_spacing=0.12)
    for k, name in enumerate(STATE):
        for family, counts in (("direct simulation", view.direct), ("table", view.table)):
            width = (view.high[k] - view.low[k]) / len(counts[name])
            under = family == "direct simulation"
            figure.add_scatter(
                x0=view.low[k] + 0.5 * width,
                dx=width,
                y=np.array(counts[name], dtype=np.float32) / (view.count * width),
                mode="lines",
                line={
                    "shape": "hvh",
                    "color": LOOKS[family].colour,
                    "width": 0.5 if under else 1.8,
                },
                fill="tozeroy" if under else "none",
                fillcolor=FAINT,
                name=family,
                showlegend=k == 0,
                hovertemplate="%{y:.3f} at %{x:.3f}",
                row=1 + k // 2,
                col=1 + k % 2,
            )
        figure.update_xaxes(axis(LABELS[name], nticks=5), row=1 + k // 2, col=1 + k % 2)
        figure.update_yaxes(axis("", rangemode="tozero", nticks=4), row=1 + k // 2, col=1 + k % 2)
    set_layout(figure, legend={"y": 1.01, "yanchor": "bottom"}, margin={"l": 35, "t": 40})
    return figure


def _square(counts: list[int]) -> FloatArray:
    """Counts of a pair; rows are its second variable."""
    size = math.isqrt(len(counts))
    return np.array(counts, dtype=np.float64).reshape(size, size).T


def _pair_parts(view: View, first: str, second: str) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """Heat maps of direct simulation, of the table and of their difference; and the layout."""
    direct, table = (_square(side[f"{first} {second}"]) for side in (view.direct, view.table))
    i, j = STATE.index(first), STATE.index(second)
    dx, dy = ((view.high[k] - view.low[k]) / len(direct) for k in (i, j))
    top = max(direct.max(), table.max(), 1.0)
    largest = top / (view.count * dx * dy)
    both = direct + table
    errors = (table - direct) / np.sqrt(np.maximum(both, 1.0))
    judged = both >= _LEAST_STATES
    beyond, chance = np.sum(np.abs(errors[judged]) > 3.0), 0.0027 * np.sum(judged)
    # a byte a cell is all that colours can show
    shades = [np.round(255.0 * np.sqrt(side / top)).astype(np.uint8) for side in (direct, table)]
    steps = np.clip(np.round(errors), -5, 5).astype(np.int8)
    place = {"x0": view.low[i] + dx / 2, "dx": dx, "y0": view.low[j] + dy / 2, "dy": dy}
    words = "%{x:.3f}, %{y:.3f}"
    traces = [
        {**place, "z": z, "coloraxis": "coloraxis", "hovertemplate": f"{words}<extra></extra>"}
        for z in shades
    ]
    words += ": %{z} standard errors<extra></extra>"
    traces.append({**place, "z": steps, "coloraxis": "coloraxis2", "hovertemplate": words})
    layout = {
        "coloraxis.colorbar.ticktext": [quantity_text(share * largest) for share in _TICK_SHARES],
        "annotations[2].text": "table minus direct<br>"
        f"{beyond} of {np.sum(judged)} cells beyond 3<br>({chance:.1f} by chance)",
    }
    for number in ("", 2, 3):
        layout[f"xaxis{number}.title.text"] = LABELS[first]
        # no room between the upper two
        layout[f"yaxis{number}.title.text"] = LABELS[second] if number != 2 else ""
    return traces, layout


def joint_densities(view: View) -> go.Figure:
    """Joint densities of every pair of variables at one condition, and how they differ.

    Parameters
    ----------
    view : View

    Returns
    -------
    plotly Figure
        A menu chooses the pair.
    """
    pairs = list(combinations(STATE, 2))
    # the third one is that of the pair
    titles = ("direct simulation", "table", " ")
    figure = make_subplots(
        rows=2,
        cols=2,
        specs=[[{}, {}], [{}, None]],
        subplot_titles=titles,
        horizontal_spacing=0.14,
        vertical_spacing=0.22,
    )
    buttons = []
    for k, (first, second) in enumerate(pairs):
        traces, layout = _pair_parts(view, first, second)
        for trace, (row, col) in zip(traces, ((1, 1), (1, 2), (2, 1)), strict=True):
            figure.add_heatmap(**trace, visible=k == 0, row=row, col=col)
        shown = [k == other for other in range(len(pairs)) for _ in range(3)]
        label = f"{LABELS[first]} and {LABELS[second]}"
        buttons.append(button(label, {"visible": shown}, layout))
    figure.update_xaxes(axis("", showgrid=False, nticks=5))
    figure.update_yaxes(axis("", showgrid=False, nticks=5))
    figure.update_annotations(font={"size": 12})
    bar = {"thickness": 10, "len": 0.36, "y": 0.18, "xpad": 0}
    roots = [255.0 * math.sqrt(share) for share in _TICK_SHARES]
    density = bar | {"title": {"text": "density", "side": "right"}, "x": 0.58, "tickvals": roots}
    errors = bar | {"title": {"text": "standard errors", "side": "right"}, "x": 0.8}
    set_layout(
        figure,
        coloraxis={"colorscale": _SHADES, "cmin": 0, "cmax": 255, "colorbar": density},
        coloraxis2={"colorscale": "RdBu_r", "cmin": -5, "cmax": 5, "colorbar": errors},
        updatemenus=[menu(buttons, above=32)],
        margin={"l": 40, "t": 90},
    )
    figure.update_layout(buttons[0]["args"][1])
    return figure
