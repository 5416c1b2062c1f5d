"""The stability study as text for a terminal, and as JSON with every case."""

from collections.abc import Sequence

from sampler.files.json_text import json_text
from tablegen.evidence.outcome import Outcome
from tablegen.evidence.stability_study import Study
from tablegen.evidence.stability_summary import HEAD, LEGEND, extremes, group_rows
from tablegen.presentation import table_lines

#: What a study says in which no case failed.
GOOD = "The model holds in every case."

#: Failed cases that are listed by name; the JSON has all.
_LISTED = 20


def counts_text(outcomes: Sequence[Outcome]) -> str:
    """Count what must be zero."""
    return (
        f"{sum(o.particles for o in outcomes):,} particles in {len(outcomes):,} cases: "
        f"{sum(o.non_finite for o in outcomes)} non-finite, "
        f"{sum(o.unfinished > 0 for o in outcomes)} cases unfinished, "
        f"{sum(o.grows for o in outcomes)} with growing energy, "
        f"{sum(not o.separated for o in outcomes)} not separated from the wall"
    )


def settings_text(study: Study) -> str:
    """Numerics, size and seed of a study."""
    return (
        f"contact resolution {study.contact_resolution:g}, flight tolerance "
        f"{study.tolerance:g}, {study.count} particles a case, seed {study.seed}"
    )


def failure_lines(study: Study) -> list[str]:
    """One line for each of the first failed cases, with the seed that repeats it."""
    lines = [
        f"failed: {outcome.case} (seed {outcome.seed}): {'; '.join(outcome.failures)}"
        for outcome in study.failed[:_LISTED]
    ]
    if len(study.failed) > _LISTED:
        lines.append(f"failed: {len(study.failed) - _LISTED:,} more cases")
    return lines


def study_text(study: Study) -> str:
    """Summary of a study: counts, groups, worst cases, failures.

    Parameters
    ----------
    study : Study

    Returns
    -------
    str
    """
    lines = [
        f"{study.pair}, {settings_text(study)}",
        counts_text(study.outcomes),
        "",
        *table_lines(HEAD, group_rows(study.outcomes)),
        *LEGEND,
    ]
    worst = [
        [e.quantity, f"{e.value:.4g}", f"{e.outcome.case} (seed {e.outcome.seed})"]
        for e in extremes(study.outcomes)
    ]
    quantity, value = (max((len(row[k]) for row in worst), default=0) for k in (0, 1))
    lines += ["", "Worst case of each quantity:"]
    lines += [f"  {row[0]:<{quantity}}  {row[1]:>{value}}  {row[2]}" for row in worst]
    lines += ["", *(failure_lines(study) or [GOOD])]
    return "\n".join(lines)


def study_json(study: Study) -> str:
    """Every case of a study as JSON, one to a line.

    Parameters
    ----------
    study : Study

    Returns
    -------
    str

    Raises
    ------
    ValueError
        If a number is not finite, which no outcome holds.
    """
    data = study.to_dict()
    cases = [json_text(case, indent=None).rstrip() for case in data.pop("cases")]
    head = json_text(data).removesuffix("\n}\n")
    return head + ',\n "cases": [\n  ' + ",\n  ".join(cases) + "\n ]\n}\n"
