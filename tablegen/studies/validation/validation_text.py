"""What a validation looked at and how sure its verdict is, in sentences for terminal and page."""

from tablegen.accuracy.decision import FALSE_ALARMS, FALSE_HOLDS
from tablegen.configuration.metric_table import PRESETS
from tablegen.validate import Validation


def whose(validation: Validation) -> str:
    """Name the accuracy that the verdict is about."""
    same = validation.asked == validation.declared
    return "declared accuracy" if same else "accuracy asked for"


def coverage_lines(validation: Validation) -> list[str]:
    """Say what was looked at, with which seed, and whether the table declares little."""
    screening, count = validation.screening, len(validation.comparisons)
    conditions = f"{count} condition{'s' if count > 1 else ''}"
    if screening is None:
        lines = [f"Looked at {conditions} that you chose, and at nothing else of the table."]
    else:
        lines = [
            f"Looked at all {screening.nodes} nodes with {screening.samples:,} states a side, then "
            f"closely at {conditions} between nodes and at the {len(validation.nodes)} nodes that "
            "looked worst."
        ]
    seed = validation.seed
    lines.append(f"Seed {seed}: --seed {seed} makes the same validation again.")
    if validation.lenient:
        declared = ", ".join(f"{n} {getattr(validation.declared, n):g}" for n in validation.lenient)
        usual = ", ".join(f"{PRESETS['compact'][n]:g}" for n in validation.lenient)
        lines.append(
            f"Note: the table declares little: {declared}, where the preset compact has {usual}."
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
