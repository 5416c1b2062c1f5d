"""Pictures of what hits a wall, place by place."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from many_hits.picture import LOOKS
from wall_impacts import QUANTITIES


def draw_walls(panels: Sequence[Any], walls: Mapping[str, Mapping[str, Any]], turn: float) -> None:
    """Draw quantities along a wall, with bars of one standard error; grey is within the bend.

    Parameters
    ----------
    panels : sequence of matplotlib axes
        One for each of `QUANTITIES`.
    walls : mapping of str to mapping
        `wall_impacts.wall_numbers` of each model.
    turn : float
        Length of the bend along the middle line, m.
    """
    for axes, name in zip(panels, QUANTITIES, strict=True):
        axes.axvspan(0.0, turn, color="#eeeeee", linewidth=0)
        for model, numbers in walls.items():
            look, edges = LOOKS[model], np.array(numbers["edges"])
            found = {key: np.array(x, dtype=float) for key, x in numbers["fine"][name].items()}
            axes.errorbar(
                0.5 * (edges[1:] + edges[:-1]),
                found["value"],
                yerr=found["error"],
                color=look.colour,
                marker=look.marker,
                linestyle=look.dashes,
                markersize=3,
                label=look.label,
            )
        axes.set_title(QUANTITIES[name], loc="left")
        axes.set(ylim=(0.0, None), xlim=(edges[0], edges[-1]))
        axes.set_xlabel("place along the duct, from its bend on [m]")
