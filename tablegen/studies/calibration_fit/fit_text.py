"""Text of a calibration for a terminal."""

from collections.abc import Iterator

import numpy as np

from tablegen.calibration.pair_file import parameter_lines
from tablegen.calibration.result import Calibration


def fit_lines(made: Calibration) -> Iterator[str]:
    """Lines that say what was fitted, how well the pair follows, and what is left open."""
    yield from parameter_lines(made.labels, made.given, made.values, made.errors)
    if np.isfinite(made.scatter):
        yield (
            f"residuals: {made.scatter:.2f} times the accuracy of the measured numbers "
            f"({made.freedom} degrees of freedom)"
        )
    for held_out, what in ((False, "largest residual"), (True, "largest residual, held out")):
        for column, one in made.largest(held_out).items():
            yield (
                f"{what} of {column}: {one.residual:+.4f} at {one.alpha_deg:g} degrees "
                f"(measured {one.measured:.4f}, simulated {one.simulated:.4f} +- "
                f"{one.predicted:.4f})"
            )
    for warning in made.warnings:
        yield f"warning: {warning}"
