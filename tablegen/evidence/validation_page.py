"""A validation as one HTML page that needs no network."""

from tablegen.accuracy import accuracy_text
from tablegen.accuracy.decision import verdict_words
from tablegen.accuracy.validate import Validation
from tablegen.evidence.rendering import render_page


def validation_page(validation: Validation) -> str:
    """Self-contained HTML of a validation."""
    missed, undecided = validation.missed, validation.undecided
    compared = [c for law in validation.laws for c in law.measured.comparisons]
    return render_page(
        "validation",
        title=f"Validation of {validation.table}",
        kind="bad" if missed else "open" if undecided else "good",
        words=verdict_words(missed, undecided, accuracy_text.whose(validation)),
        lines=[*missed, *undecided],
        tables=accuracy_text.validation_tables(validation),
        notes=accuracy_text.validation_notes(validation),
        details=[accuracy_text.detail_table(comparison) for comparison in compared],
        validation=validation,
    )
