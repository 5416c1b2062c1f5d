"""File of a fitted pair: a complete pair with comments that say how it was made."""

import textwrap
import tomllib
from collections.abc import Collection, Sequence

import numpy as np
import tomli_w

import sampler
from sampler.formats.channels import STATE
from tablegen.config.config import Config, parse_config
from tablegen.config.pairs import MaterialPair
from tablegen.config.scenes import Tree, merged, with_short_lists
from tablegen.measured.fit_text import fit_lines
from tablegen.measured.measurements import ANY_SPEED, Measurements, distinct_speeds
from tablegen.measured.result import Calibration, ComparedNumber, Fit
from tablegen.model.float_array import FloatArray
from tablegen.presentation import table_lines

#: Characters of a comment line.
_WIDTH = 100

#: Angles at the contact [degrees] between which laws are linear.
_ANGLES = [5.0, 15.0, 30.0, 45.0, 60.0, 75.0, 90.0]

#: Least distance [degrees] of a further angle.
_LEAST_DISTANCE_OF_ANGLES = 2.5

#: Most speeds of a table of restitution.
_MOST_SPEEDS = 4

#: A law that starts a fit: resistance, tangential restitution of spheres, and restitution where
#: none was measured.
_RESISTANCE, _REVERSAL, _RESTITUTION = 0.6, 0.2, 0.6

#: Source of numbers before a fit.
_NO_SOURCE = "none: numbers to start a fit from"

#: Limits of nearly round grains. What their shape adds to a sphere's rebound deviates by a few
#: thousandths of V, in rare rebounds that decide the correlations and weigh in distances that are
#: over deviations: 0.50 and 0.064 in a table of well-rounded quartz.
_ROUND_LIMITS = {"correlation_error": 0.5, "sliced_wasserstein": 0.07}


def starting_config(data: Measurements, population: Tree) -> Config:
    """Make a pair with tabulated laws, or those of spheres, to start a fit from."""
    stated = np.sort(data.speed[np.isfinite(data.speed)])
    law: Tree = {"law": "tabulated", "angle_deg": _ANGLES, "source": _NO_SOURCE}
    speeds = distinct_speeds(stated, _MOST_SPEEDS) or [ANY_SPEED]
    restitution = {**law, "speed": speeds, "value": _restitutions(data, len(speeds))}
    resistance: Tree = {**law, "value": [_RESISTANCE] * len(_ANGLES)}
    if {name for name, weight in population["shapes"].items() if weight} == {"sphere"}:
        resistance |= {"law": "coulomb", "static": _RESISTANCE / 3, "dynamic": _RESISTANCE / 3}
        resistance["tangential_restitution"] = [_REVERSAL] * len(_ANGLES)
        del resistance["value"]
    pair = {"particle": "not stated", "wall": "not stated"}
    ends = [float(stated[0]), float(stated[-1])] if stated.size else [ANY_SPEED] * 2
    tree = {
        "name": "start",
        "pair": {**pair, "restitution": restitution, "resistance": resistance},
        "population": population,
        "domain": {"alpha_deg": [0.05, 90.0], "speed": ends, "extrapolate": True},
    }
    return parse_config(tomli_w.dumps(tree), "start")


def with_angles(start: Config, angles: Collection[float]) -> Config:
    """Add knots at some angles to the tables of a pair that starts a fit, with their values.

    Angles near a knot are left out; the same configuration is returned if all are.
    """
    new = [
        a
        for a in sorted(angles)
        if np.abs(np.array(_ANGLES) - a).min() >= _LEAST_DISTANCE_OF_ANGLES
    ]
    if not new:
        return start
    knots, pair = np.array(sorted({*_ANGLES, *new})), start.pair
    changes: Tree = {}
    for section, field in (
        ("restitution", "value"),
        ("resistance", "value"),
        ("resistance", "tangential_restitution"),
    ):
        given = getattr(getattr(pair, section), field, None)
        if given is None:
            continue
        columns = np.array(given, dtype=np.float64).reshape(len(_ANGLES), -1).T
        values = np.array([np.interp(knots, _ANGLES, column) for column in columns]).T
        listed = values.tolist() if section == "restitution" else values.ravel().tolist()
        changes[section] = {"angle_deg": knots.tolist(), field: listed}
    return start.with_changes({"pair": changes})


def _restitutions(data: Measurements, speeds: int) -> list[list[float]]:
    """Begin with the restitution of the mass centre, the same at each of some speeds."""
    e_n = data.moments["e_n"].mean
    known = np.flatnonzero(np.isfinite(e_n))
    order = known[np.argsort(data.alpha_deg[known], kind="stable")]
    values = np.full(len(_ANGLES), _RESTITUTION)
    if order.size:
        values = np.interp(_ANGLES, data.alpha_deg[order], e_n[order]).clip(0.05, 0.95)
    return [[float(value)] * speeds for value in values]


def fitted_config(
    start: Config, changes: Tree, name: str, used: Measurements, speeds: FloatArray
) -> Config:
    """Lay fitted numbers over a pair, with the settings of a compact table with a spin law.

    The range of speeds of a fitted law of restitution is that of the rows, if all state one. The
    materials are those that the measurements name.
    """
    tree = merged(tomllib.loads(start.text), changes)
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
    tree["domain"] = _domain(start, MaterialPair.from_tree(pair), used, speeds)
    tree["spin"] = not set(start.domain.columns) - set(STATE)
    limits = _ROUND_LIMITS if start.population.nearly_round else {}
    tree["accuracy"] = {"preset": "compact", **limits}
    tree.pop("spin_accuracy", None)
    if limits and tree["spin"]:
        tree["spin_accuracy"] = limits
    for nodes in ("alpha_nodes_deg", "speed_nodes"):
        tree.get("table", {}).pop(nodes, None)
    return parse_config(with_short_lists(tomli_w.dumps(tree)), name)


def _domain(start: Config, fitted: MaterialPair, used: Measurements, speeds: FloatArray) -> Tree:
    """Choose what a table of the pair covers.

    Its angles are those of the start pair and the measured ones: later hits have any angle, and a
    law of contact holds for all. Without a dependence on the speed one stands for all.
    """
    domain = start.domain.model_dump(mode="json", exclude_none=True)
    angles = [*domain["alpha_deg"], *used.alpha_deg.tolist()]
    domain["alpha_deg"] = [min(angles), max(angles)]
    if not fitted.restitution.depends_on_speed:
        domain["speed"] = [float(np.median(speeds))] * 2
    first, last = domain["speed"]
    valid = fitted.restitution.valid_speed
    domain["extrapolate"] = valid is None or not valid[0] <= first <= last <= valid[1]
    return domain


def with_comments(calibration: Calibration, data: Measurements, seed: int) -> Config:
    """Put comments about a fit at the head of its pair."""
    fit = calibration.chosen
    sections = [
        _wrapped(f"Fitted to measured rebounds: {data.about.get('title', data.name)}."),
        _wrapped(
            f"Made by tablegen calibrate of rebound-tables {sampler.__version__} from "
            f"{data.name}.csv; grains: {fit.grains}; seed {seed}. The laws are the smoothest that "
            "give the measured means within their tolerances."
        ),
        [line for verdict in fit_lines(calibration) for line in _wrapped(verdict, "  ")],
        ["Fitted numbers, with standard errors:", *_indented(_parameters(fit))],
        ["Measured and simulated numbers:", *_indented(_rows(fit.numbers))],
    ]
    comments = "\n#\n".join("\n".join(f"# {line}".rstrip() for line in lines) for lines in sections)
    return parse_config(f"{comments}\n\n{calibration.config.text}", calibration.config.name)


def _wrapped(text: str, indent: str = "") -> list[str]:
    """Break a line of text, but for one that is a row of a table."""
    if "   " in text:
        return [text]
    return textwrap.wrap(
        text,
        _WIDTH - len("# "),
        subsequent_indent=indent,
        break_long_words=False,
        break_on_hyphens=False,
    )


def _indented(lines: Sequence[str]) -> list[str]:
    return [f"  {line}" for line in lines]


def _parameters(fit: Fit) -> list[str]:
    """Write the table of fitted numbers."""
    rows = zip(fit.labels, fit.values, fit.errors, strict=True)
    cells = [(n, f"{x:.4g}", "-" if np.isnan(error) else f"{error:.2g}") for n, x, error in rows]
    return list(table_lines(("", "fitted", "+-"), cells))


def _rows(numbers: Sequence[ComparedNumber]) -> list[str]:
    """Write the table of measured and simulated numbers."""
    head = ("angle", "m/s", "column", "measured", "simulated", "residual")
    cells = [
        (
            f"{one.alpha_deg:.4g}",
            "-" if one.speed is None else f"{one.speed:g}",
            one.column,
            f"{one.measured:.4f}",
            f"{one.simulated:.4f}",
            f"{one.residual:+.4f}",
        )
        for one in numbers
    ]
    return list(table_lines(head, cells))
