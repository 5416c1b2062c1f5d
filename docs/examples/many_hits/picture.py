"""Pictures: chains of hits, and flows."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from many_hits.models import MODELS
from tablegen.presentation import Picture, new_figure, settings, written


class Look(NamedTuple):
    """Colour, marker and dashes of a model; a reader without colours has the other two."""

    colour: str
    marker: str
    dashes: str
    label: str


LOOKS = {
    "direct": Look("#000000", "o", "-", "direct simulation"),
    "fresh-grains": Look("#009e73", "v", ":", "direct, a fresh grain at each hit"),
    "memoryless": Look("#a64d79", "D", ":", "direct, without spin and grain"),
    "table": Look("#e08a00", "s", "--", "table"),
    "table-without-spin": Look("#0072b2", "^", "--", "table without spin"),
    "spheres": Look("#777777", "x", "-.", "spheres"),
}

#: Models in the picture of the README, and in that of impacts.
SHOWN = ("direct", "table", "table-without-spin", "spheres")


def _line(axes: Any, model: str, x: Sequence[float], y: Sequence[float], **style: Any) -> None:
    look = LOOKS[model]
    axes.plot(x, y, look.dashes, color=look.colour, marker=look.marker, label=look.label, **style)


def legend(figure: Any, axes: Any) -> None:
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))


def chains_picture(chains: Sequence[Mapping[str, Any]]) -> Picture:
    """Draw the mean speed after each hit of the chains; a band has 80 % of direct simulation."""
    with settings():
        figure = new_figure(3.4 * len(chains) + 0.4, 3.6)
        panels = figure.subplots(1, len(chains), squeeze=False, sharey=True)[0]
        for axes, chain in zip(panels, chains, strict=True):
            models, start = chain["models"], chain["chain"]["speed"]
            hits = np.arange(len(models[MODELS[0]]) + 1)
            band = np.array([at["speed_quantiles"] for at in models[MODELS[0]]])
            axes.fill_between(hits[1:], band[:, 0], band[:, -1], color="#dddddd", linewidth=0)
            for model in (model for model in SHOWN if model in models):
                _line(axes, model, hits, [start, *(at["speed"]["value"] for at in models[model])])
            axes.set(yscale="log", xlabel="after hit", xticks=hits)
            axes.set_title(chain["name"], loc="left")
            axes.yaxis.set_major_formatter("{x:g}")
        panels[0].set_ylabel("mean speed [m/s]")
        legend(figure, panels[0])
        return written(
            figure,
            "many_hits.png",
            "Speed after several hits",
            "Mean speed after each hit of chains of hits: the table with spin follows direct "
            "simulation, the table without spin and spheres do not.",
        )


def _error_bars(axes: Any, numbers: Mapping[str, Any], stage: int, way: str) -> None:
    """Share of all particles that leave a bend one way, a row for each model."""
    for row, (model, of_model) in enumerate(numbers["models"].items()):
        share, look = of_model["stages"][stage]["shares"][way], LOOKS[model]
        axes.errorbar(
            100.0 * share["value"],
            row,
            xerr=300.0 * share["error"],
            color=look.colour,
            marker=look.marker,
            capsize=3,
        )
    axes.set(yticks=[], xlabel=f"{way}, bend {stage + 1} [% of all particles], ± 3 standard errors")
    axes.invert_yaxis()


def flow_picture(numbers: Mapping[str, Any]) -> Picture:
    """Draw speed and angle at each hit, the density across the last bend, and what passes."""
    with settings():
        figure = new_figure(12.0, 7.0)
        (speed, angle), (across, passed) = figure.subplots(2, 2)
        for model, of_model in numbers["models"].items():
            hits = np.arange(len(of_model["each_hit"])) + 1
            for axes, name in ((speed, "speed"), (angle, "angle")):
                values = [at["mean"][name]["value"] for at in of_model["each_hit"]]
                _line(axes, model, hits, values)
            stage = of_model["stages"][-1]
            profile = np.array(stage["density"])[-1]
            _line(across, model, (np.arange(len(profile)) + 0.5) / len(profile), profile, ms=3)
        speed.set(xlabel="hit", ylabel="mean speed [m/s]")
        angle.set(xlabel="hit", ylabel="mean angle [°]")
        across.set(xlabel="place across the outlet, inner to outer wall", ylabel="density / inlet")
        last = len(numbers["stages"]) - 1
        _error_bars(passed, numbers, last, "through" if last else "lingering")
        legend(figure, speed)
        return written(
            figure,
            f"{numbers['name']}.png",
            f"Particles in a duct: {numbers['name']}",
            "Speed and angle at each hit, density across the outlet, and what passes, by model.",
        )
