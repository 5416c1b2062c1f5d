"""Summary of a stability study: worst cases, failures, and rows by coefficient of friction."""

from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

from tablegen.accuracy.chains import GEOMETRY_WORDS
from tablegen.evidence.page import Block, Headline, Section
from tablegen.evidence.plots import Line, angles_picture
from tablegen.evidence.stability import Outcome, Study
from tablegen.evidence.stability_chains import ChainOutcome
from tablegen.evidence.stability_friction import FrictionOutcome
from tablegen.presentation import COLOURS, Picture, TextTable

#: Quantities whose worst is shown: head, attribute of `Figures`, and which is worst.
_QUANTITIES: tuple[tuple[str, str, Callable[..., Any]], ...] = (
    ("coll.", "most_collisions", max),
    ("growth", "growth", max),
    ("residual", "residual", max),
    ("drift", "drift", max),
    ("depth", "depth", max),
    ("contact", "contact", max),
    ("flight", "flight", max),
    ("least v+", "least_velocity", min),
)
WORST_HEAD = ("quantity", "value", "case")
FRICTION_HEAD = (
    *("static", "dynamic", "particles", "laws failed", "us per rebound"),
    *("coll.", "growth", "least v+"),
)

CHAIN_HEAD = (
    *("grains", "hits", "number", "us per rebound", "growth", "least v+"),
    *("angle [deg]", "energy kept", "spin [V/a]"),
)

#: What the words in the heads mean.
LEGEND = TextTable(
    "Quantities",
    ("quantity", "meaning"),
    [
        ["coll.", "number of collisions of a rebound"],
        ["growth", "gain of kinetic energy, over that before; negative: a loss"],
        ["residual", "violation of the collision equations [V]"],
        ["drift", "relative change of energy or angular momentum in flight"],
        ["depth", "depth of a contact below the wall [a]"],
        ["contact", "mean change of a state by half the contact resolution [V, V/a]"],
        ["flight", "mean change of a state by half the tolerance of the flight [V, V/a]"],
        ["least v+", "smallest velocity away from the wall after a rebound [V]"],
    ],
    "words",
)
CHAIN_LEGEND = (
    "Grains fly from wall to wall without gas and keep their angular velocity and the inertia "
    "about it. After each hit speed and spin are scaled back to the first speed. Angle, "
    "energy and spin are those of the last hits: the median angle at which grains leave the "
    "wall, the share of its translational energy that a grain keeps, and the root of the mean "
    "squared spin. Rolling discs begin at 0.05 degrees without a velocity at the contact. The "
    "round one, 1 0.5, rolls for ever and keeps all of its energy. The other, 0.9 0.5, "
    "bounces along."
)

#: Sentence of a study in which no case failed.
GOOD = "The model holds in every case."

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
    """Cells by static and dynamic coefficient, over the restitutions."""
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
                *(f"{count:,}", f"{failed}"),
                f"{1e6 * sum(o.cost * o.rebounds for o in members) / count:.1f}",
                f"{max(o.most_collisions for o in members)}",
                f"{max(growths):.2g}" if growths else "-",
                f"{min(least):.2g}" if least else "-",
            ]
        )
    return rows


def chain_rows(outcomes: Sequence[ChainOutcome]) -> list[list[str]]:
    """Cells of each chain of hits."""

    def text(value: float | None, form: str) -> str:
        return "-" if value is None else format(value, form)

    return [
        [
            one.where,
            *(f"{one.hits}", f"{one.grains}", f"{1e6 * one.cost:.1f}"),
            *(text(one.growth, ".2g"), text(one.least_velocity, ".2g")),
            text(one.angle_deg[-1] if one.angle_deg else None, ".3g"),
            *(text(one.energy, ".4f"), text(one.spin, ".3f")),
        ]
        for one in outcomes
    ]


def chain_picture(outcomes: Sequence[ChainOutcome]) -> Picture:
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
    title = (
        "Grains that settle into rolling leave the wall of a cylinder at ever flatter angles, "
        "discs at the flattest; between walls of any direction angles hardly change from hit to "
        "hit."
    )
    alternative = "Median angles against hits in both geometries; the last are in the table."
    return angles_picture(panels, "angles.svg", title, alternative)


def failure_lines(study: Study) -> list[str]:
    """One line for each of the first failed cases, with the seed that repeats it."""
    lines = [
        f"failed: {outcome} (seed {outcome.seed}): {'; '.join(outcome.failures.values())}"
        for outcome in study.failed[:_LISTED]
    ]
    more = len(study.failed) - len(lines)
    return lines + ([f"failed: {more:,} more cases"] if more else [])


def study_section(study: Study, pictures: Sequence[Picture] = ()) -> Section:
    """Verdict, counts, groups and worst cases of a study, with the given pictures of chains."""
    outcomes = study.outcomes
    failures = Counter(kind for outcome in study.failed for kind in outcome.failures)
    counts = (
        f"{sum(o.particles for o in outcomes):,} particles in {len(outcomes):,} cases, cases with "
        f"failures: {', '.join(f'{n} {kind}' for kind, n in failures.items()) or 'none'}."
    )
    numerics = (
        f"Contact resolution {study.contact_resolution:g}, flight tolerance "
        f"{study.tolerance:g}, {study.count} particles a case, seed {study.seed}."
    )
    kind, words = ("good", GOOD) if study.holds else ("bad", "The model fails in some cases:")
    blocks: list[Block] = [
        Headline(kind, words, failure_lines(study)),
        counts,
        numerics,
        TextTable("Worst case of each quantity", WORST_HEAD, worst_rows(outcomes), "words"),
        LEGEND,
    ]
    if study.friction:
        caption = "Coulomb friction: random impacts of the whole population at restitutions 0 to 1"
        blocks.append(TextTable(caption, FRICTION_HEAD, friction_rows(study.friction)))
    if study.chains:
        caption = "Many hits: sixty of all grains, a thousand of discs that roll"
        blocks += [
            TextTable(caption, CHAIN_HEAD, chain_rows(study.chains)),
            CHAIN_LEGEND,
            *pictures,
        ]
    return Section(f"Stability of the direct model: {study.pair}", blocks)
