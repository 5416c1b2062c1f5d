"""Summary of a stability study: worst cases, failures, and rows by coefficient of friction."""

from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from tablegen.evidence.stability import Study
from tablegen.evidence.stability_cases import CaseOutcome
from tablegen.evidence.stability_chains import ChainOutcome
from tablegen.evidence.stability_friction import FrictionOutcome
from tablegen.presentation import (
    COLOURS,
    TextTable,
    figure_style,
    legend_below,
    make_picture,
    new_figure,
    set_log_ticks,
)
from tablegen.simulation.billiard import GEOMETRY_WORDS

#: Quantities whose worst is shown: words, attribute of `CaseOutcome`, and which is worst.
_QUANTITIES: tuple[tuple[str, str, Callable[..., Any]], ...] = (
    ("most collisions of a rebound", "most_collisions", max),
    ("largest gain of energy, over that before", "growth", max),
    ("largest share of the energy that is not accounted for", "unaccounted", max),
    ("mean change of a state by half the contact resolution [V, V/a]", "contact", max),
    ("mean change of a state by half the tolerance of the flight [V, V/a]", "flight", max),
    ("least velocity away from the wall [V]", "least_velocity", min),
)
WORST_HEAD = ("quantity", "worst", "case")
FRICTION_HEAD = ("static", "dynamic", "rebounds", "failed", "most collisions", "gain of energy")
CHAIN_HEAD = (
    *("kind of grains, and walls", "hits", "grains", "gain of energy", "least v+ [V]"),
    *("angle [°]", "energy kept", "spin [V/a]"),
)

FRICTION_LEGEND = (
    "Random particles of the population at random angles, speeds and spins. Each row has several "
    "restitutions from 0 to 1. A negative gain of energy is a loss."
)
CHAIN_LEGEND = (
    "Grains fly from wall to wall without gas, and keep their mean angular velocity and the "
    "inertia about it. After each hit the speed is set back to the first speed, and the spin in "
    "proportion. Angle (median), energy kept and spin (root mean square) are those of the last "
    "hits. A round disc (b/a = 1) that rolls keeps all of its energy."
)

#: Sentences of a study in which no case failed, and of one in which some did.
GOOD, BAD = "The model holds in every case.", "The model fails in some cases:"

#: Failed cases that are listed by name.
_LISTED = 20


def worst_rows(outcomes: Sequence[CaseOutcome]) -> list[list[str]]:
    """Quantity, value and case of each of the worst cases, with the seed that repeats it."""
    rows = []
    for words, attribute, choose in _QUANTITIES:
        values = [(getattr(one, attribute), one) for one in outcomes]
        known = [pair for pair in values if pair[0] is not None]
        if known:
            value, one = choose(known, key=lambda pair: pair[0])
            rows.append([words, f"{value:.4g}", f"{one.case} (seed {one.seed})"])
    return rows


def _text(value: float | None, form: str) -> str:
    return "-" if value is None else format(value, form)


def friction_rows(outcomes: Sequence[FrictionOutcome]) -> list[list[str]]:
    """Write the cells by static and dynamic coefficient, over the restitutions."""
    groups: dict[tuple[float, float], list[FrictionOutcome]] = {}
    for outcome in outcomes:
        groups.setdefault((outcome.static, outcome.dynamic), []).append(outcome)
    return [
        [
            *(f"{coefficient:g}" for coefficient in coefficients),
            f"{sum(o.rebounds for o in members):,}",
            f"{sum(bool(o.failures) for o in members)}",
            f"{max(o.most_collisions for o in members)}",
            _text(max((o.growth for o in members if o.growth is not None), default=None), ".2g"),
        ]
        for coefficients, members in groups.items()
    ]


def chain_rows(outcomes: Sequence[ChainOutcome]) -> list[list[str]]:
    """Write the cells of each chain of hits."""
    return [
        [
            one.where,
            f"{one.hits}",
            f"{one.grains}",
            _text(one.growth, ".2g"),
            _text(one.least_velocity, ".2g"),
            _text(one.angle_deg[-1] if one.angle_deg else None, ".3g"),
            _text(one.energy, ".4f"),
            _text(one.spin, ".3f"),
        ]
        for one in outcomes
    ]


def chain_picture(outcomes: Sequence[ChainOutcome], name: str) -> bytes:
    """Draw median angles at which grains leave the walls against hits; both axes logarithmic."""
    colours = [*COLOURS.values(), "#e08a00", "#777777", "#56b4e9"]
    kinds = list(dict.fromkeys(one.kind for one in outcomes))
    with figure_style():
        figure = new_figure(10.0, 4.8)
        columns = figure.subplots(1, len(GEOMETRY_WORDS), sharey=True)
        panels = dict(zip(GEOMETRY_WORDS, columns, strict=True))
        for one in outcomes:
            panels[one.geometry].plot(
                np.arange(len(one.angle_deg)) + 1,
                one.angle_deg,
                color=colours[kinds.index(one.kind) % len(colours)],
                linestyle="--" if one.kind.startswith("rolling") else "-",
                label=one.kind,
            )
        for geometry, axes in panels.items():
            axes.set(xscale="log", yscale="log", xlabel="number of the hit")
            set_log_ticks(axes)
            axes.set_title(GEOMETRY_WORDS[geometry], loc="left")
        columns[0].set_ylabel("median angle to the wall at which grains leave [°]")
        legend_below(figure, columns=4)
        return make_picture(figure, name)


def failure_lines(study: Study) -> list[str]:
    """One line for each of the first failed cases, with the seed that repeats it."""
    lines = [
        f"failed: {outcome} (seed {outcome.seed}): {'; '.join(outcome.failures.values())}"
        for outcome in study.failed[:_LISTED]
    ]
    more = len(study.failed) - len(lines)
    return lines + ([f"failed: {more:,} more cases"] if more else [])


def study_text(study: Study) -> str:
    """Write the verdict, the worst cases, and the rows of friction and of chains."""
    outcomes = study.outcomes
    failures = Counter(kind for outcome in study.failed for kind in outcome.failures)
    counts = ", ".join(f"{count} {kind}" for kind, count in failures.items())
    parts = [
        f"Stability of the direct model: {study.pair}\n"
        "Extreme particles and impacts are simulated with the laws of the pair. Each rebound must "
        "end, be finite, leave the wall, and gain no energy.",
        "\n".join([GOOD if study.holds else BAD, *failure_lines(study)]),
        f"{sum(o.rebounds for o in outcomes):,} particles in {len(outcomes):,} cases; failures: "
        f"{counts or 'none'}. Contact resolution {study.contact_resolution:g}, flight tolerance "
        f"{study.tolerance:g}, {study.count} particles a case, seed {study.seed}. 'tablegen "
        "simulate' repeats a case with its seed.",
        str(TextTable("Worst case of each quantity", WORST_HEAD, worst_rows(outcomes))),
    ]
    if study.friction:
        caption = "Coulomb friction, by the coefficients"
        rows = friction_rows(study.friction)
        parts += [FRICTION_LEGEND, str(TextTable(caption, FRICTION_HEAD, rows))]
    if study.chains:
        caption = "Many hits: sixty of all grains, a thousand of discs that roll"
        rows = chain_rows(study.chains)
        parts += [CHAIN_LEGEND, str(TextTable(caption, CHAIN_HEAD, rows))]
    return "\n\n".join(parts)
