"""Text of a calibration for a terminal."""

from collections.abc import Iterator

import numpy as np

from tablegen.measured.pair_file import parameter_lines, summary_lines
from tablegen.measured.result import Calibration


def fit_lines(made: Calibration) -> Iterator[str]:
    """Lines that say what was fitted, how well the pair follows, and what is left open."""
    yield from parameter_lines(made.labels, made.given, made.values, made.errors)
    if np.isfinite(made.scatter):
        yield (
            f"residuals: {made.scatter:.2f} times the accuracy of the measured numbers "
            f"({made.freedom} degrees of freedom)"
        )
    yield from summary_lines(made)
    for warning in made.warnings:
        yield f"warning: {warning}"
