"""The stability study as HTML: a page of its own, and a part of a report's."""

from typing import Any

from tablegen.evidence.rendering import render_page
from tablegen.evidence.stability_study import Study
from tablegen.evidence.stability_summary import HEAD, LEGEND, extremes, group_rows
from tablegen.evidence.stability_text import (
    GOOD,
    counts_text,
    failure_lines,
    settings_text,
)


def stability_values(study: Study) -> dict[str, Any]:
    """Give counts, groups, worst cases and failures for ``stability_results.html.j2``."""
    return {
        "kind": "good" if study.holds else "bad",
        "words": GOOD if study.holds else "The model fails in some cases:",
        "failures": failure_lines(study),
        "counts": counts_text(study.outcomes),
        "settings": settings_text(study),
        "head": HEAD,
        "groups": group_rows(study.outcomes),
        "legend": " ".join(LEGEND),
        "extremes": [
            [e.quantity, f"{e.value:.4g}", str(e.outcome.case), str(e.outcome.seed)]
            for e in extremes(study.outcomes)
        ],
    }


def study_page(study: Study) -> str:
    """Self-contained HTML of a study: counts, groups, worst cases, failures.

    Parameters
    ----------
    study : Study

    Returns
    -------
    str
    """
    title = f"Stability of the direct model: {study.pair}"
    return render_page("stability", title=title, stability=stability_values(study))
