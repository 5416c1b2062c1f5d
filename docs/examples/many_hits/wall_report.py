"""What hits the walls of a flow, place by place."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from wall_impacts import Impacts, wall_numbers, walls_text

from many_hits.cases import GROUPS, Flow
from many_hits.duct import Bend
from many_hits.flow import RECORD

#: Cells of a bend's turn; those behind it have the same length.
_CELLS = 12

WALLS = ("outer", "inner")


def turn_of(bend: Bend) -> float:
    """Length of a bend's turn along its middle line, m."""
    return 0.5 * math.pi * bend.middle


def _edges(bend: Bend) -> np.ndarray:
    """Edges of cells in the turn and behind it, an even number of cells."""
    cell = turn_of(bend) / _CELLS
    behind = 2 * int(bend.behind / cell / 2.0)
    return cell * np.arange(_CELLS + behind + 1)


def stage_walls(flow: Flow, number: int, bend: Bend, speed: float) -> dict[str, Any]:
    """`wall_numbers` of both walls of a bend.

    Parameters
    ----------
    flow : Flow
    number : int
        Of the bend.
    bend : Bend
    speed : float
        At the inlet, m/s.
    """
    column = dict(zip(RECORD, flow.records.T, strict=True))
    group = flow.group[column["index"].astype(np.int64)]
    particles = np.bincount(flow.group, minlength=GROUPS)
    numbers = {}
    for wall in WALLS:
        met = (column["stage"] == number) & (column["outer"] == (wall == "outer"))
        here = (column[name][met] for name in ("hit", "place", "speed", "angle"))
        impacts = Impacts(group[met], *here)
        numbers[wall] = wall_numbers(impacts, particles, _edges(bend), speed)
    return numbers


def stage_walls_text(numbers: Mapping[str, Any], number: int) -> str:
    """Markdown of the walls of a bend."""
    bend = Bend(**numbers["stages"][number]["bend"])
    parts = []
    for wall in WALLS:
        walls = {
            model: of_model["stages"][number]["walls"][wall]
            for model, of_model in numbers["models"].items()
        }
        parts.append(f"### Impacts on the {wall} wall\n\n{walls_text(walls, turn_of(bend))}")
    return "\n".join(parts)
