"""What a validation looked at and how sure its verdict is, in sentences for terminal and page."""

from tablegen.accuracy.decision import FALSE_ALARMS, FALSE_HOLDS
from tablegen.accuracy.spin_text import spin_lines
from tablegen.accuracy.validate import Validation
from tablegen.config.metric_table import errors_text, little_declared


def whose(validation: Validation) -> str:
    """Name the accuracy that the verdict is about."""
    same = validation.asked == validation.declared
    return "declared accuracy" if same else "accuracy asked for"


def coverage_lines(validation: Validation) -> list[str]:
    """Say what was looked at, with which seed, and whether the table declares little."""
    screening, count = validation.screening, len(validation.comparisons)
    conditions = f"{count} condition{'s' if count > 1 else ''}"
    if screening is None and count == 0:
        lines = []
    elif screening is None:
        lines = [f"Looked at {conditions} that you chose, and at nothing else of the table."]
    else:
        lines = [
            f"Looked at all {screening.nodes} nodes with {screening.samples:,} states a side, then "
            f"closely at {conditions} between nodes and at the {len(validation.nodes)} nodes that "
            "looked worst."
        ]
    if validation.spin is not None:
        lines += spin_lines(validation.spin, screening is None, validation.together)
    seed = validation.seed
    lines.append(f"Seed {seed}: --seed {seed} makes the same validation again.")
    if little := little_declared(validation.declared.model_dump()):
        lines.append(f"Note: {little}.")
    return lines + _stored_lines(validation)


def _stored_lines(validation: Validation) -> list[str]:
    """Put what the file says of its accuracy beside what was measured."""
    if not validation.measured:
        return []
    if validation.stored is None:
        return ["The file stores no accuracy of its own."]
    largest = {
        name: max(c.estimates[name].value for c in validation.measured)
        for name in validation.stored
    }
    lines = [
        f"The file says of itself, at worst: {errors_text(validation.stored)}. Measured here: "
        f"{errors_text(largest)}."
    ]
    if validation.surpassed:
        lines.append(
            "Note: the error is larger than the file says, at least "
            f"{errors_text(validation.surpassed)}."
        )
    return lines


def certainty_line() -> str:
    """Say how the numbers are to be read."""
    return (
        "Noise is what a distance would be on average if the table were exact (AUC: 0.5). The "
        "error without it lies between the limits. A table that has the accuracy is said to miss "
        f"it in at most {FALSE_ALARMS:.0%} of all validations; one that misses it where it was "
        f"looked at is said to hold in at most {FALSE_HOLDS:.0%}."
    )
