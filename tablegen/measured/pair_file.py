"""The file of a fitted pair: complete, with comments that say how it was made."""

import re
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import tomli_w

import sampler
from tablegen.config.config import Config, parse_config
from tablegen.config.scenes import Tree, merged
from tablegen.measured.parameters import WALL_TILT
from tablegen.measured.records import Measurements
from tablegen.measured.result import Calibration, FittedNumber
from tablegen.model.float_array import FloatArray

#: Characters of a comment line.
_WIDTH = 100

#: List of numbers on several lines.
_ROW = re.compile(r"\[\n\s*((?:-?[0-9.][0-9.e+-]*,\s*)+)\]")

#: Most correlations that the comments list, the largest first.
_MOST_CORRELATIONS = 12

#: Correlations below this are not worth a line.
_LEAST_CORRELATION = 0.5


@dataclass(frozen=True)
class Provenance:
    """How a fit was made."""

    measurements: Measurements
    #: SHA-256 of the file of measurements; empty if there was none.
    checksum: str
    start: str
    free: tuple[str, ...]
    count: int
    seed: int
    #: Speed that was taken where rows state none.
    speed: float | None


def fitted_config(
    start: Config, changes: Tree, name: str, measurements: Measurements, used: Sequence[int]
) -> Config:
    """Lay fitted numbers over a pair.

    The range of speeds of a fitted law of restitution is that of the rows, if all state one. The
    materials are those that the measurements name.

    Parameters
    ----------
    start : Config
    changes : dict
        Of the pair file; the roughness, which is no field, is left out.
    name : str
        Of the new pair.
    measurements : Measurements
    used : sequence of int
        Rows of the fit.

    Returns
    -------
    Config
    """
    fields = {key: value for key, value in changes.items() if key != WALL_TILT}
    tree = merged(tomllib.loads(start.text), fields)
    tree["name"] = name
    pair = tree["pair"] = dict(tree["pair"])
    pair.pop("name", None)
    for part in ("particle", "wall"):
        if measurements.about.get(part, "").strip():
            pair[part] = measurements.about[part]
    sources = "; ".join(dict.fromkeys(measurements.source[k] for k in used))
    for section in changes.get("pair", {}):
        law = pair[section] = dict(pair[section])
        law["source"] = (
            f"coefficients fitted to measured rebounds ({measurements.name}: {sources}) by direct "
            f"simulation with rebound-tables {sampler.__version__}; no other source"
        )
    if "restitution" in changes.get("pair", {}):
        speeds = measurements.speed[list(used)]
        pair["restitution"].pop("valid_speed", None)
        if np.isfinite(speeds).all():
            pair["restitution"]["valid_speed"] = [float(speeds.min()), float(speeds.max())]
    valid, (first, last) = pair["restitution"].get("valid_speed"), tree["domain"]["speed"]
    if valid is None or not valid[0] <= first <= last <= valid[1]:
        tree["domain"] = {**tree["domain"], "extrapolate": True}
    return parse_config(_ROW.sub(_on_one_line, tomli_w.dumps(tree)), name)


def _on_one_line(found: re.Match[str]) -> str:
    """Write a list of numbers, which the writer spreads over lines, on one."""
    items = [item.strip() for item in found[1].split(",") if item.strip()]
    line = f"[{', '.join(items)}]"
    return line if len(line) <= _WIDTH - 20 else found[0]


def _number(value: float) -> str:
    return "-" if not np.isfinite(value) else f"{value:.4g}"


def _wrapped(text: str, indent: str = "") -> Iterator[str]:
    """Comment lines of a text."""
    line = "#"
    for word in text.split():
        if len(line) + 1 + len(word) > _WIDTH and line != "#":
            yield line
            line = f"# {indent}"
        line = f"{line} {word}" if not line.endswith(" ") else line + word
    yield line


def parameter_lines(
    labels: Sequence[str], given: FloatArray, values: FloatArray, errors: FloatArray
) -> list[str]:
    """Lines of a table of fitted numbers."""
    width = max(map(len, labels))
    lines = [f"{'':{width}}  {'start':>10}  {'fitted':>10}  {'standard error':>14}"]
    for label, *numbers in zip(labels, given, values, errors, strict=True):
        first, second, third = map(_number, numbers)
        lines.append(f"{label:{width}}  {first:>10}  {second:>10}  {third:>14}")
    return lines


def correlation_lines(labels: Sequence[str], correlation: FloatArray) -> list[str]:
    """Lines of the largest correlations between fitted numbers."""
    pairs = [
        (correlation[j, k], labels[j], labels[k])
        for j in range(len(labels))
        for k in range(j + 1, len(labels))
        if abs(correlation[j, k]) >= _LEAST_CORRELATION
    ]
    pairs.sort(key=lambda pair: -abs(pair[0]))
    return [f"{value:+.2f}  {one}, {other}" for value, one, other in pairs[:_MOST_CORRELATIONS]]


def number_lines(numbers: Sequence[FittedNumber]) -> list[str]:
    """Lines of a table of measured and simulated numbers."""
    lines = [
        f"{'angle':>7}  {'m/s':>7}  {'column':21}  {'measured':>9}  {'simulated':>9}  "
        f"{'residual':>9}  {'of the fit':>10}"
    ]
    for one in numbers:
        speed = "-" if one.speed is None else f"{one.speed:g}"
        lines.append(
            f"{one.alpha_deg:7.4g}  {speed:>7}  {one.column:21}  {one.measured:9.4f}  "
            f"{one.simulated:9.4f}  {one.residual:+9.4f}  {one.predicted:10.4f}"
        )
    return lines


def summary_lines(made: Calibration) -> list[str]:
    """Lines that say how closely the pair follows, and how much of the spreads it has."""
    lines = []
    for held_out, what in ((False, "largest residual"), (True, "largest residual, held out")):
        for column, one in made.largest(held_out).items():
            lines.append(
                f"{what} of {column}: {one.residual:+.3f} at {one.alpha_deg:g} degrees "
                f"(measured {one.measured:.3f}, simulated {one.simulated:.3f} +- "
                f"{one.predicted:.3f})"
            )
    for column, (least, most) in made.explained().items():
        lines.append(
            f"{column}: {least.simulated / least.measured:.0%} of the measured one at "
            f"{least.alpha_deg:g} degrees to {most.simulated / most.measured:.0%} at "
            f"{most.alpha_deg:g}"
        )
    return lines


def comment_text(made: Calibration, provenance: Provenance) -> str:
    """Comments at the head of a fitted pair file, with a line end."""
    of, wall_tilt_deg = provenance, made.wall_tilt_deg
    parameters = parameter_lines(made.labels, made.given, made.values, made.errors)
    correlations = correlation_lines(made.labels, made.correlation)
    title = of.measurements.about.get("title", of.measurements.name)
    checksum = f" (SHA-256 {of.checksum})" if of.checksum else ""
    lines = [
        *_wrapped(f"Fitted to measured rebounds: {title}."),
        "#",
        *_wrapped(
            f"Made by tablegen calibrate of rebound-tables {sampler.__version__} from the file "
            f"{of.measurements.name}.csv{checksum}, starting from the pair {of.start}; seed "
            f"{of.seed}, {of.count} particles of each shape at each condition."
        ),
        *_wrapped(f"Free: {', '.join(of.free)}. All else is as in {of.start}."),
    ]
    if of.speed is not None:
        lines += _wrapped(f"Rows that state no speed were simulated at {of.speed:g} m/s.")
    if wall_tilt_deg > 0.0:
        lines += _wrapped(
            f"The wall is rough: its facets tilt by {wall_tilt_deg:.3g} degrees (standard "
            f"deviation), which no pair file states; draw with roughness = "
            f"{np.radians(wall_tilt_deg):.4g} rad."
        )
    lines += ["#", "# How closely it follows:", *(f"#   {line}" for line in summary_lines(made))]
    lines += ["#", "# Fitted numbers:", *(f"#   {line}" for line in parameters)]
    if correlations:
        lines += ["#", "# Their largest correlations:", *(f"#   {line}" for line in correlations)]
    for text, held_out in (("used by the fit", False), ("held out, predicted", True)):
        rows = [number for number in made.numbers if number.held_out == held_out]
        if rows:
            lines += ["#", f"# Rows {text}; 'of the fit' is the simulated number's standard error:"]
            lines += [f"#   {line}" for line in number_lines(rows)]
    if made.warnings:
        lines += ["#", "# Warnings:"]
        for warning in made.warnings:
            lines += _wrapped(f"- {warning}", "  ")
    return "\n".join(line.rstrip() for line in lines) + "\n"
