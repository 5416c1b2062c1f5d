"""Pictures of the evidence: errors against cost, joint laws, and angles along chains of hits."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from tablegen.config.metric_table import METRICS
from tablegen.evidence.error_against_time import Benchmark
from tablegen.model.float_array import FloatArray
from tablegen.presentation import SYMBOLS, figure_style, legend_below, make_picture, new_figure

#: Families of methods in the order of a legend: colour of Okabe and Ito, and marker.
LOOKS = {"table": ("#0072b2", "o"), "direct simulation": ("#000000", "s")}

#: Label of the abscissa of errors.
_TIME = "time of a draw [ns, one thread]"

#: Part of a sample that each side of a window may leave out.
_OUTSIDE = 5e-4


def errors_picture(
    race: Benchmark,
    name: str,
    metrics: Sequence[str] = ("auc", "ks"),
    looks: Mapping[str, tuple[str, str]] = LOOKS,
) -> bytes:
    """Draw errors of all methods at one condition against the time of a draw, both logarithmic.

    The name of the file selects the format. Symbols of methods that hold at one condition only are
    open.
    """
    families = {runner.family for runner in race.runners}
    with figure_style():
        rows = (len(metrics) + 1) // 2
        figure = new_figure(9.0, 1.4 + 3.6 * rows)
        for axes, metric in zip(figure.subplots(rows, 2).flat, metrics, strict=False):
            _draw_errors(axes, race, metric, looks)
        entries: list[tuple[str, str, str, str | None]]
        entries = [(family, *look, None) for family, look in looks.items() if family in families]
        if len({runner.covers for runner in race.runners}) > 1:
            entries.append(("any angle and speed", "#777777", "o", None))
            entries.append(("fitted at this one only", "#777777", "o", "white"))
        for label, colour, marker, fill in entries:
            look = {"color": colour, "marker": marker, "markerfacecolor": fill, "markersize": 8}
            figure.axes[0].plot([], [], linestyle="none", label=label, **look)
        figure.legend(loc="outside lower center", ncols=3)
        condition = f"{race.alpha_deg:g}° and {race.speed:g} m/s"
        figure.suptitle(f"Error against direct simulation at {condition}", fontsize=12)
        return make_picture(figure, name)


def _draw_errors(
    axes: Any, race: Benchmark, metric: str, looks: Mapping[str, tuple[str, str]]
) -> None:
    """Draw one error of every method; grey: the noise of direct simulation against itself."""
    least, floor = METRICS[metric].least, race.floor[metric]
    noise = max(floor.high - least, 1e-4)
    lowest = 0.4 * noise
    axes.axhspan(lowest, noise, color="#dddddd", linewidth=0)
    tables = [runner.name for runner in race.runners if runner.family == "table"]
    for runner in race.runners:
        x, error = runner.nanoseconds, runner.errors[metric]
        colour, marker = looks[runner.family]
        # errors that cannot be told from none stand at the lower edge
        low, y, high = np.maximum(
            np.array([error.low, error.mean, error.high]) - least, 1.4 * lowest
        )
        axes.plot([x, x], [low, high], color=colour, linewidth=1.2)
        fill = colour if runner.covers == "domain" else "white"
        look = {"color": colour, "marker": marker, "markerfacecolor": fill, "markersize": 8}
        axes.plot(x, y, "none", zorder=3 if runner.family == "table" else 2, **look)
        coarse = runner.family == "direct simulation" and error.mean - least > 2.0 * noise
        if coarse or (runner.name in tables and len(tables) > 1):
            words = runner.name.removeprefix(f"{tables[0]}-").replace(" ", "\n", 1)
            # direct simulation stands at the right edge, and tables often stand together
            left = coarse or runner.name == tables[0]
            axes.annotate(
                words,
                (x, y),
                color=colour,
                xytext=(-8 if left else 8, 0),
                textcoords="offset points",
                ha="right" if left else "left",
                va="center",
                fontsize=9,
            )
    title = METRICS[metric].label + (f", above {least:g}" if least else "")
    axes.set(xscale="log", yscale="log", xlabel=_TIME)
    _set_log_ticks(axes)
    axes.set_ylim(bottom=lowest)
    axes.set_title(title, loc="left", fontsize=10)
    axes.text(0.02, 0.02, "noise of direct simulation", transform=axes.transAxes, fontsize=9)


def _set_log_ticks(axes: Any) -> None:
    """Write 1, 2, 5, 10, ... on two logarithmic axes."""
    from matplotlib.ticker import LogLocator, NullLocator

    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.set_major_formatter("{x:g}")
        axis.set_minor_locator(NullLocator())


class Line(NamedTuple):
    """Angles [degrees] against the numbers of hits, and the look of the line."""

    hits: Sequence[float]
    degrees: Sequence[float]
    colour: str
    style: str = "-"


def angles_picture(panels: Mapping[str, Mapping[str, Line]], name: str) -> bytes:
    """Draw median angles at which grains leave walls against hits, by title of a panel and label.

    Both axes are logarithmic.
    """
    with figure_style():
        figure = new_figure(10.0, 4.8)
        columns = figure.subplots(1, len(panels), sharey=True, squeeze=False)[0]
        for axes, (words, lines) in zip(columns, panels.items(), strict=True):
            for label, line in lines.items():
                look = {"color": line.colour, "linestyle": line.style, "linewidth": 1.6}
                axes.plot(line.hits, line.degrees, label=label, **look)
            axes.set(xscale="log", yscale="log", xlabel="number of the hit")
            _set_log_ticks(axes)
            axes.set_title(words, loc="left")
        columns[0].set_ylabel("median angle to the wall at which grains leave [°]")
        legend_below(figure, columns=4)
        return make_picture(figure, name)


class Source(NamedTuple):
    """States (n, 6) with a title."""

    title: str
    state: FloatArray


def window(state: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Choose edges of square bins for u and for v, from 0, that hold most states (n, 6)."""
    low, high = np.quantile(state[:, 0], (_OUTSIDE, 1.0 - _OUTSIDE))
    low, high = low - 0.02, high + 0.02
    top = np.quantile(state[:, 1], 1.0 - _OUTSIDE) + 0.02
    step = max(high - low, top) / np.clip(np.sqrt(len(state)) / 4.0, 20, 120)
    return (
        low + step * np.arange(np.ceil((high - low) / step) + 1),
        step * np.arange(np.ceil(top / step) + 1),
    )


def joint_density(state: FloatArray, u: FloatArray, v: FloatArray) -> FloatArray:
    """Density of u and v in bins with these edges; states outside count in the total."""
    counts, _, _ = np.histogram2d(state[:, 0], state[:, 1], bins=(u, v))
    density: FloatArray = counts / (len(state) * (u[1] - u[0]) * (v[1] - v[0]))
    return density


def joint_picture(sources: Sequence[Source], name: str, title: str) -> bytes:
    """Draw the joint densities of u and v of several sources, the first of which is a sample.

    All have one window and one scale, those of the first.
    """
    from matplotlib.colors import PowerNorm

    u, v = window(sources[0].state)
    # the square root lets thin parts be seen next to the peak
    scale = PowerNorm(0.5, vmin=0.0, vmax=joint_density(sources[0].state, u, v).max())
    with figure_style():
        height = 1.2 + 2.7 * (v[-1] - v[0]) / (u[-1] - u[0])
        figure = new_figure(2.9 * len(sources) + 1.3, height)
        columns = figure.subplots(1, len(sources), sharey=True, squeeze=False)[0]
        for axes, source in zip(columns, sources, strict=True):
            axes.set(xlabel=SYMBOLS["u"], xlim=(u[0], u[-1]), ylim=(v[0], v[-1]), aspect="equal")
            axes.set_title(source.title)
            shown = np.ma.masked_equal(joint_density(source.state, u, v).T, 0.0)
            mesh = axes.pcolormesh(u, v, shown, cmap="YlGnBu", norm=scale, rasterized=True)
        columns[0].set_ylabel(SYMBOLS["v"])
        figure.colorbar(mesh, ax=columns, label="density")
        figure.suptitle(title, fontsize=12)
        return make_picture(figure, name)
