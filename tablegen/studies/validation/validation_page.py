"""A validation as one HTML page that needs no network."""

from collections.abc import Sequence

from tablegen.accuracy.comparison import Comparison
from tablegen.accuracy.verdict import verdict_words
from tablegen.studies.pages.rendering import render_page
from tablegen.studies.validation.accuracy_text import (
    DETAIL_HEAD,
    HEAD,
    closing_rows,
    detail_rows,
    metric_row,
)
from tablegen.studies.validation.validation_text import certainty_line, coverage_lines, whose
from tablegen.validate import Validation


def _distances(comparisons: Sequence[Comparison], validation: Validation) -> list[list[str]]:
    rows = [metric_row(c) for c in comparisons]
    accuracies = validation.declared, validation.asked
    for name, values in closing_rows(comparisons, *accuracies, len(validation.measured)):
        texts = [cell for value in values[:-1] for cell in (f"{value:.4f}", "")]
        rows.append([name, "", "", *texts, f"{values[-1]:.3f}"])
    return rows


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
    return render_page(
        "validation",
        title=f"Validation of {validation.table}",
        kind="bad" if missed else "open" if undecided else "good",
        words=verdict_words(missed, undecided, whose(validation)),
        lines=[*missed, *undecided],
        notes=[*coverage_lines(validation), certainty_line()],
        content_sha256=validation.content_sha256,
        head=["impact angle [degrees]", "speed [m/s]", *HEAD[2:]],
        rows=_distances(validation.comparisons, validation),
        node_rows=_distances(validation.nodes, validation) if validation.nodes else [],
        detail_head=DETAIL_HEAD,
        details=[
            (f"{c.alpha_deg:.2f}°, {c.speed:.1f} m/s", detail_rows(c))
            for c in validation.comparisons
        ],
    )
