"""Summary of a stability study: rows by group, worst cases, and JSON."""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from sampler.files import json_text
from tablegen.evidence.page import Block, Headline, Section
from tablegen.evidence.stability import Outcome, Study
from tablegen.evidence.stability_cases import FORMS, Case
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
HEAD = ("cases of", "cases", "particles", "failed", *(q[0] for q in _QUANTITIES))
WORST_HEAD = ("quantity", "value", "case")
FRICTION_HEAD = (
    *("static", "dynamic", "particles", "laws failed", "us per rebound"),
    *("coll.", "growth", "least v+"),
)

LEGEND = (
    "*: every case is outside the speeds at which the restitution law was measured. growth: gain",
    "of energy, residual: of the collision equations, drift: relative, of energy or angular",
    "momentum in flight, depth: below the wall in a; contact, flight: mean change of a particle's",
    "state, in V and V/a, by half the contact resolution and by half the flight tolerance. Every",
    "quantity is that of the worst case.",
)

#: Sentence of a study in which no case failed.
GOOD = "The model holds in every case."

#: Failed cases that are listed by name.
_LISTED = 20


def _worst(outcomes: Sequence[Outcome], name: str, choose: Callable[..., Any]) -> Any:
    """Value of a quantity in its worst case, and that outcome; None if it was not measured."""
    pairs = [(getattr(o.figures, name, None), o) for o in outcomes]
    known = [(value, outcome) for value, outcome in pairs if value is not None]
    return choose(known, key=lambda pair: pair[0]) if known else None


def group_rows(outcomes: Sequence[Outcome]) -> list[list[str]]:
    """Cells by shape, form, angle, speed and size of the spin; the last row is of all cases.

    A star marks a group in which every case extrapolates the restitution law.
    """
    forms = sorted(outcomes, key=lambda o: FORMS.index(o.case.form))
    spins = sorted(outcomes, key=lambda o: abs(o.case.spin))
    return [
        *_rows(outcomes, lambda case: case.shape),
        *_rows(forms, lambda case: case.form),
        *_rows(outcomes, lambda case: f"{case.alpha_deg:g} degrees"),
        *_rows(outcomes, lambda case: f"{case.speed:g} m/s"),
        *_rows(spins, lambda case: f"spin {abs(case.spin):g} V/a"),
        _row("all", outcomes),
    ]


def _rows(outcomes: Sequence[Outcome], title: Callable[[Case], str]) -> Iterator[list[str]]:
    """Rows of the outcomes with equal titles."""
    groups: dict[str, list[Outcome]] = {}
    for outcome in outcomes:
        groups.setdefault(title(outcome.case), []).append(outcome)
    for name, members in groups.items():
        mark = " *" if all(outcome.extrapolated for outcome in members) else ""
        yield _row(name + mark, members)


def _row(name: str, outcomes: Sequence[Outcome]) -> list[str]:
    failed = sum(bool(o.failures) for o in outcomes)
    counts = (len(outcomes), sum(o.particles for o in outcomes), failed)
    cells = [name, *(f"{count:,}" for count in counts)]
    for _, attribute, choose in _QUANTITIES:
        worst = _worst(outcomes, attribute, choose)
        cells.append("-" if worst is None else f"{worst[0]:.2g}")
    return cells


def worst_rows(outcomes: Sequence[Outcome]) -> list[list[str]]:
    """Quantity, value and case of each of the worst cases, with the seed that repeats it."""
    rows = []
    for words, attribute, choose in _QUANTITIES:
        if (worst := _worst(outcomes, attribute, choose)) is not None:
            value, outcome = worst
            rows.append([words, f"{value:.4g}", f"{outcome.case} (seed {outcome.seed})"])
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
        TextTable("Cases by group", HEAD, group_rows(outcomes)),
        "\n".join(LEGEND),
        TextTable("Worst case of each quantity", WORST_HEAD, worst_rows(outcomes), "words"),
    ]
    if study.friction:
        caption = "Coulomb friction: random impacts of the whole population at restitutions 0 to 1"
        blocks.append(TextTable(caption, FRICTION_HEAD, friction_rows(study.friction)))
    return Section(f"Stability of the direct model: {study.pair}", blocks)


def study_json(study: Study) -> str:
    """Every case of a study as JSON, one to a line."""
    data = study.to_dict()
    cases = [json_text(case, indent=None).rstrip() for case in data.pop("cases")]
    head = json_text(data).removesuffix("\n}\n")
    return head + ',\n "cases": [\n  ' + ",\n  ".join(cases) + "\n ]\n}\n"
