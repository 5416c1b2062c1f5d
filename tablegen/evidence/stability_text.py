"""Summary of a stability study: rows by group, worst cases, and JSON."""

from collections.abc import Callable, Iterator, Sequence
from statistics import fmean

from sampler.files.json_text import json_text
from tablegen.evidence.page import Block, DataTable, Section, Verdict
from tablegen.evidence.stability import Outcome, Study
from tablegen.evidence.stability_cases import FORMS, Case

#: Columns of quantities: head, attribute of `Outcome` or `Figures`, how a group sums it up, format.
_COLUMNS: tuple[tuple[str, str, Callable[[list[float]], float], str], ...] = (
    ("coll.", "most_collisions", max, ",d"),
    ("us", "cost", lambda values: 1e6 * fmean(values), ",.1f"),
    ("worst us", "cost", lambda values: 1e6 * max(values), ",.0f"),
    ("growth", "growth", max, ".1e"),
    ("residual", "residual", max, ".1e"),
    ("drift", "drift", max, ".1e"),
    ("depth", "depth", max, ".1e"),
    ("contact", "contact", fmean, ".1e"),
    ("flight", "flight", fmean, ".1e"),
)
HEAD = ("cases of", "cases", "particles", "failed", *(column[0] for column in _COLUMNS))

LEGEND = (
    "*: every case is outside the speeds at which the restitution law was measured. us:",
    "microseconds per rebound on one thread, mean and worst case. growth: largest gain of energy.",
    "residual: of the collision equations. drift: relative, of energy or angular momentum in",
    "flight. depth: below the wall, in a. contact, flight: mean change of a particle's state, in V",
    "and V/a, by half the contact resolution and by half the flight tolerance.",
)

#: Quantities whose worst case is named: words, attribute, how the worst is chosen.
_WORST: tuple[tuple[str, str, Callable[..., tuple[float, Outcome]]], ...] = (
    ("collisions", "most_collisions", max),
    ("cost [s]", "cost", max),
    ("energy growth", "growth", max),
    ("residual", "residual", max),
    ("flight drift", "drift", max),
    ("depth [a]", "depth", max),
    ("contact change", "contact", max),
    ("flight change", "flight", max),
    ("least v+ [V]", "least_velocity", min),
)
WORST_HEAD = ("quantity", "value", "case")

#: Sentence of a study in which no case failed.
GOOD = "The model holds in every case."

#: Failed cases that are listed by name.
_LISTED = 20


def _values(outcomes: Sequence[Outcome], name: str) -> list[tuple[float, Outcome]]:
    """Values of a quantity where it was measured."""
    pairs = ((o.cost if name == "cost" else getattr(o.figures, name, None), o) for o in outcomes)
    return [(value, outcome) for value, outcome in pairs if value is not None]


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
    particles, failed = (
        sum(o.particles for o in outcomes),
        sum(bool(o.failures) for o in outcomes),
    )
    cells = [name, f"{len(outcomes):,}", f"{particles:,}", f"{failed:,}"]
    for _, attribute, reduce, form in _COLUMNS:
        values = [value for value, _ in _values(outcomes, attribute)]
        cells.append(f"{reduce(values):{form}}" if values else "-")
    return cells


def worst_rows(outcomes: Sequence[Outcome]) -> list[list[str]]:
    """Quantity, value and case of each of the worst cases, with the seed that repeats it."""
    rows = []
    for words, attribute, choose in _WORST:
        if values := _values(outcomes, attribute):
            value, outcome = choose(values, key=lambda pair: pair[0])
            rows.append([words, f"{value:.4g}", f"{outcome.case} (seed {outcome.seed})"])
    return rows


def failure_lines(study: Study) -> list[str]:
    """One line for each of the first failed cases, with the seed that repeats it."""
    lines = [
        f"failed: {outcome.case} (seed {outcome.seed}): {'; '.join(outcome.failures)}"
        for outcome in study.failed[:_LISTED]
    ]
    more = len(study.failed) - len(lines)
    return lines + ([f"failed: {more:,} more cases"] if more else [])


def study_section(study: Study, folded: bool = False) -> Section:
    """Verdict, counts, groups and worst cases of a study."""
    outcomes = study.outcomes
    counts = (
        f"{sum(o.particles for o in outcomes):,} particles in {len(outcomes):,} cases: "
        f"{sum(o.non_finite for o in outcomes)} non-finite, "
        f"{sum(o.unfinished > 0 for o in outcomes)} cases unfinished, "
        f"{sum(o.grows for o in outcomes)} with growing energy, "
        f"{sum(not o.separated for o in outcomes)} not separated from the wall."
    )
    numerics = (
        f"Contact resolution {study.contact_resolution:g}, flight tolerance "
        f"{study.tolerance:g}, {study.count} particles a case, seed {study.seed}."
    )
    kind, words = ("good", GOOD) if study.holds else ("bad", "The model fails in some cases:")
    blocks: list[Block] = [
        Verdict(kind, words, failure_lines(study)),
        counts,
        numerics,
        DataTable("Cases by group", HEAD, group_rows(outcomes)),
        "\n".join(LEGEND),
        DataTable("Worst case of each quantity", WORST_HEAD, worst_rows(outcomes), "words"),
    ]
    return Section(f"Stability of the direct model: {study.pair}", blocks, folded)


def study_json(study: Study) -> str:
    """Every case of a study as JSON, one to a line."""
    data = study.to_dict()
    cases = [json_text(case, indent=None).rstrip() for case in data.pop("cases")]
    head = json_text(data).removesuffix("\n}\n")
    return head + ',\n "cases": [\n  ' + ",\n  ".join(cases) + "\n ]\n}\n"
