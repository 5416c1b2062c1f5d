"""The picture of what hits the outer wall of a bend."""

from collections.abc import Mapping
from typing import Any

from wall_impacts_picture import draw_walls

from many_hits.duct import Bend
from many_hits.picture import SHOWN, legend
from many_hits.wall_report import turn_of
from tablegen.presentation import Picture, new_figure, settings, written


def impacts_picture(numbers: Mapping[str, Any]) -> Picture:
    """Draw what hits the outer wall of the first bend, place by place."""
    shown = {model: numbers["models"][model] for model in SHOWN if model in numbers["models"]}
    walls = {model: of_model["stages"][0]["walls"]["outer"] for model, of_model in shown.items()}
    with settings():
        figure = new_figure(13.0, 7.0)
        panels = figure.subplots(2, 3).ravel()
        draw_walls(panels, walls, turn_of(Bend(**numbers["stages"][0]["bend"])))
        legend(figure, panels[0])
        return written(
            figure,
            f"{numbers['name']}_impacts.png",
            f"What hits the outer wall: {numbers['name']}",
            "Impacts, their mean speed and angle, and their energy along the outer wall, by model.",
        )
