"""Figures 3 to 10, 12 and 13 of the paper, drawn from `FigureStatistics`."""

from functools import partial
from itertools import chain
from typing import Any

import numpy as np
from paper_statistics import (
    DENSITY,
    DOUBLED,
    SCATTERING_BINS,
    SPATIAL_BINS,
    TABLE,
    FigureStatistics,
    SampleStatistics,
)
from scipy.ndimage import gaussian_filter, gaussian_filter1d

from tablegen.config.defaults import MIXTURE
from tablegen.model.float_array import FloatArray
from tablegen.presentation import (
    ANGLE_LABEL,
    COLOURS,
    figure_style,
    legend_below,
    make_picture,
    new_figure,
)

#: Figures against the impact angle: by number, the quantities of both panels.
_CURVES = {
    3: (("u", "mean"), ("u", "mode")),
    4: (("v", "mean"), ("v", "mode")),
    7: (("omega_z", "mean"), ("omega_z", "mode")),
    9: (("translational", "mean"), ("rotational", "mean")),
    10: (("translational", "mode"), ("rotational", "mode")),
}

#: Figures of densities: by number, the variable.
_DENSITIES = {5: "u", 6: "v", 8: "omega_z"}

MARKERS = {
    "ellipsoid": "o",
    "prism": "s",
    "truncated-prism": "^",
    "tetrahedron": "D",
    "mixture": ".",
}

#: Colour of what was drawn from the table.
TABLE_COLOUR = "#e08a00"

#: Symbols of quantities on axes.
SYMBOLS = {
    "u": r"$u^+/V$",
    "v": r"$v^+/V$",
    "omega_z": r"$\Omega_z^+\,a/V$",
    "translational": r"$E_V^+/E_V^-$",
    "rotational": r"$E_\Omega^+/E_V^-$",
}

#: Part of the highest density below which tails are not drawn.
_TAIL = 0.004

#: Angles of the densities with their colours and line styles, and angles of the indicatrices.
_DENSITY_ANGLES = {
    15.0: ("#440154", "-"),
    30.0: ("#3b528b", "--"),
    45.0: ("#21918c", "-."),
    60.0: ("#35a048", ":"),
    90.0: ("#c77700", "-"),
}
_INDICATRIX_ANGLES = (15.0, 30.0, 45.0, 60.0, 75.0, 90.0)

#: Bins over which a spatial indicatrix is smoothed.
_BLUR = 3.0

#: Words on what is simulated with twice the resistance.
_DOUBLED_WORDS = "twice the resistance"


def paper_pictures(statistics: FigureStatistics) -> dict[str, bytes]:
    """Draw every figure; the files by name."""
    figures = {
        f"figure-{number:02d}.svg": partial(_curve_figure, panels=panels)
        for number, panels in _CURVES.items()
    }
    figures |= {
        f"figure-{number:02d}.svg": partial(_density_figure, name=name)
        for number, name in _DENSITIES.items()
    }
    figures |= {"figure-12.png": _spatial_figure, "figure-13.svg": _plane_figure}
    with figure_style():
        return {name: make_picture(draw(statistics), name) for name, draw in figures.items()}


def _grains(statistics: FigureStatistics) -> str:
    """Name the whole population: a mixture if it has several shapes."""
    return MIXTURE if set(statistics.curves) > {MIXTURE, TABLE} else "grains"


def _curve_figure(statistics: FigureStatistics, panels: tuple[tuple[str, str], ...]) -> Any:
    """Draw means or most probable values against the impact angle."""
    figure = new_figure(9.5, 4.6)
    columns = figure.subplots(1, 2)
    for axes, letter, (quantity, which) in zip(columns, "ab", panels, strict=True):
        curves = statistics.curves.items(), {DOUBLED: statistics.doubled.get(MIXTURE, {})}.items()
        for name, curve in chain(*curves):
            having = [s for s in curve.values() if quantity in s.mean]
            values = np.array([getattr(s, which)[quantity] for s in having])
            if (which, quantity) == ("mode", "u") and having and having[-1].alpha_deg == 90.0:
                # of two equal maxima at normal impact the paper shows the positive one
                values[-1] = abs(values[-1])
            label = _grains(statistics) if name in (MIXTURE, TABLE, DOUBLED) else name
            _draw_curve(axes, name, label, [s.alpha_deg for s in having], values)
        words = "most probable" if which == "mode" else "mean"
        axes.set(xlabel=ANGLE_LABEL, ylabel=f"{words} {SYMBOLS[quantity]}", xlim=(0, 92))
        axes.set_xticks(range(0, 91, 15))
        axes.set_title(f"({letter}) {words}", loc="left")
    legend_below(figure)
    return figure


def _draw_curve(axes: Any, name: str, label: str, x: list[float], y: FloatArray) -> None:
    if not x:
        return
    if name == DOUBLED:
        axes.plot(x, y, color=COLOURS[MIXTURE], linestyle="--", label=f"{label}, {_DOUBLED_WORDS}")
    elif name != TABLE:
        look = {"color": COLOURS[name], "marker": MARKERS[name], "markersize": 4}
        width = 2.2 if name == MIXTURE else 1.2
        axes.plot(x, y, linewidth=width, label=f"{label}, simulated", **look)
    else:
        look = {"color": TABLE_COLOUR, "marker": "o", "markersize": 9, "markeredgewidth": 1.8}
        look |= {"linestyle": "none", "markerfacecolor": "none"}
        axes.plot(x, y, label=f"{label}, table", **look)


def _density(counts: FloatArray, size: int, width: float) -> FloatArray:
    """Smoothed density from the counts of a sample in bins of a width."""
    return np.asarray(gaussian_filter1d(counts, 1.0)) / (size * width)


def _density_figure(statistics: FigureStatistics, name: str) -> Any:
    """Draw the densities of two shapes, in the paper ellipsoids and prisms, and of the mixture."""
    low, high, bins = DENSITY[name]
    centres = low + (np.arange(bins) + 0.5) * (high - low) / bins
    shapes = [*(shape for shape in statistics.curves if shape not in (MIXTURE, TABLE))][:2]
    figure = new_figure(0.5 + max(3.7 * (len(shapes) + 1), 6.0), 4.5)
    panels = figure.subplots(1, len(shapes) + 1, squeeze=False)[0]
    shown = np.zeros(bins, dtype=np.bool_)
    for axes, shape in zip(panels, (*shapes, MIXTURE), strict=True):
        whole = f"{_grains(statistics)}: areas simulated, lines table"
        axes.set_title(whole if shape == MIXTURE else f"{shape}, simulated")
        for alpha_deg, (colour, style) in _DENSITY_ANGLES.items():
            samples = {kind: statistics.curves[kind].get(alpha_deg) for kind in (shape, TABLE)}
            density = {
                kind: _density(sample.density[name], sample.count, (high - low) / bins)
                for kind, sample in samples.items()
                if sample is not None
            }
            if shape in density:
                shown |= density[shape] > _TAIL * density[shape].max()
            look = {"color": colour, "label": f"{alpha_deg:g}°"}
            if shape != MIXTURE:
                axes.plot(centres, density[shape], style, **look)
                continue
            if shape in density:
                axes.fill_between(centres, density[shape], alpha=0.28, linewidth=0, **look)
            if TABLE in density:
                axes.plot(centres, density[TABLE], color=colour, linewidth=1.1)
        axes.set_xlabel(SYMBOLS[name])
        axes.set_ylim(bottom=0.0)
    for axes in panels:
        axes.set_xlim(*centres[np.flatnonzero(shown)[[0, -1]]])
    panels[0].set_ylabel("density")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=5, title=ANGLE_LABEL)
    return figure


def _surface(sample: SampleStatistics) -> tuple[FloatArray, FloatArray]:
    """Compute points of the spatial indicatrix, (3, n, m): x, -z and y; and its values, (n, m)."""
    rows, columns = SPATIAL_BINS
    counts = gaussian_filter(sample.spatial, _BLUR, mode="nearest")
    values = counts / (sample.count * (np.pi / rows) * (np.pi / columns))
    alpha2 = (np.arange(rows)[:, None] + 0.5) * np.pi / rows
    beta2 = (np.arange(columns) + 0.5) * np.pi / columns - np.pi / 2
    along = np.cos(beta2) * np.cos(alpha2), -np.sin(beta2) + 0.0 * alpha2
    return values * np.array([*along, np.cos(beta2) * np.sin(alpha2)]), values


def _spatial_figure(statistics: FigureStatistics) -> Any:
    from matplotlib import colormaps

    panels = {
        "prism": "prisms, simulated",
        "truncated-prism": "truncated prisms, simulated",
        MIXTURE: f"{_grains(statistics)}, simulated",
        TABLE: f"{_grains(statistics)}, table",
    }
    samples = {
        panels[name]: curve.get(90.0) for name, curve in statistics.curves.items() if name in panels
    }
    drawn = [(title, *_surface(sample)) for title, sample in samples.items() if sample is not None]
    top = max(float(values.max()) for _, _, values in drawn)
    # nearly round grains leave in a narrow cone
    side = max(float(np.abs(points[:2]).max()) for _, points, _ in drawn)
    stride = 2 if side > 0.3 * top else 1
    rows = -(-len(drawn) // 2)
    figure = new_figure(11.0, 3.7 * rows)
    for k, (title, points, values) in enumerate(drawn):
        axes = figure.add_subplot(rows, 2, k + 1, projection="3d")
        colours = colormaps["viridis"](values / top)
        axes.plot_surface(
            *points, facecolors=colours, rstride=stride, cstride=stride, linewidth=0, shade=0
        )
        axes.set(xlim=(-side, side), ylim=(-side, side), zlim=(0, top))
        axes.set_box_aspect((2, 2, min(top / side, 2.0)), zoom=1.15)
        axes.set(xlabel="x", ylabel="−z", zlabel="y", title=title)
        axes.tick_params(labelsize=8)
        axes.locator_params(nbins=5)
        axes.view_init(elev=22, azim=-60)
    return figure


def _draw_plane(axes: Any, statistics: FigureStatistics, alpha_deg: float) -> None:
    """Draw one plane indicatrix with the directions of incidence and of spheres."""
    from matplotlib.ticker import MaxNLocator

    width, top = np.pi / SCATTERING_BINS, 0.0
    centres = (np.arange(SCATTERING_BINS) + 0.5) * width
    curves = statistics.curves | {DOUBLED: statistics.doubled.get(MIXTURE, {})}
    grains = _grains(statistics)
    for name in (MIXTURE, TABLE, DOUBLED):
        sample = curves[name].get(alpha_deg)
        if sample is None:
            continue
        density = _density(sample.scattering, sample.count, width)
        top = max(top, float(density.max()))
        if name == MIXTURE:
            axes.fill(centres, density, color="#9fb6c9", label=f"{grains}, simulated")
        elif name == DOUBLED:
            axes.plot(
                centres, density, color="black", linestyle=":", label=f"{grains}, {_DOUBLED_WORDS}"
            )
        else:
            axes.plot(centres, density, color=TABLE_COLOUR, linewidth=1.4, label=f"{grains}, table")
    sphere, incident = statistics.spheres[alpha_deg], np.radians(180 - alpha_deg)
    axes.plot([0, sphere], [0, 1.05 * top], color="#d1261b", linestyle="--", label="spheres")
    arrow = {"arrowstyle": "-|>", "color": "black", "linewidth": 1.6}
    ends = {"xy": (incident, 0.12 * top), "xytext": (incident, 1.1 * top)}
    axes.annotate("", **ends, arrowprops=arrow)
    axes.set(thetamin=0, thetamax=180, rlim=(0.0, 1.12 * top))
    axes.set_xticks(np.radians(range(0, 181, 30)))
    axes.yaxis.set_major_locator(MaxNLocator(4))
    axes.tick_params(labelsize=8)
    axes.set_rlabel_position(0)
    axes.set_title(rf"$\alpha_1$ = {alpha_deg:g}°", y=0.98)


def _plane_figure(statistics: FigureStatistics) -> Any:
    figure = new_figure(11.0, 6.0)
    for k, alpha_deg in enumerate(_INDICATRIX_ANGLES):
        axes = figure.add_subplot(2, 3, k + 1, projection="polar")
        _draw_plane(axes, statistics, alpha_deg)
    legend_below(figure)
    return figure
