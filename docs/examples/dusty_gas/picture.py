"""Fields of models beside each other, and the laws of their hits."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from dusty_gas.run import GRID, Run

#: Densities at the ends of the colour scale.
_LOW, _HIGH = 0.05, 10.0

_TITLES = {
    "spheres": "spheres, regular rebound",
    "direct": "direct simulation, spin and grain kept",
    "table": "draw from the table",
}


#: Shade and dashes of the lines of each model.
_STYLES = {
    "spheres": (0.9, "-"),
    "memoryless": (0.3, ":"),
    "direct": (0.5, "-"),
    "table": (0.0, "--"),
}


def draw_fields(runs: Sequence[Run], file: Path) -> None:
    """Draw the density of particles that have hit, a row of three fields for each body.

    Parameters
    ----------
    runs : sequence of Run
        Of one Stokes number, every model for each body.
    file : Path
        A PNG.
    """
    from matplotlib.colors import LogNorm
    from matplotlib.figure import Figure
    from matplotlib.patches import Circle

    by_key = {(run.case.body, run.model): run for run in runs}
    bodies = list(dict.fromkeys(run.case.body for run in runs))
    figure = Figure(figsize=(10, 1.6 * len(bodies) + 0.9), layout="constrained")
    panels = figure.subplots(len(bodies), len(_TITLES), sharex=True, sharey=True, squeeze=False)
    right, top = GRID.left + GRID.columns * GRID.pitch, GRID.rows * GRID.pitch
    for body, row in zip(bodies, panels, strict=True):
        for model, axes in zip(_TITLES, row, strict=True):
            # cividis looks the same to readers with and without a colour-vision deficiency.
            image = axes.imshow(
                np.clip(by_key[body, model].density, _LOW, _HIGH),
                origin="lower",
                extent=(GRID.left, right, 0.0, top),
                norm=LogNorm(_LOW, _HIGH),
                cmap="cividis",
            )
            axes.add_patch(Circle((0.0, 0.0), 1.0, facecolor="white", edgecolor="black"))
            axes.set(xlim=(GRID.left, right), ylim=(0.0, top))
            if body == bodies[0]:
                axes.set_title(_TITLES[model], fontsize=10)
            if body == bodies[-1]:
                axes.set_xlabel("x / R")
        row[0].set_ylabel("cylinder\ny / R" if body == "cylinder" else "sphere\nr / R")
    bar = figure.colorbar(image, ax=panels, extend="both", shrink=0.9)
    bar.set_label("density of rebounded\nparticles / stream")
    figure.savefig(file, format="png", dpi=110)


def draw_hits(runs: Sequence[Run], file: Path) -> None:
    """Draw the laws of angle and speed of first and second hits.

    First hits, which are the same for all models, by Stokes number; second hits of the largest
    one, by model.
    """
    from matplotlib.figure import Figure

    bodies = list(dict.fromkeys(run.case.body for run in runs))
    sizes = sorted({run.case.stokes for run in runs})
    figure = Figure(figsize=(12, 3.0 * len(bodies)), layout="constrained")
    panels = figure.subplots(len(bodies), 4, squeeze=False)
    for body, row in zip(bodies, panels, strict=True):
        for run in (run for run in runs if run.case.body == body):
            if run.model == "table":
                shade = 0.9 * sizes.index(run.case.stokes) / max(1, len(sizes) - 1)
                _outline(row[:2], run.first, shade, "-", f"St {run.case.stokes:g}")
            if run.case.stokes == sizes[-1]:
                shade, style = _STYLES[run.model]
                _outline(row[2:], run.second, shade, style, f"St {sizes[-1]:g}, {run.model}")
        for k, axes in enumerate(row):
            which = "first hits" if k < 2 else "second hits"
            what = "impact angle [°]" if k % 2 == 0 else "speed [m/s]"
            axes.set(xlabel=f"{which}: {what}", ylabel=f"{body}: density", ylim=(0.0, None))
            if axes.lines:
                axes.legend(fontsize=7)
    figure.savefig(file, format="png", dpi=110)


def _outline(panels, hits, shade, style, label) -> None:
    """Histograms of angle and speed of hits, as lines."""
    from matplotlib import colormaps

    for axes, values in zip(panels, (np.degrees(hits[:, 0]), hits[:, 1]), strict=True):
        heights, edges = np.histogram(values, bins=min(30, 2 + len(values) // 50))
        heights = heights / (max(1, len(values)) * np.diff(edges))
        middle = 0.5 * (edges[1:] + edges[:-1])
        colour = colormaps["cividis"](shade)
        axes.plot(middle, heights, style, color=colour, label=label, linewidth=1.2)
