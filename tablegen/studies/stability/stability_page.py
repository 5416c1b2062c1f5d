"""The stability study as one HTML page that needs no network."""

from html import escape

from tablegen.studies.html_page import html_page, html_table, verdict
from tablegen.studies.stability.stability_study import Study
from tablegen.studies.stability.stability_summary import HEAD, LEGEND, extremes, group_rows
from tablegen.studies.stability.stability_text import counts_text, failure_lines


def study_page(study: Study) -> str:
    """Self-contained HTML of a study: counts, groups, worst cases, failures.

    Parameters
    ----------
    study : Study

    Returns
    -------
    str
    """
    worst = [
        [e.quantity, f"{e.value:.4g}", str(e.outcome.case), str(e.outcome.seed)]
        for e in extremes(study.outcomes)
    ]
    holds = verdict(
        "The model holds in every case.", "The model fails in some cases:", failure_lines(study)
    )
    return html_page(
        f"Stability of the direct model: {study.pair}",
        f"{holds}<p>{escape(counts_text(study.outcomes))}</p>"
        f"<p>Contact resolution {study.contact_resolution:g}, flight tolerance "
        f"{study.tolerance:g}, {study.count} particles a case, seed {study.seed}.</p>"
        f"<h2>By group</h2>{html_table(HEAD, group_rows(study.outcomes))}"
        f"<p>{escape(' '.join(LEGEND))}</p>"
        "<h2>Worst case of each quantity</h2>"
        f"{html_table(['quantity', 'value', 'case', 'seed'], worst)}",
    )
