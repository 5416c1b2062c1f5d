"""File of a fitted pair: a complete pair with comments that say how it was made.

The lines of text about a fit are also those that ``tablegen calibrate`` prints.
"""

import re
import textwrap
import tomllib
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import tomli_w

import sampler
from sampler.formats.channels import STATE
from tablegen.config.config import Config, parse_config
from tablegen.config.scenes import Tree, merged
from tablegen.measured.measurements import Measurements
from tablegen.measured.parameters import WALL_TILT
from tablegen.measured.result import Calibration, FittedNumber, Task
from tablegen.model.float_array import FloatArray

#: Characters of a comment line, and of a list of numbers on one line; numbers that a verdict names.
_WIDTH, _LIST_WIDTH, _NAMED = 100, 80, 3

#: Share that calibrations of angular grains may free: rounded ones keep more velocity at the wall.
_ROUNDED = "population.shapes.ellipsoid"

#: List of numbers on several lines.
_LIST = re.compile(r"\[\n\s*((?:-?[0-9.][0-9.e+-]*,\s*)+)\]")


def fitted_config(
    start: Config, changes: Tree, name: str, used: Measurements, speeds: FloatArray
) -> Config:
    """Lay fitted numbers over a pair, with the settings of a compact table with a spin law.

    The range of speeds of a fitted law of restitution is that of the rows, if all state one. The
    materials are those that the measurements name. The roughness has no place in the file.
    """
    fields = {key: value for key, value in changes.items() if key != WALL_TILT}
    tree = merged(tomllib.loads(start.text), fields)
    tree["name"] = name
    pair = tree["pair"] = dict(tree["pair"])
    pair.pop("name", None)
    for part in ("particle", "wall"):
        if used.about.get(part, "").strip():
            pair[part] = used.about[part]
    sources = "; ".join(dict.fromkeys(used.source))
    for section in changes.get("pair", {}):
        law = pair[section] = dict(pair[section])
        law["source"] = (
            f"coefficients fitted to measured rebounds ({used.name}: {sources}) by direct "
            f"simulation with rebound-tables {sampler.__version__}; no other source"
        )
    if "restitution" in changes.get("pair", {}):
        pair["restitution"].pop("valid_speed", None)
        if np.isfinite(used.speed).all():
            ends = [float(used.speed.min()), float(used.speed.max())]
            pair["restitution"]["valid_speed"] = ends
    tree["domain"] = _domain(start, used, speeds, pair["restitution"].get("valid_speed"))
    tree["spin"] = not set(start.domain.columns) - set(STATE)
    tree["accuracy"] = {"preset": "compact"}
    tree.pop("spin_accuracy", None)
    for nodes in ("alpha_nodes_deg", "speed_nodes"):
        tree.get("table", {}).pop(nodes, None)
    return parse_config(_LIST.sub(_on_one_line, tomli_w.dumps(tree)), name)


def _domain(
    start: Config, used: Measurements, speeds: FloatArray, valid: Sequence[float] | None
) -> Tree:
    """Choose what a table of the pair covers.

    Its angles are those of the start pair and the measured ones: later hits have any angle, and a
    law of contact holds for all. Without a dependence on the speed one stands for all.
    """
    domain = start.domain.model_dump(mode="json", exclude_none=True)
    angles = [*domain["alpha_deg"], *used.alpha_deg.tolist()]
    domain["alpha_deg"] = [min(angles), max(angles)]
    if not start.pair.restitution.depends_on_speed:
        domain["speed"] = [float(np.median(speeds))] * 2
    first, last = domain["speed"]
    domain["extrapolate"] = valid is None or not valid[0] <= first <= last <= valid[1]
    return domain


def _on_one_line(found: re.Match[str]) -> str:
    """Write a list of numbers on one line, if it is short."""
    items = [item.strip() for item in found[1].split(",") if item.strip()]
    line = f"[{', '.join(items)}]"
    return line if len(line) <= _LIST_WIDTH else found[0]


def with_comments(made: Calibration, task: Task) -> Config:
    """Put comments about a fit at the head of its pair."""
    sections = [
        _origin(made, task),
        [line for verdict in _verdicts(made) for line in _wrapped(verdict, "  ")],
        ["Fitted numbers:", *_indented(_parameters(made))],
    ]
    for kind, held_out in (("used by the fit", False), ("held out, predicted", True)):
        rows = [number for number in made.numbers if number.held_out == held_out]
        if rows:
            title = f"Rows {kind}; 'of the fit' is the simulated number's standard error:"
            sections.append([title, *_indented(_rows(rows))])
    if made.warnings:
        lines = [line for warning in made.warnings for line in _wrapped(f"- {warning}", "  ")]
        sections.append(["Warnings:", *lines])
    comments = "\n#\n".join("\n".join(f"# {line}".rstrip() for line in lines) for lines in sections)
    return parse_config(f"{comments}\n\n{made.config.text}", made.config.name)


def fit_lines(made: Calibration) -> Iterator[str]:
    """Write the verdicts, the fitted numbers, how closely the pair follows, and warnings."""
    yield from _verdicts(made)
    yield from _parameters(made)
    if np.isfinite(made.scatter):
        yield (
            f"residuals: {made.scatter:.2f} times the accuracy of the measured numbers "
            f"({made.freedom} degrees of freedom)"
        )
    for warning in made.warnings:
        yield f"warning: {warning}"


def _verdicts(made: Calibration) -> list[str]:
    """Say how closely a pair follows means, spreads, the start pair's means and rows held out."""
    pair = made.config.pair
    laws = f"{pair.restitution.law} restitution and {pair.resistance.law} resistance"
    lines = [_verdict("means", made.fitted(spreads=False), laws)]
    spreads = made.fitted(spreads=True)
    lines.append(_verdict("spreads", spreads, laws) if spreads else "spreads: not used")
    if parts := [one.simulated / one.measured for one in spreads if one.measured > 0.0]:
        lines[-1] += f"; {min(parts):.0%} to {max(parts):.0%} of the measured ones"
    shapes = made.config.population.shapes.positive().keys()
    angular = shapes and not shapes & {"ellipsoid", "sphere"}
    if made.missed and angular and _ROUNDED not in made.labels:
        lines.append(f"rounded grains may follow the means: free {_ROUNDED} as well")
    start, end = made.of_means
    if end > start:
        lines.append(
            f"the fit is worse in the means than its start: {end:.2f} and {start:.2f} times their "
            "accuracies (root mean square)"
        )
    for column, one in made.largest(held_out=True).items():
        lines.append(
            f"largest residual of {column}, held out: {one.residual:+.3f} at {one.alpha_deg:g} "
            f"degrees (simulated {one.simulated:.3f} +- {one.predicted:.3f})"
        )
    return lines


def _verdict(kind: str, numbers: Sequence[FittedNumber], laws: str) -> str:
    """Say which means, or spreads, are farther off than errors explain."""
    worst = sorted(numbers, key=lambda number: -number.excess)
    missed = [number for number in worst if number.excess > 1.0]
    firsts = {number.column: number for number in reversed(worst)}
    named = ", ".join(
        f"{one.column} {one.residual:+.3f} at {one.alpha_deg:g} degrees "
        f"({'up to +' if one.bound else ''}{one.allowed:.3g} allowed)"
        for one in (missed[:_NAMED] or firsts.values())
    )
    if missed:
        return f"{kind}: {laws} miss {len(missed)} of {len(numbers)}: {named}"
    return f"{kind}: all {len(numbers)} held within errors; farthest off {named}"


def _wrapped(text: str, indent: str = "") -> list[str]:
    whole_words: dict[str, Any] = {"break_long_words": False, "break_on_hyphens": False}
    return textwrap.wrap(text, _WIDTH - len("# "), subsequent_indent=indent, **whole_words)


def _indented(lines: Sequence[str]) -> list[str]:
    return [f"  {line}" for line in lines]


def _origin(made: Calibration, task: Task) -> list[str]:
    """Write the data and settings of a fit."""
    data, start, tilt = task.measurements, task.start.name, made.wall_tilt_deg
    checksum = f" (SHA-256 {task.checksum})" if task.checksum else ""
    lines = [
        *_wrapped(f"Fitted to measured rebounds: {data.about.get('title', data.name)}."),
        "",
        *_wrapped(
            f"Made by tablegen calibrate of rebound-tables {sampler.__version__} from the file "
            f"{data.name}.csv{checksum}, starting from the pair {start}; seed "
            f"{task.seed}, {task.count} particles of each shape at each condition."
        ),
        *_wrapped(f"Free: {', '.join(task.free)}. All else is as in {start}."),
    ]
    if task.speed is not None and not np.isfinite(data.speed).all():
        lines += _wrapped(f"Rows that state no speed were simulated at {task.speed:g} m/s.")
    if tilt > 0.0:
        lines += _wrapped(
            f"The wall is rough: its facets tilt by {tilt:.3g} degrees (standard deviation), "
            f"which no pair file states; draw with roughness = {np.radians(tilt):.4g} rad."
        )
    return lines


def _parameters(made: Calibration) -> list[str]:
    width = max(map(len, made.labels))
    lines = [f"{'':{width}}  {'start':>10}  {'fitted':>10}  {'standard error':>14}"]
    columns = zip(made.labels, made.given, made.values, made.errors, strict=True)
    for label, given, value, error in columns:
        shown = f"{error:.4g}" if np.isfinite(error) else "-"
        lines.append(f"{label:{width}}  {given:>10.4g}  {value:>10.4g}  {shown:>14}")
    return lines


def _rows(numbers: Sequence[FittedNumber]) -> list[str]:
    """Write the table of measured and simulated numbers."""
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
