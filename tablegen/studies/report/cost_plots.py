"""Plots of a report on cost: error against run time, bytes and set-up, with the noise of each."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import plotly.graph_objects as go

from tablegen.studies.report.benchmark import Race, Runner
from tablegen.studies.report.labels import SHORT, quantity_text
from tablegen.studies.report.method_errors import Estimate
from tablegen.studies.report.method_styles import LOOKS
from tablegen.studies.report.plot_style import FAINT, INK, axis, button, log_axis, menu, new_plot
from tablegen.studies.report.sample_size_convergence import Sample
from tablegen.studies.report.tolerances import Setting


class Cost(NamedTuple):
    """What an error is drawn against."""

    title: str
    unit: str
    of: Callable[[Runner], float]


COSTS = {
    "run time": Cost("run time of a draw, one thread", "s", lambda r: 1e-9 * r.nanoseconds),
    "bytes": Cost("what a draw reads", "B", lambda r: float(r.bytes)),
    "set-up": Cost("set-up or generation, worker time", "s", lambda r: r.setup_seconds),
}

#: What tables of other sizes vary: words, and whose colour and symbol of `LOOKS` they take.
_VARIED = {
    "base": "table",
    "nodes": "Gaussian mixture",
    "components": "independent marginals",
    "knots": "vine copula",
}


def _points(parts: Sequence[Sequence[Estimate]]) -> dict[str, Any]:
    """Means and confidence intervals of each trace."""
    bars = {"symmetric": False, "thickness": 1.2, "width": 4}
    return {
        "y": [[e.mean for e in part] for part in parts],
        "error_y": [
            {
                **bars,
                "array": [e.high - e.mean for e in part],
                "arrayminus": [e.mean - e.low for e in part],
            }
            for part in parts
        ],
    }


def _error_axis(metric: str, estimates: Sequence[Estimate]) -> dict[str, Any]:
    """Axis that holds the estimates; logarithmic but for the AUC, whose best value is 0.5."""
    if metric == "auc":
        return axis(SHORT[metric], type="linear")
    return log_axis(SHORT[metric], [end for e in estimates for end in (e.low, e.high)])


def _noise(floor: Estimate) -> list[dict[str, Any]]:
    """Band and line at what direct simulation leaves against itself."""
    common = {"xref": "paper", "x0": 0, "x1": 1, "layer": "below"}
    band = {"type": "rect", "y0": floor.low, "y1": floor.high, "fillcolor": FAINT}
    line = {"type": "line", "y0": floor.mean, "y1": floor.mean}
    return [
        {**common, **band, "line": {"width": 0}},
        {**common, **line, "line": {"color": INK, "width": 1, "dash": "dot"}},
    ]


def _show(figure: go.Figure, traces: dict[str, Any], layout: dict[str, Any]) -> None:
    """Change a figure as a menu does."""
    for key, values in traces.items():
        for trace, value in zip(figure.data, values, strict=True):
            trace[key] = value
    figure.update_layout(layout)


def _hover(runner: Runner) -> str:
    read = quantity_text(runner.bytes, "B") if runner.bytes else "nothing read"
    return (
        f"<b>{runner.family}</b><br>{runner.name}<br>{quantity_text(1e-9 * runner.nanoseconds, 's')}"
        f", {read}, set-up {runner.setup_seconds:.2g} s"
    )


def error_against_cost(
    race: Race, groups: Mapping[str, tuple[str, Sequence[Runner]]], metric: str, cost: str
) -> go.Figure:
    """Error against cost of many methods, with the noise floor.

    Parameters
    ----------
    race : Race
    groups : dict from name to (family whose look it has, runners)
    metric, cost : str
        What is shown first, of `SHORT` and `COSTS`.

    Returns
    -------
    plotly Figure
        Menus choose the error and what it is drawn against.
    """
    figure = new_plot()
    for name, (family, runners) in groups.items():
        figure.add_scatter(
            mode="markers",
            name=name,
            marker={
                "color": LOOKS[family].colour,
                "symbol": LOOKS[family].symbol,
                "size": 14 if family == "table" else 10,
            },
            text=[_hover(runner) for runner in runners],
            hovertemplate="%{text}<br>error %{y:.3g}<extra></extra>",
        )
    parts = [runners for _, runners in groups.values()]

    def of_metric(name: str) -> tuple[dict[str, Any], dict[str, Any]]:
        errors = [[runner.errors[name] for runner in runners] for runners in parts]
        every = [race.floor[name], *(e for part in errors for e in part)]
        layout = {"yaxis": _error_axis(name, every), "shapes": _noise(race.floor[name])}
        return _points(errors), layout

    def of_cost(name: str) -> tuple[dict[str, Any], dict[str, Any]]:
        title, unit, of = COSTS[name]
        # there is no place for nothing on a logarithmic axis
        costs = [[of(runner) or None for runner in runners] for runners in parts]
        every = [value for part in costs for value in part if value]
        return {"x": costs}, {"xaxis": log_axis(title, every, unit)}

    menus = []
    for above, words, names, made, first in (
        (8, "against", list(COSTS), of_cost, cost),
        (48, "error", list(SHORT), of_metric, metric),
    ):
        buttons = [button(f"{words}: {SHORT.get(name, name)}", *made(name)) for name in names]
        menus.append(menu(buttons, above, names.index(first)))
        _show(figure, *made(first))
    figure.update_layout(updatemenus=menus, margin={"t": 100})
    return figure


def methods_plot(race: Race) -> go.Figure:
    """Every method at one condition."""
    families = dict.fromkeys(runner.family for runner in race.runners)
    groups = {name: (name, [r for r in race.runners if r.family == name]) for name in families}
    return error_against_cost(race, groups, "sliced_wasserstein", "run time")


def table_sizes_plot(race: Race) -> go.Figure:
    """Tables of other sizes."""
    groups = {
        name: (family, [r for r in race.runners if r.settings["varied"] == name])
        for name, family in _VARIED.items()
    }
    return error_against_cost(race, groups, "auc", "bytes")


def sample_sizes_plot(samples: Sequence[Sample]) -> go.Figure:
    """Error of samples of growing size against the time to draw them."""
    figure = new_plot()
    families = dict.fromkeys(sample.family for sample in samples)
    parts = [[s for s in samples if s.family == family] for family in families]
    for family, part in zip(families, parts, strict=True):
        figure.add_scatter(
            mode="markers",
            name=family,
            x=[s.seconds for s in part],
            marker={"color": LOOKS[family].colour, "symbol": LOOKS[family].symbol, "size": 9},
            text=[f"{family}, {s.count:,} states" for s in part],
            hovertemplate="%{text}: %{y:.4f}<extra></extra>",
        )
    buttons = []
    for metric in (name for name in SHORT if name in samples[0].errors):
        errors = [[s.errors[metric] for s in part] for part in parts]
        layout = {"yaxis": _error_axis(metric, [e for part in errors for e in part])}
        buttons.append(button(f"error: {SHORT[metric]}", _points(errors), layout))
    _show(figure, *buttons[0]["args"])
    seconds = [s.seconds for s in samples]
    figure.update_layout(
        xaxis=log_axis("run time of the sample, one thread", seconds, "s"),
        updatemenus=[menu(buttons)],
        margin={"t": 60},
    )
    return figure


def numerics_plot(settings: Sequence[Setting]) -> go.Figure:
    """What contact resolution and flight tolerance cost and leave; large: the default."""
    figure = new_plot()
    angles = dict.fromkeys(setting.alpha_deg for setting in settings)
    for varied, family in (("resolution", "table"), ("tolerance", "stored states")):
        for angle, symbol in zip(angles, ("circle", "square", "diamond") * len(angles)):
            part = [s for s in settings if s.varied == varied and s.alpha_deg == angle]
            figure.add_scatter(
                mode="markers",
                name=f"{varied}, {angle:g}°",
                x=[1e-9 * s.nanoseconds for s in part],
                y=[s.error or None for s in part],
                error_y={"array": [s.noise for s in part], "thickness": 1.2, "width": 4},
                marker={
                    "color": LOOKS[family].colour,
                    "symbol": symbol,
                    "size": [15 if s.is_default else 8 for s in part],
                },
                text=[f"resolution {s.resolution:g}, tolerance {s.tolerance:g}" for s in part],
                hovertemplate="%{text}: %{y:.1e}<extra></extra>",
            )
    times = [1e-9 * s.nanoseconds for s in settings]
    figure.update_layout(
        xaxis=log_axis("run time of a rebound, one thread", times, "s"),
        yaxis=log_axis("largest change of a statistic", [s.error for s in settings]),
    )
    return figure
