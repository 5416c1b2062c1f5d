"""Summary of a stability study: worst cases, failures, and rows by coefficient of friction."""

from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

from tablegen.evidence.page import Block, Headline, Section
from tablegen.evidence.stability import Outcome, Study
from tablegen.evidence.stability_friction import FrictionOutcome
from tablegen.presentation import TextTable

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

LEGEND = (
    "growth: gain of energy, residual: of the collision equations, drift: relative, of energy or",
    "angular momentum in flight, depth: below the wall in a; contact, flight: mean change of a",
    "particle's state, in V and V/a, by half the contact resolution and half the flight tolerance.",
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


def failure_lines(study: Study) -> list[str]:
    """One line for each of the first failed cases, with the seed that repeats it."""
    lines = [
        f"failed: {outcome} (seed {outcome.seed}): {'; '.join(outcome.failures.values())}"
        for outcome in study.failed[:_LISTED]
    ]
    more = len(study.failed) - len(lines)
    return lines + ([f"failed: {more:,} more cases"] if more else [])


def study_section(study: Study) -> Section:
    """Verdict, counts, groups and worst cases of a study."""
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
        "\n".join(LEGEND),
    ]
    if study.friction:
        caption = "Coulomb friction: random impacts of the whole population at restitutions 0 to 1"
        blocks.append(TextTable(caption, FRICTION_HEAD, friction_rows(study.friction)))
    return Section(f"Stability of the direct model: {study.pair}", blocks)
