"""Plots of a report on cost: errors against run time, bytes and set-up, with their noise."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import plotly.graph_objects as go

from tablegen.config.metric_table import METRICS
from tablegen.evidence.benchmark import Benchmark
from tablegen.evidence.method_errors import BatchMean
from tablegen.evidence.method_styles import LOOKS
from tablegen.evidence.plot_style import FAINT, INK, button, log_axis, menu, press
from tablegen.evidence.sample_size_convergence import Sample
from tablegen.evidence.tolerances import Setting


class Cost(NamedTuple):
    """What an error is drawn against."""

    title: str
    unit: str
    of: Callable[[Any], float]


_COSTS = {
    "run time": Cost("run time of a draw", "s", lambda r: 1e-9 * r.nanoseconds),
    "bytes": Cost("what a draw reads", "B", lambda r: r.bytes),
    "set-up": Cost("set-up or generation time", "s", lambda r: r.setup_seconds),
}
_SAMPLE = {"run time": Cost("run time of the sample", "s", lambda s: s.seconds)}

#: What tables of other sizes vary, and whose look of `LOOKS` they take.
_VARIED = {
    "base": "table",
    "nodes": "Gaussian mixture",
    "components": "independent marginals",
    "knots": "vine copula",
}

#: What has ``errors`` by metric, by name, with the family whose look it has.
_Groups = Mapping[str, tuple[str, Sequence[Any]]]


def _bars(estimates: Sequence[BatchMean]) -> dict[str, Any]:
    """Confidence intervals as error bars."""
    return {
        "symmetric": False,
        "thickness": 1.2,
        "width": 4,
        "array": [e.high - e.mean for e in estimates],
        "arrayminus": [e.mean - e.low for e in estimates],
    }


def _noise(floor: BatchMean) -> list[dict[str, Any]]:
    """Band and line at what direct simulation leaves against itself."""
    common = {"xref": "paper", "x0": 0, "x1": 1, "layer": "below"}
    band = {"y0": floor.low, "y1": floor.high, "fillcolor": FAINT, "line": {"width": 0}}
    line = {"y0": floor.mean, "y1": floor.mean, "line": {"color": INK, "width": 1, "dash": "dot"}}
    return [{**common, "type": "rect", **band}, {**common, "type": "line", **line}]


def _error_button(
    groups: _Groups, metric: str, floor: Mapping[str, BatchMean] | None
) -> dict[str, Any]:
    """Entry that shows a metric; logarithmic if equal laws have none of it."""
    errors = [[item.errors[metric] for item in items] for _, items in groups.values()]
    every = [e for part in errors for e in part] + ([floor[metric]] if floor else [])
    ends = [end for e in every for end in (e.low, e.high)]
    linear = {"type": "linear", "title": {"text": METRICS[metric].short}}
    return button(
        f"error: {METRICS[metric].short}",
        {"y": [[e.mean for e in part] for part in errors], "error_y": list(map(_bars, errors))},
        {
            "yaxis": linear if METRICS[metric].least else log_axis(METRICS[metric].short, ends),
            "shapes": _noise(floor[metric]) if floor else [],
        },
    )


def _error_plot(
    groups: _Groups,
    costs: Mapping[str, Cost],
    first: tuple[str, str],
    hover: Callable[[Any], str],
    floor: Mapping[str, BatchMean] | None = None,
) -> go.Figure:
    """Errors as points with bars; menus choose metric and cost, of which `first` come first."""
    figure = go.Figure()
    for name, (family, items) in groups.items():
        look = LOOKS[family]
        figure.add_scatter(
            mode="markers",
            name=name,
            marker={"color": look.colour, "symbol": look.symbol, "size": 11},
            text=[hover(item) for item in items],
            hovertemplate="%{text}<br>error %{y:.3g}<extra></extra>",
        )
    parts = [items for _, items in groups.values()]
    metrics = [name for name in METRICS if name in parts[0][0].errors]
    errors = [_error_button(groups, name, floor) for name in metrics]
    # there is no place for nothing on a logarithmic axis
    against = []
    for name, cost in costs.items():
        x = [[cost.of(item) or None for item in items] for items in parts]
        axis = log_axis(cost.title, [value for part in x for value in part if value], cost.unit)
        against.append(button(f"against: {name}", {"x": x}, {"xaxis": axis}))
    chosen = metrics.index(first[0]), list(costs).index(first[1])
    menus = [menu(errors, chosen[0], above=48), menu(against, chosen[1])]
    figure.update_layout(height=540, updatemenus=menus, margin={"t": 100})
    press(figure, errors[chosen[0]])
    press(figure, against[chosen[1]])
    return figure


def methods_plot(race: Benchmark) -> go.Figure:
    """Every method at one condition."""
    groups = {
        family: (family, found)
        for family in LOOKS
        if (found := [r for r in race.runners if r.family == family])
    }
    first = ("sliced_wasserstein", "run time")
    return _error_plot(groups, _COSTS, first, lambda r: f"{r.family}: {r.name}", race.floor)


def table_sizes_plot(race: Benchmark) -> go.Figure:
    """Tables of other sizes, by what differs from the base."""
    groups = {
        name: (family, [r for r in race.runners if r.settings["varied"] == name])
        for name, family in _VARIED.items()
    }
    return _error_plot(groups, _COSTS, ("auc", "bytes"), lambda r: r.name, race.floor)


def sample_sizes_plot(samples: Sequence[Sample]) -> go.Figure:
    """Error of samples of growing size against the time to draw them."""
    families = dict.fromkeys(sample.family for sample in samples)
    groups = {name: (name, [s for s in samples if s.family == name]) for name in families}
    first = ("ks", "run time")
    return _error_plot(groups, _SAMPLE, first, lambda s: f"{s.family}, {s.count:,} states")


def numerics_plot(settings: Sequence[Setting]) -> go.Figure:
    """Error that contact resolution and flight tolerance leave; large: the default."""
    figure, symbols = go.Figure(), ("circle", "square", "diamond")
    angles = list(dict.fromkeys(setting.alpha_deg for setting in settings))
    for varied, family in (("resolution", "table"), ("tolerance", "stored states")):
        for k, angle in enumerate(angles):
            part = [s for s in settings if s.varied == varied and s.alpha_deg == angle]
            marker = {"color": LOOKS[family].colour, "symbol": symbols[k % len(symbols)]}
            figure.add_scatter(
                mode="markers",
                name=f"{varied}, {angle:g}°",
                x=[1e-9 * s.nanoseconds for s in part],
                y=[s.error or None for s in part],
                error_y={"array": [s.noise for s in part], "thickness": 1.2, "width": 4},
                marker=marker | {"size": [15 if s.is_default else 8 for s in part]},
                text=[f"resolution {s.resolution:g}, tolerance {s.tolerance:g}" for s in part],
                hovertemplate="%{text}: %{y:.1e}<extra></extra>",
            )
    figure.update_layout(
        height=460,
        xaxis=log_axis("run time of a rebound", (1e-9 * s.nanoseconds for s in settings), "s"),
        yaxis=log_axis("largest change of a statistic", (s.error for s in settings)),
    )
    return figure
