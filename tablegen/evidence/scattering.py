"""Figures 11 to 13: angles of the rebound, scattering indicatrices in space and in the plane."""

from typing import Any

import numpy as np
from scipy.ndimage import gaussian_filter, gaussian_filter1d

from tablegen.evidence.sample_statistics import (
    DIRECT,
    SCATTERING_BINS,
    SPATIAL_BINS,
    TABLE,
    FigureStatistics,
    SampleStatistics,
)
from tablegen.model.float_array import FloatArray
from tablegen.presentation import (
    MIXTURE,
    TABLE_COLOUR,
    Picture,
    new_figure,
    numbered,
)

#: Impact angles of the plane indicatrices.
_ANGLES = (15.0, 30.0, 45.0, 60.0, 75.0, 90.0)

_SPHERE_COLOUR = "#d1261b"


def _direction(alpha2: Any, beta2: Any) -> tuple[Any, Any, Any]:
    """Components x, y, z of a direction of rebound."""
    return np.cos(beta2) * np.cos(alpha2), np.cos(beta2) * np.sin(alpha2), np.sin(beta2)


def _angles_figure() -> Picture:
    """Sketch of the angles alpha2 and beta2."""
    figure = new_figure(5.6, 3.6)
    axes = figure.add_subplot(projection="3d")
    alpha2, beta2 = np.radians(50.0), np.radians(38.0)
    x, y, z = _direction(alpha2, beta2)
    # the plot's vertical axis is y; its depth is -z, so that the frame is right-handed
    wall = np.meshgrid((-0.9, 0.9), (-0.7, 0.7))
    axes.plot_surface(*wall, np.zeros((2, 2)), color="#cccccc", alpha=0.3, shade=False)
    for name, end in (("x", (1.25, 0, 0)), ("y", (0, 0, 1.15)), ("z", (0, -0.95, 0))):
        axes.plot(*zip((0, 0, 0), end, strict=True), color="#666666", linewidth=1)
        axes.text(*(1.06 * np.array(end)), name)
    axes.quiver(-0.9, 0, 0.9, 0.85, 0, -0.85, color="black", arrow_length_ratio=0.1)
    axes.quiver(0, 0, 0, x, -z, y, color="#0072b2", linewidth=2, arrow_length_ratio=0.1)
    axes.plot([0, np.cos(alpha2)], [0, 0], [0, np.sin(alpha2)], color="#0072b2", linestyle=":")
    turn = np.linspace(0.0, alpha2, 30)
    axes.plot(0.5 * np.cos(turn), 0 * turn, 0.5 * np.sin(turn), color="#d55e00")
    axes.text(0.6, 0, 0.12, r"$\alpha_2$", color="#a34700")
    tilt = np.linspace(0.0, beta2, 30)
    tx, ty, tz = _direction(alpha2, tilt)
    axes.plot(0.75 * tx, -0.75 * tz, 0.75 * ty, color="#007d5a")
    axes.text(0.36, -0.25, 0.68, r"$\beta_2$", color="#007d5a")
    axes.text(-1.0, 0, 0.95, "before")
    axes.text(x + 0.1, -z, y + 0.02, "after", color="#0072b2")
    axes.set(xlim=(-1, 1), ylim=(-1, 1), zlim=(0, 1.1))
    axes.set_box_aspect((2, 2, 1.1), zoom=1.4)
    axes.set_axis_off()
    axes.view_init(elev=20, azim=-78)
    alternative = (
        "Sketch: a particle comes down in the plane of x along the wall and y into the gas, and "
        "leaves in a direction whose projection on that plane makes the angle alpha 2 with x; beta "
        "2 is the angle between the direction and the plane."
    )
    return numbered(figure, 11, "Angles of the rebound", alternative, "png")


def _surface(sample: SampleStatistics) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Points of the spatial indicatrix, and its values."""
    counts = gaussian_filter(sample.spatial.astype(np.float64), 1.5, mode="nearest")
    cell = (np.pi / SPATIAL_BINS[0]) * (np.pi / SPATIAL_BINS[1])
    values = counts / (sample.count * cell)
    alpha2 = (np.arange(SPATIAL_BINS[0]) + 0.5) * np.pi / SPATIAL_BINS[0]
    beta2 = (np.arange(SPATIAL_BINS[1]) + 0.5) * np.pi / SPATIAL_BINS[1] - np.pi / 2
    x, y, z = _direction(*np.meshgrid(alpha2, beta2, indexing="ij"))
    return values * x, values * y, values * z, values


def _draw_surface(axes: Any, sample: SampleStatistics, top: float) -> None:
    from matplotlib import colormaps

    x, y, z, values = _surface(sample)
    colours = colormaps["viridis"](values / top)
    axes.plot_surface(x, -z, y, facecolors=colours, rstride=1, cstride=1, linewidth=0, shade=False)
    axes.set(xlim=(-top, top), ylim=(-top, top), zlim=(0, top))
    axes.set_box_aspect((2, 2, 1), zoom=1.15)
    axes.set_xlabel("x")
    axes.set_ylabel("−z")
    axes.set_zlabel("y")
    axes.tick_params(labelsize=8)
    axes.view_init(elev=22, azim=-60)


def _spatial_figure(statistics: FigureStatistics) -> Picture | None:
    """Spatial indicatrices at normal impact."""
    panels = [
        ("(a) prisms, direct", statistics.at(DIRECT, "prism", 90.0)),
        ("(b) truncated prisms, direct", statistics.at(DIRECT, "truncated-prism", 90.0)),
        ("mixture, direct", statistics.at(DIRECT, MIXTURE, 90.0)),
        ("mixture, table", statistics.at(TABLE, MIXTURE, 90.0)),
    ]
    drawn = [(title, sample) for title, sample in panels if sample is not None]
    top = max(float(_surface(sample)[3].max()) for _, sample in drawn)
    figure = new_figure(11.0, 7.4)
    for k, (title, sample) in enumerate(drawn):
        axes = figure.add_subplot(2, 2, k + 1, projection="3d")
        _draw_surface(axes, sample, top)
        axes.set_title(title)
    alternative = (
        "Surfaces whose distance from the origin is the probability density of the direction of "
        "rebound in alpha 2 and beta 2, at normal impact and 200 m/s: prisms, truncated prisms, "
        "and the mixture from direct simulation and from the table."
    )
    title = "Spatial scattering indicatrices at normal impact"
    return numbered(figure, 12, title, alternative, "png")


def _round_ticks(top: float) -> list[float]:
    """Two to four round numbers up to the top."""
    step = 10.0 ** np.floor(np.log10(top))
    step *= next(x for x in (0.2, 0.5, 1.0, 2.0, 5.0) if top / (x * step) < 4.5)
    return [float(k * step) for k in range(1, int(top / step) + 1)]


def _draw_plane(axes: Any, statistics: FigureStatistics, alpha_deg: float) -> None:
    """One plane indicatrix with the incident and the spherical direction."""
    edges = np.linspace(0.0, np.pi, SCATTERING_BINS + 1)
    centres, top = 0.5 * (edges[1:] + edges[:-1]), 0.0
    for source in (DIRECT, TABLE):
        sample = statistics.at(source, MIXTURE, alpha_deg)
        if sample is None:
            continue
        counts = gaussian_filter1d(sample.scattering.astype(np.float64), 1.0)
        density = counts / (sample.count * (edges[1] - edges[0]))
        top = max(top, float(density.max()))
        if source == DIRECT:
            axes.fill(centres, density, color="#9fb6c9", label="mixture, direct")
        else:
            axes.plot(centres, density, color=TABLE_COLOUR, linewidth=1.4, label="mixture, table")
    sphere = np.radians(statistics.sphere_deg[alpha_deg][0])
    axes.plot([0, sphere], [0, 1.05 * top], color=_SPHERE_COLOUR, linestyle="--", label="spheres")
    incident = np.pi - np.radians(alpha_deg)
    axes.annotate(
        "",
        xy=(incident, 0.12 * top),
        xytext=(incident, 1.1 * top),
        arrowprops={"arrowstyle": "-|>", "color": "black", "linewidth": 1.6},
    )
    axes.set(thetamin=0, thetamax=180, rlim=(0.0, 1.12 * top))
    axes.set_xticks(np.radians(range(0, 181, 30)))
    axes.tick_params(labelsize=8)
    axes.set_rlabel_position(0)
    axes.set_yticks(_round_ticks(1.1 * top))
    axes.set_title(rf"$\alpha_1$ = {alpha_deg:g}°", y=0.98)


def _plane_figure(statistics: FigureStatistics) -> Picture:
    """Plane indicatrices of the mixture."""
    figure = new_figure(11.0, 6.0)
    for k, alpha_deg in enumerate(_ANGLES):
        axes = figure.add_subplot(2, 3, k + 1, projection="polar")
        _draw_plane(axes, statistics, alpha_deg)
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3)
    angles = ", ".join(f"{angle:g}" for angle in _ANGLES)
    alternative = (
        f"Polar plots of the density of the rebound angle alpha 2 in the impact plane for the "
        f"mixture at impact angles of {angles} degrees and 200 m/s, direct simulation as an area "
        "and the table as a line; a black arrow shows the incident particles, a red dashed line "
        "the direction in which spheres leave."
    )
    return numbered(figure, 13, "Scattering indicatrices in the impact plane", alternative)


def scattering_figures(statistics: FigureStatistics) -> list[Picture]:
    """Draw the directions of rebound."""
    pictures = (_angles_figure(), _spatial_figure(statistics), _plane_figure(statistics))
    return [picture for picture in pictures if picture is not None]
