"""Figures of a report and of the README: errors against cost, accuracy map, joint laws."""

from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from sampler.formats.channels import STATE
from tablegen.config.metric_table import METRICS
from tablegen.evidence.benchmark import Benchmark
from tablegen.evidence.report import AccuracyMap
from tablegen.model.float_array import FloatArray
from tablegen.presentation import (
    ANGLE_LABEL,
    SYMBOLS,
    Picture,
    figure_style,
    legend_below,
    make_picture,
    new_figure,
)

#: Families of methods in the order of a legend: colour of Okabe and Ito, and marker.
LOOKS = {
    "table": ("#0072b2", "o"),
    "direct simulation": ("#000000", "s"),
    "stored states": ("#d55e00", "^"),
    "independent marginals": ("#cc79a7", "v"),
    "Gaussian mixture": ("#009e73", "D"),
    "kernel resampling": ("#56b4e9", "P"),
}

#: Label of the abscissa of errors.
_TIME = "time of a draw [ns, one thread]"

#: Colour map of one hue: the darker, the more.
_SHADES = "YlGnBu"

#: Part of a sample that each side of a window may leave out.
_OUTSIDE = 5e-4


def errors_picture(race: Benchmark, name: str, metrics: Sequence[str] = tuple(METRICS)) -> Picture:
    """Draw errors of all methods at one condition against the time of a draw, both logarithmic."""
    condition = f"{race.alpha_deg:g}° and {race.speed:g} m/s"
    families = {runner.family for runner in race.runners}
    with figure_style():
        rows = (len(metrics) + 1) // 2
        figure = new_figure(9.0, 1.4 + 3.6 * rows)
        for axes, metric in zip(figure.subplots(rows, 2).flat, metrics, strict=False):
            _draw_errors(axes, race, metric)
        entries: list[tuple[str, str, str, str | None]]
        entries = [(family, *look, None) for family, look in LOOKS.items() if family in families]
        entries.append(("any angle and speed", "#777777", "o", None))
        entries.append(("fitted at this one only", "#777777", "o", "white"))
        for label, colour, marker, fill in entries:
            look = {"color": colour, "marker": marker, "markerfacecolor": fill, "markersize": 8}
            figure.axes[0].plot([], [], linestyle="none", label=label, **look)
        figure.legend(loc="outside lower center", ncols=3)
        figure.suptitle(f"Error against direct simulation at {condition}", fontsize=12)
        shorts = ", ".join(METRICS[metric].short for metric in metrics)
        alternative = (
            f"Errors of {len(race.runners)} methods at {condition} ({shorts}) against "
            f"{_TIME}, both logarithmic. The numbers are in a table."
        )
        title = (
            f"Error against {_TIME} at {condition}. Look to the lower left: small errors in a "
            "short time. No method can be shown to be better than the grey band, which is noise."
        )
        return make_picture(figure, name, title, alternative)


def _draw_errors(axes: Any, race: Benchmark, metric: str) -> None:
    """Draw one error of every method; grey: the noise of direct simulation against itself."""
    least, floor = METRICS[metric].least, race.floor[metric]
    noise = max(floor.high - least, 1e-4)
    lowest = 0.4 * noise
    axes.axhspan(lowest, noise, color="#dddddd", linewidth=0)
    tables = [runner.name for runner in race.runners if runner.family == "table"]
    for runner in race.runners:
        x, error = runner.nanoseconds, runner.errors[metric]
        colour, marker = LOOKS[runner.family]
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


def map_picture(
    atlas: AccuracyMap, stored: Mapping[str, FloatArray], declared: Mapping[str, float]
) -> Picture:
    """Draw distances over angle and speed: cells of this run, and dots that the table stores."""
    shape, angles = (len(atlas.alpha_deg), len(atlas.speed)), (0.5, 5, 15, 30, 50, 70, 90)
    if len(atlas.speed) == 1:
        return _one_speed_picture(atlas, stored, declared)
    with figure_style():
        figure = new_figure(10.0, 7.0)
        for axes, (metric, allowed) in zip(
            figure.subplots(2, 2).flat, declared.items(), strict=True
        ):
            cells = np.array([point.estimates[metric].value for point in atlas.points])
            dots = _worst_of_variables(stored, metric)
            top = max(allowed, cells.max(), dots.max(initial=0.0))
            shades = {"cmap": _SHADES, "vmin": METRICS[metric].least, "vmax": top}
            roots = np.sqrt(atlas.alpha_deg)
            mesh = axes.pcolormesh(roots, atlas.speed, cells.reshape(shape).T, **shades)
            where = np.sqrt(stored["alpha_deg"]), stored["speed"]
            axes.scatter(*where, c=dots, s=60, edgecolors="black", **shades)
            shown = axes.get_xlim()
            axes.set_xticks(np.sqrt(angles), angles)
            axes.set_xlim(shown)
            axes.set(xlabel=ANGLE_LABEL, ylabel="speed [m/s]")
            axes.grid(visible=False)
            axes.set_title(f"{METRICS[metric].short}, declared: {allowed:g}")
            figure.colorbar(mesh, ax=axes)
        return make_picture(
            figure,
            "map.svg",
            "Distance of the table from direct simulation. The cells are those of this run, with "
            f"{atlas.samples:,} states from each. The dots are stored in the table, and were "
            "measured when it was made. The table is least accurate where cells are dark. Apart "
            "from noise, no value should be above the declared one.",
            "Four maps over impact angle and speed, one of each metric; the table below has the "
            "numbers.",
        )


def _worst_of_variables(stored: Mapping[str, FloatArray], metric: str) -> FloatArray:
    """Find the largest stored value of a metric at each condition, of all variables."""
    values = stored.get(metric, np.empty((len(stored["speed"]), 0)))
    worst: FloatArray = values.reshape(len(values), -1).max(axis=1, initial=METRICS[metric].least)
    return worst


def _one_speed_picture(
    atlas: AccuracyMap, stored: Mapping[str, FloatArray], declared: Mapping[str, float]
) -> Picture:
    """Draw distances over the angle, of a table that has one speed."""
    with figure_style():
        figure = new_figure(10.0, 6.4)
        for axes, (metric, allowed) in zip(
            figure.subplots(2, 2).flat, declared.items(), strict=True
        ):
            least = METRICS[metric].least
            here = [max(point.estimates[metric].value, least) for point in atlas.points]
            axes.plot(atlas.alpha_deg, here, "o-", color=LOOKS["table"][0], label="this run")
            dots = _worst_of_variables(stored, metric)
            axes.plot(stored["alpha_deg"], dots, "^", color="#d55e00", label="stored in the table")
            axes.axhline(allowed, color="#777777", linestyle="--", label="declared")
            axes.set(xlabel=ANGLE_LABEL, ylabel=METRICS[metric].short, xticks=range(0, 91, 15))
            axes.set_ylim(bottom=least)
        legend_below(figure)
        return make_picture(
            figure,
            "map.svg",
            f"Distance of the table from direct simulation, {atlas.samples:,} states from each. "
            "The table has one speed. It is as accurate as it declares if the points are below the "
            "dashed line.",
            "Four plots against the impact angle, one of each metric; the table below has the "
            "numbers.",
        )


def view_picture(drawn: FloatArray, direct: FloatArray, place: str, name: str) -> Picture:
    """Draw all marginals and joint densities of direct states (n, 6), and how the table differs."""
    low, high = np.quantile(direct, (2.0 * _OUTSIDE, 1.0 - 2.0 * _OUTSIDE), axis=0)
    high = np.maximum(high, low + 1e-6)
    beyond = judged = 0
    with figure_style():
        figure = new_figure(11.0, 10.5)
        panels = figure.subplots(6, 6, sharex="col")
        for i, j in product(range(6), repeat=2):
            axes, limits = panels[i, j], ((low[j], high[j]), (low[i], high[i]))
            axes.grid(visible=False)
            axes.tick_params(labelsize=7)
            axes.locator_params(nbins=3)
            if i == j:
                look = {"bins": 80, "range": limits[0], "density": True}
                axes.hist(direct[:, i], color="#cccccc", **look)
                axes.hist(drawn[:, i], color=LOOKS["table"][0], histtype="step", **look)
                axes.set_yticks([])
                continue
            ours, theirs = (
                np.histogram2d(side[:, j], side[:, i], 32, limits)[0].T for side in (drawn, direct)
            )
            shown, shades = np.sqrt(theirs), {"cmap": _SHADES, "vmin": 0.0}
            if i < j:
                both = ours + theirs
                shown = (ours - theirs) / np.sqrt(np.maximum(both, 1.0))
                judged += int(np.sum(both >= 20))
                beyond += int(np.sum((both >= 20) & (np.abs(shown) > 3.0)))
                shades = {"cmap": "RdBu_r", "vmin": -5.0, "vmax": 5.0}
            edges = (np.linspace(*limit, 33) for limit in limits)
            axes.pcolormesh(*edges, shown, rasterized=True, **shades)
        for k, variable in enumerate(STATE):
            panels[5, k].set_xlabel(SYMBOLS[variable])
            panels[k, 0].set_ylabel(SYMBOLS[variable])
        title = (
            f"The law at {place}, with {len(direct):,} states from each. On the diagonal the table "
            "(line) lies on direct simulation (grey). Below it is the square root of the density "
            "of direct simulation. Above it is the table minus direct simulation, from -5 (blue) "
            f"to 5 (red) standard errors. Of {judged} cells with 20 states or more, {beyond} are "
            f"beyond 3 standard errors; chance alone gives {0.0027 * judged:.0f}."
        )
        alternative = "Six by six plots of the variables of a state and of all pairs of them."
        return make_picture(figure, name, title, alternative)


class Line(NamedTuple):
    """Angles [degrees] against the numbers of hits, and the look of the line."""

    hits: Sequence[float]
    degrees: Sequence[float]
    colour: str
    style: str = "-"


def angles_picture(
    panels: Mapping[str, Mapping[str, Line]], name: str, title: str, alternative: str
) -> Picture:
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
        return make_picture(figure, name, title, alternative)


class Source(NamedTuple):
    """States (n, 6) with a title; of a single state, a point is drawn."""

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


def joint_picture(sources: Sequence[Source], name: str, title: str, alternative: str) -> Picture:
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
            if len(source.state) == 1:
                look = {"markersize": 9, "color": "#d55e00", "markeredgecolor": "white"}
                axes.plot(*source.state[0, :2], "o", **look)
                continue
            shown = np.ma.masked_equal(joint_density(source.state, u, v).T, 0.0)
            mesh = axes.pcolormesh(u, v, shown, cmap=_SHADES, norm=scale, rasterized=True)
        columns[0].set_ylabel(SYMBOLS["v"])
        figure.colorbar(mesh, ax=columns, label="density")
        figure.suptitle(title, fontsize=12)
        return make_picture(figure, name, title, alternative)
