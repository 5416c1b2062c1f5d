"""Plots of a report on the table itself: accuracy map, marginals, joint densities."""

import math
from collections.abc import Mapping
from itertools import combinations
from typing import Any

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from sampler.formats.channels import STATE
from tablegen.config.metric_table import METRICS
from tablegen.evidence.accuracy_map import AccuracyMap
from tablegen.evidence.histograms import View
from tablegen.evidence.labels import LABELS
from tablegen.evidence.method_styles import LOOKS
from tablegen.evidence.plot_style import FAINT, INK, button, menu, press
from tablegen.model.float_array import FloatArray

#: Little to much by lightness, for those who see no colours; little is nearly the background.
_SHADES = "Blues"

#: Shares of the largest density that a colour bar names.
_TICK_SHARES = (0.0, 0.05, 0.25, 0.5, 1.0)

_ANGLES = (0.5, 5, 15, 30, 50, 70, 90)

#: Cells with fewer states on both sides together are not judged.
_LEAST_STATES = 20


def accuracy_map(
    atlas: AccuracyMap, stored: Mapping[str, FloatArray], declared: Mapping[str, float]
) -> go.Figure:
    """Distances over angle and speed: cells of this run, dots that the table stores; by metric."""
    figure, buttons = go.Figure(), []
    shape = (len(atlas.alpha_deg), len(atlas.speed))
    for k, (metric, limit) in enumerate(declared.items()):
        cells = np.array([point.estimates[metric].value for point in atlas.points]).reshape(shape).T
        dots = stored.get(metric, 0.0 * stored["speed"])
        dots = dots.reshape(len(dots), -1).max(axis=1, initial=0.0)
        scale = f"coloraxis{k + 1}" if k else "coloraxis"
        figure.add_heatmap(
            x=np.sqrt(atlas.alpha_deg),
            y=atlas.speed,
            z=cells,
            customdata=np.broadcast_to(atlas.alpha_deg, cells.shape),
            hovertemplate="%{customdata}°, %{y} m/s: %{z:.4f}<extra></extra>",
            coloraxis=scale,
        )
        figure.add_scatter(
            x=np.sqrt(stored["alpha_deg"]),
            y=stored["speed"],
            text=[f"stored, {angle:.2f}°" for angle in stored["alpha_deg"]],
            hovertemplate="%{text}, %{y:.1f} m/s: %{marker.color:.4f}<extra></extra>",
            mode="markers",
            marker={
                "color": dots,
                "coloraxis": scale,
                "size": 10,
                "line": {"color": INK, "width": 1.5},
            },
        )
        most = max(limit, cells.max(), dots.max(initial=0.0))
        bar = {"thickness": 12, "xpad": 5}
        figure.update_layout(
            {
                scale: {
                    "colorscale": _SHADES,
                    "cmin": METRICS[metric].least,
                    "cmax": most,
                    "colorbar": bar,
                }
            }
        )
        shown = [k == other for other in range(len(declared)) for _ in range(2)]
        buttons.append(
            button(f"{METRICS[metric].short}, declared: {limit:g}", {"visible": shown}, {})
        )
    ticks = {"tickvals": np.sqrt(_ANGLES), "ticktext": _ANGLES}
    figure.update_layout(
        height=480,
        xaxis={"title.text": "impact angle α₁ [°], by its square root", "showgrid": False, **ticks},
        yaxis={"title.text": "speed V [m/s]", "showgrid": False},
        updatemenus=[menu(buttons)],
        margin={"t": 60},
        showlegend=False,
    )
    press(figure, buttons[0])
    return figure


def marginals(view: View) -> go.Figure:
    """Densities of the six variables at one condition, table on direct simulation."""
    figure = make_subplots(rows=3, cols=2, vertical_spacing=0.13, horizontal_spacing=0.12)
    under = {"line": {"shape": "hvh", "color": INK, "width": 0.5}, "fill": "tozeroy"}
    over = {"line": {"shape": "hvh", "color": LOOKS["table"].colour, "width": 1.8}}
    for k, name in enumerate(STATE):
        place = {"row": 1 + k // 2, "col": 1 + k % 2}
        for family, counts, look in (
            ("direct simulation", view.direct[name], under),
            ("table", view.table[name], over),
        ):
            width = (view.high[k] - view.low[k]) / len(counts)
            figure.add_scatter(
                x0=view.low[k] + 0.5 * width,
                dx=width,
                y=np.array(counts, dtype=np.float32) / (view.count * width),
                mode="lines",
                fillcolor=FAINT,
                name=family,
                showlegend=k == 0,
                hovertemplate="%{y:.3f} at %{x:.3f}",
                **look,
                **place,
            )
        figure.update_xaxes({"title.text": LABELS[name], "nticks": 4}, **place)
    figure.update_yaxes(rangemode="tozero", nticks=4)
    legend = {"y": 1.01, "yanchor": "bottom"}
    figure.update_layout(height=620, legend=legend, margin={"t": 40})
    return figure


def _square(counts: list[int]) -> FloatArray:
    """Arrange the counts of a pair; rows are its second variable."""
    size = math.isqrt(len(counts))
    return np.array(counts, dtype=np.float64).reshape(size, size).T


def _pair(view: View, first: str, second: str) -> tuple[list[dict[str, Any]], dict[str, Any]]:
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
    place = {"x0": view.low[i] + dx / 2, "dx": dx, "y0": view.low[j] + dy / 2, "dy": dy}
    # a byte a cell is all that colours can show
    shades = [np.round(255.0 * np.sqrt(side / top)).astype(np.uint8) for side in (direct, table)]
    steps = np.clip(np.round(errors), -5, 5).astype(np.int8)
    traces = [{**place, "z": z, "hoverinfo": "x+y", "coloraxis": "coloraxis"} for z in shades]
    traces.append({**place, "z": steps, "hoverinfo": "x+y+z", "coloraxis": "coloraxis2"})
    layout = {
        "coloraxis.colorbar.ticktext": [
            f"{float(f'{share * largest:.2g}'):g}" for share in _TICK_SHARES
        ],
        "annotations[2].text": "table minus direct<br>"
        f"{beyond} of {np.sum(judged)} cells beyond 3<br>({chance:.1f} by chance)",
        **{f"xaxis{number}.title.text": LABELS[first] for number in ("", 2, 3)},
        # there is no room between the upper two
        **{f"yaxis{number}.title.text": LABELS[second] for number in ("", 3)},
    }
    return traces, layout


def joint_densities(view: View) -> go.Figure:
    """Joint densities of a pair of variables at one condition, and how they differ; by pair."""
    figure = make_subplots(
        rows=2,
        cols=2,
        specs=[[{}, {}], [{}, None]],
        # the third one is that of the pair
        subplot_titles=("direct simulation", "table", " "),
        horizontal_spacing=0.14,
        vertical_spacing=0.22,
    )
    buttons, pairs = [], list(combinations(STATE, 2))
    for k, pair in enumerate(pairs):
        traces, layout = _pair(view, *pair)
        for trace, (row, col) in zip(traces, ((1, 1), (1, 2), (2, 1)), strict=True):
            figure.add_heatmap(**trace, row=row, col=col)
        shown = [k == other for other in range(len(pairs)) for _ in traces]
        label = " and ".join(LABELS[name] for name in pair)
        buttons.append(button(label, {"visible": shown}, layout))
    bar = {"thickness": 10, "len": 0.36, "y": 0.18, "xpad": 0}
    roots = [255.0 * math.sqrt(share) for share in _TICK_SHARES]
    density = {"x": 0.58, "title": {"text": "density", "side": "right"}, "tickvals": roots}
    errors = {"x": 0.8, "title": {"text": "standard errors", "side": "right"}}
    figure.update_layout(
        height=720,
        coloraxis={"colorscale": _SHADES, "cmin": 0, "cmax": 255, "colorbar": bar | density},
        coloraxis2={"colorscale": "RdBu_r", "cmin": -5, "cmax": 5, "colorbar": bar | errors},
        updatemenus=[menu(buttons, above=32)],
        margin={"t": 90},
    )
    figure.update_xaxes(showgrid=False, nticks=4)
    figure.update_yaxes(showgrid=False, nticks=4)
    figure.update_annotations(font={"size": 12})
    press(figure, buttons[0])
    return figure
