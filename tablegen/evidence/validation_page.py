"""A validation as one HTML page that needs no network."""

from tablegen.accuracy import accuracy_text, spin_text
from tablegen.accuracy.accuracy_text import certainty_line, coverage_lines, whose
from tablegen.accuracy.decision import verdict_words
from tablegen.accuracy.validate import Validation
from tablegen.evidence.rendering import render_page


def validation_page(validation: Validation) -> str:
    """Self-contained HTML of a validation."""
    missed, undecided = validation.missed, validation.undecided
    return render_page(
        "validation",
        title=f"Validation of {validation.table}",
        kind="bad" if missed else "open" if undecided else "good",
        words=verdict_words(missed, undecided, whose(validation)),
        lines=[*missed, *undecided],
        notes=[*coverage_lines(validation), certainty_line()],
        validation=validation,
        text=accuracy_text,
        spin_text=spin_text,
    )
