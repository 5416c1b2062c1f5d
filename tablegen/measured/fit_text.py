"""Text of a calibration: the fits beside each other, and verdicts of one line each."""

import math
import re
from collections.abc import Iterator
from itertools import groupby

import numpy as np

from tablegen.measured.result import Calibration, Fit
from tablegen.presentation import table_lines


def fit_lines(calibration: Calibration) -> Iterator[str]:
    """Write the verdicts, the table of all fits, and the numbers that the data do not determine."""
    yield _means_text(calibration)
    if calibration.advice:
        about = "the laws do not give all means" if calibration.missed else "note"
        yield f"{about}: {calibration.advice}"
    yield _spreads_text(calibration.chosen)
    if len(calibration.fits) > 1:
        yield from _table(calibration)
    yield _numbers_text(calibration.chosen)


def _means_text(calibration: Calibration) -> str:
    """Say how far the worst mean is off."""
    fit, worst = calibration.chosen, calibration.chosen.means[0]
    digits = 3 if fit.holds else 4  # +0.0204 is beyond 0.02
    missed = sum(one.miss > 1.0 for one in fit.means)
    count = len(fit.means)
    result = f"give all {count}" if fit.holds else f"miss {missed} of {count}"
    return (
        f"means: {fit.grains} grains {result}; the worst is {worst.column} at {worst.place}, off "
        f"by {worst.residual:+.{digits}f} (up to {worst.tolerance:.3g} is allowed)"
    )


def _spreads_text(fit: Fit) -> str:
    """Say how the simulated spreads compare with the measured ones, to which no law is fitted."""
    if not fit.spreads:
        return (
            "spreads: none were measured, so they cannot choose the grains; --grains NAME takes "
            "other grains"
        )
    worst = max(fit.spreads, key=lambda one: abs(math.log(one.simulated / one.measured)))
    ratio = worst.simulated / worst.measured
    return (
        f"spreads: the worst is {worst.column} at {worst.place}, {ratio:.2f} "
        "times the measured one; a measured spread also contains those of sizes, speeds and the "
        "wall, and near 90 degrees e_t has no meaning"
    )


def _table(calibration: Calibration) -> Iterator[str]:
    """Write one row for each population."""
    rows, reasons = [], ["", *(_why(calibration, fit) for fit in calibration.fits)]
    for fit in calibration.fits:
        ratio = [one.simulated / one.measured for one in fit.spreads]
        spread = f"{math.exp(np.mean(np.log(ratio))):.2f}" if ratio else "-"
        rows.append((fit.grains, f"{fit.means[0].miss:.2f}", spread, f"{fit.misfit:.2f}"))
    head = ("grains", "worst mean / tolerance", "simulated / measured spread", "misfit")
    for line, reason in zip(table_lines(head, rows), reasons, strict=True):
        yield f"{line}  {reason}".rstrip()


def _why(calibration: Calibration, fit: Fit) -> str:
    """Say whether a population gives the means, and which one is chosen."""
    worst = fit.means[0]
    means = "gives all means" if fit.holds else f"misses {worst.column} at {worst.place}"
    if fit.grains != calibration.chosen.grains:
        return means
    reason = "least misfit" if fit.spreads else "the most angular with the least misfit"
    return f"chosen: {reason}; {means}"


def _numbers_text(fit: Fit) -> str:
    """Name the numbers that the data do not determine."""
    pairs = zip(fit.labels, fit.errors, strict=True)
    left = [_in_words(fit, label) for label, error in pairs if math.isnan(error)]
    if not left:
        return "the means determine all numbers of the laws"
    groups = groupby(left, key=lambda words: words[0])
    names = "; ".join(name + ", ".join(at for _, at in group) for name, group in groups)
    return (
        f"not determined by the means: {names}; these numbers come from smoothness or from a "
        "bound, so they have no standard error"
    )


def _in_words(fit: Fit, label: str) -> tuple[str, str]:
    """Say what a number is, and at which angle and speed of its law."""
    _, section, field = label.split(".")
    name, *places = re.findall(r"\w+", field)
    law = getattr(fit.config.pair, section)
    words = (name if "_" in name else f"{section} {name}").replace("_", " ")
    axes = (getattr(law, axis, None) or () for axis in ("angle_deg", "speed"))
    units = zip(places, axes, ("°", " m/s"), strict=False)
    at = " and ".join(f"{axis[int(k)]:g}{unit}" for k, axis, unit in units if len(axis) > int(k))
    return words.removesuffix(" value") + " at " * bool(at), at
