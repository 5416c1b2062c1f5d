"""Summary of a stability study: worst cases, failures, and rows by coefficient of friction."""

from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

from tablegen.accuracy.chains import GEOMETRY_WORDS
from tablegen.evidence.pictures import Line, angles_picture
from tablegen.evidence.stability import Outcome, Study
from tablegen.evidence.stability_chains import ChainOutcome
from tablegen.evidence.stability_friction import FrictionOutcome
from tablegen.presentation import COLOURS, TextTable

#: Quantities whose worst is shown: words, attribute of `Figures`, and which is worst.
_QUANTITIES: tuple[tuple[str, str, Callable[..., Any]], ...] = (
    ("most collisions of a rebound", "most_collisions", max),
    ("largest gain of energy, over that before", "growth", max),
    ("largest share of the energy that is not accounted for", "unaccounted", max),
    ("mean change of a state by half the contact resolution [V, V/a]", "contact", max),
    ("mean change of a state by half the tolerance of the flight [V, V/a]", "flight", max),
    ("least velocity away from the wall [V]", "least_velocity", min),
)
WORST_HEAD = ("quantity", "worst", "case")
FRICTION_HEAD = (
    "static coefficient",
    "dynamic",
    "rebounds",
    "laws failed",
    "µs/rebound",
    "most collisions",
    "gain of energy",
    "least v+ [V]",
)

CHAIN_HEAD = (
    "kind of grains, and walls",
    "hits",
    "grains",
    "µs/rebound",
    "gain of energy",
    "least v+ [V]",
    "angle [°]",
    "energy kept",
    "spin [V/a]",
)

FRICTION_LEGEND = (
    "Random particles of the population hit the wall at random angles, speeds and spins, under "
    "Coulomb's law of friction. Each row has several laws, with restitutions from 0 to 1. A "
    "negative gain of energy is a loss; v+ is the velocity away from the wall."
)

CHAIN_LEGEND = (
    "Grains fly from wall to wall without gas. They keep four numbers of rotation from wall to "
    "wall: the mean angular velocity, and the inertia about it. After each hit the speed is set "
    "back to the first speed, and the spin is scaled in the same proportion. Angle, energy and "
    "spin are those of the last hits: the median angle at which grains leave the wall, the share "
    "of its translational energy that a grain keeps, and the root of the mean squared spin."
)
ROLLING_LEGEND = (
    "Rolling discs meet a cylinder at 0.05°, and their contact point has no velocity. A round disc "
    "(b/a = 1) rolls for ever: it keeps all of its energy, and its hops become ever flatter, down "
    "to 0.0057°, the smallest angle that is followed. A disc with b/a = 0.9 bounces along the wall."
)

#: Sentences of a study in which no case failed, and of one in which some did.
GOOD, BAD = "The model holds in every case.", "The model fails in some cases:"

#: Failed cases that are listed by name.
_LISTED = 20


def worst_rows(outcomes: Sequence[Outcome]) -> list[list[str]]:
    """Quantity, value and case of each of the worst cases, with the seed that repeats it."""
    rows = []
    for words, attribute, choose in _QUANTITIES:
        values = [(getattr(one.figures, attribute, None), one) for one in outcomes]
        known = [pair for pair in values if pair[0] is not None]
        if known:
            value, one = choose(known, key=lambda pair: pair[0])
            rows.append([words, f"{value:.4g}", f"{one.case} (seed {one.seed})"])
    return rows


def friction_rows(outcomes: Sequence[FrictionOutcome]) -> list[list[str]]:
    """Write the cells by static and dynamic coefficient, over the restitutions."""
    groups: dict[tuple[float, float], list[FrictionOutcome]] = {}
    for outcome in outcomes:
        groups.setdefault((outcome.static, outcome.dynamic), []).append(outcome)
    rows = []
    for coefficients, members in groups.items():
        count = sum(o.rebounds for o in members)
        failed = sum(bool(o.failures) for o in members)
        growths = [o.growth for o in members if o.growth is not None]
        least = [o.least_velocity for o in members if o.least_velocity is not None]
        rows.append(
            [
                *(f"{coefficient:g}" for coefficient in coefficients),
                f"{count:,}",
                f"{failed}",
                f"{1e6 * sum(o.cost * o.rebounds for o in members) / count:.1f}",
                f"{max(o.most_collisions for o in members)}",
                f"{max(growths):.2g}" if growths else "-",
                f"{min(least):.2g}" if least else "-",
            ]
        )
    return rows


def chain_rows(outcomes: Sequence[ChainOutcome]) -> list[list[str]]:
    """Write the cells of each chain of hits."""

    def text(value: float | None, form: str) -> str:
        return "-" if value is None else format(value, form)

    return [
        [
            one.where,
            f"{one.hits}",
            f"{one.grains}",
            f"{1e6 * one.cost:.1f}",
            text(one.growth, ".2g"),
            text(one.least_velocity, ".2g"),
            text(one.angle_deg[-1] if one.angle_deg else None, ".3g"),
            text(one.energy, ".4f"),
            text(one.spin, ".3f"),
        ]
        for one in outcomes
    ]


def chain_picture(outcomes: Sequence[ChainOutcome], name: str) -> bytes:
    """Draw the angles of chains against hits, by geometry and kind of grains."""
    colours = [*COLOURS.values(), "#e08a00", "#777777", "#56b4e9"]
    kinds = list(dict.fromkeys(one.kind for one in outcomes))
    panels: dict[str, dict[str, Line]] = {}
    for one in outcomes:
        colour = colours[kinds.index(one.kind) % len(colours)]
        style = "--" if one.kind.startswith("rolling") else "-"
        hits = list(range(1, 1 + len(one.angle_deg)))
        panel = panels.setdefault(GEOMETRY_WORDS[one.geometry], {})
        panel[one.kind] = Line(hits, one.angle_deg, colour, style)
    return angles_picture(panels, name)


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
        f"{sum(o.particles for o in outcomes):,} particles in {len(outcomes):,} cases; failures: "
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
        parts += [f"{CHAIN_LEGEND}\n{ROLLING_LEGEND}", str(TextTable(caption, CHAIN_HEAD, rows))]
    return "\n\n".join(parts)
