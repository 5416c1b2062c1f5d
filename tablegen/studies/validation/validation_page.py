"""A validation as one HTML page that needs no network."""

from tablegen.accuracy.verdict import verdict_words
from tablegen.studies.pages.rendering import render_page
from tablegen.studies.validation.accuracy_text import (
    DETAIL_HEAD,
    HEAD,
    accuracy_rows,
    detail_rows,
)
from tablegen.studies.validation.validation_text import certainty_line, coverage_lines, whose
from tablegen.validate import Validation


def validation_page(validation: Validation) -> str:
    """Self-contained HTML of a validation.

    Parameters
    ----------
    validation : Validation

    Returns
    -------
    str
    """
    missed, undecided = validation.missed, validation.undecided
    judged = validation.declared, validation.asked, len(validation.measured)
    return render_page(
        "validation",
        title=f"Validation of {validation.table}",
        kind="bad" if missed else "open" if undecided else "good",
        words=verdict_words(missed, undecided, whose(validation)),
        lines=[*missed, *undecided],
        notes=[*coverage_lines(validation), certainty_line()],
        content_sha256=validation.content_sha256,
        head=HEAD,
        rows=accuracy_rows(validation.comparisons, *judged),
        node_rows=accuracy_rows(validation.nodes, *judged) if validation.nodes else [],
        detail_head=DETAIL_HEAD,
        details=[
            (f"{c.alpha_deg:.2f}°, {c.speed:.1f} m/s", detail_rows(c))
            for c in validation.comparisons
        ],
    )
