"""The picture: where parcels hit the outer wall, and what hits it, place by place."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from many_hits.picture import LOOKS
from matplotlib.colors import LogNorm
from wall_impacts_picture import draw_walls

from openfoam_bend.walls import INNER, OUTER, SPEED, TURN, injected
from tablegen.presentation import Picture, new_figure, settings, written

#: Edges of cells on the outer wall, along the middle line and across, m.
MAP_EDGES = (np.linspace(-0.05, 0.45, 101), np.linspace(0.0, OUTER - INNER, 21))


def _draw_map(axes: Any, model: str, place: np.ndarray, depth: np.ndarray) -> Any:
    """Impacts a parcel and square metre, on the wall laid flat."""
    counts = np.histogram2d(place, depth, bins=MAP_EDGES)[0]
    density = counts / injected().sum() / np.outer(*map(np.diff, MAP_EDGES))
    shown = np.where(counts > 0, density, np.nan).T
    image = axes.pcolormesh(*MAP_EDGES, shown, norm=LogNorm(1.0, 1000.0), cmap="viridis")
    for end in (0.0, TURN):
        axes.axvline(end, color="black", linewidth=0.8, linestyle=":")
    axes.set_title(LOOKS[model].label, loc="left")
    axes.set(xlabel="place along the duct, from its bend on [m]", xlim=MAP_EDGES[0][[0, -1]])
    return image


def bend_picture(
    maps: Mapping[str, tuple[np.ndarray, np.ndarray]], walls: Mapping[str, Mapping[str, Any]]
) -> Picture:
    """Draw the outer wall.

    Parameters
    ----------
    maps : mapping of str to tuple
        Places along and across [m] of the impacts, by model.
    walls : mapping of str to mapping
        `wall_impacts.wall_numbers` by model.
    """
    with settings():
        figure = new_figure(13.0, 9.5)
        above, below = figure.subfigures(2, 1, height_ratios=(1.0, 2.4))
        flat = above.subplots(1, len(maps), sharey=True)
        for axes, (model, (place, depth)) in zip(flat, maps.items(), strict=True):
            image = _draw_map(axes, model, place, depth)
        flat[0].set_ylabel("across the duct [m]")
        above.colorbar(image, ax=list(flat), label="impacts a parcel\nand square metre")
        panels = below.subplots(2, 3).ravel()
        draw_walls(panels, walls, TURN)
        handles, labels = panels[0].get_legend_handles_labels()
        below.legend(handles, labels, loc="outside lower center", ncols=len(labels))
        return written(
            figure,
            "openfoam_bend.png",
            "Sand on the outer wall of a bend",
            f"Impacts on the outer wall of a bend in OpenFOAM at {SPEED:g} m/s: maps of three wall "
            "models, and rates, speeds, angles and energies along the wall.",
        )
