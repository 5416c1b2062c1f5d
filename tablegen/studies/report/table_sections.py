"""Sections of a report's page on the table itself: summary, identity, accuracy, joint law."""

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

import numpy as np

from sampler.formats.channels import STATE
from tablegen.accuracy.comparison import Measured
from tablegen.accuracy.decision import judge, limits
from tablegen.accuracy.verdict import verdict_words
from tablegen.configuration.metric_table import METRICS
from tablegen.studies.report.benchmark import Benchmark, MethodResult
from tablegen.studies.report.labels import LABELS, METRIC_WORDS, SHORT
from tablegen.studies.report.report_data import ReportData
from tablegen.studies.report.report_html import (
    Choice,
    controls,
    folded,
    plot,
    section,
    table,
    tiles,
)
from tablegen.studies.report.report_text import machine_text, size_text

#: Worst cells that are listed.
_WORST = 8


def declared(dossier: ReportData) -> dict[str, float]:
    """Largest distances that the table declares."""
    targets = dossier.config.accuracy
    return {name: getattr(targets, name) for name in METRIC_WORDS}


def share_of_allowed(
    point: Measured, allowed: dict[str, float], count: int
) -> tuple[float, float, str]:
    """Largest error at a point in units of what is declared, without noise.

    Parameters
    ----------
    point : Measured
    allowed : dict
        Largest distances that are declared.
    count : int
        Points that are judged together.

    Returns
    -------
    high, low : float
        Confidence limits, as `tablegen.accuracy.decision.limits` has them.
    name : str
        Of the distance.
    """
    shares = []
    for name, most in allowed.items():
        low, high = limits(name, point.estimates[name], count)
        least = METRICS[name].least
        unit = max(most - least, 1e-9)
        shares.append(((high - least) / unit, (low - least) / unit, name))
    return max(shares)


def _fastest(race: Benchmark, family: str) -> MethodResult:
    """First way of a family: as configured, or the table of the report."""
    return next(runner for runner in race.runners if runner.family == family)


def headline(dossier: ReportData) -> str:
    """Say in one paragraph whether the declared accuracy holds, by this run and by the table."""
    judged = judge(dossier.atlas.points, dossier.config.accuracy)
    stored = [
        f"{name}: the table stores {largest:.4f}, noise included, where {most:g} is declared"
        for name, most in declared(dossier).items()
        if (largest := float(np.max(dossier.stored[name], initial=0.0))) > most
    ]
    words = verdict_words(judged.missed, [*judged.undecided, *stored], "declared accuracy")
    lines = [*judged.missed, *judged.undecided, *stored]
    kind = "bad" if judged.missed else "open" if lines else "good"
    items = "".join(f"<li>{escape(line)}</li>" for line in lines)
    return f'<p class="{kind}">{escape(words)}</p>' + (f"<ul>{items}</ul>" if items else "")


def summary_section(dossier: ReportData) -> str:
    """Tell what matters most, in a few figures."""
    evidence, stored, allowed = dossier.evidence, dossier.stored, declared(dossier)
    race = evidence.races[-1]
    direct, drawn = _fastest(race, "direct simulation"), _fastest(race, "table")
    measured = len(stored["auc"])
    items = [
        ("size of the table", size_text(evidence.table_bytes), "whole range of angles and speeds"),
        (
            "one draw, one thread",
            f"{evidence.random_nanoseconds:.0f} ns",
            "at random conditions",
        ),
        (
            "direct simulation takes",
            f"{direct.nanoseconds / drawn.nanoseconds:.1f} ×",
            f"as long: {direct.nanoseconds:.0f} ns against {drawn.nanoseconds:.0f} ns at "
            f"{race.alpha_deg:g}°, {race.speed:g} m/s",
        ),
    ]
    if measured:
        items += [
            (
                f"worst {SHORT[name]}",
                f"{float(np.max(stored[name])):.{3 if name == 'auc' else 4}f}",
                f"declared at most {limit:g}; {measured} conditions, noise included",
            )
            for name, limit in allowed.items()
        ]
    points = dossier.atlas.points
    high, low, name = max(share_of_allowed(point, allowed, len(points)) for point in points)
    items.append(
        (
            "worst cell of this run",
            f"{low:.0%} to {high:.0%}",
            f"of what is declared, noise allowed for, by {SHORT[name]}; {len(points)} conditions",
        )
    )
    return section("summary", "Summary", headline(dossier) + tiles(items))


def identity_section(dossier: ReportData) -> str:
    """Tell what the table is and where it comes from."""
    config, file = dossier.config, dossier.identity
    alpha, speed = config.domain.alpha_deg, config.domain.speed
    rows = [
        ["Particle on wall", f"{config.pair.particle} on {config.pair.wall} ({file['pair']})"],
        ["Impact angle", f"{alpha[0]:g}° to {alpha[1]:g}°"],
        ["Speed", f"{speed[0]:g} to {speed[1]:g} m/s"],
        ["Restitution law", config.pair.restitution.source],
        ["Resistance law", config.pair.resistance.source],
        ["Content SHA-256", file["content_sha256"]],
        ["Seed", file["seed"]],
        [
            "Made with",
            f"rebound-tables {file['software_version']}, format {file['format_version']}",
        ],
        ["Size of the file", f"{dossier.evidence.table_bytes:,} bytes"],
    ]
    text = f'<pre tabindex="0"><code>{escape(config.text)}</code></pre>'
    return section(
        "identity",
        "Identity and provenance",
        table("What the file says of itself", ["field", "value"], rows, "words")
        + folded("Configuration that the table was generated from", text),
    )


def _point_row(point: Measured) -> list[str]:
    return [f"{point.alpha_deg:.2f}°, {point.speed:.1f} m/s", *_metric_cells(point.distances())]


def _metric_cells(distances: Mapping[str, Any]) -> list[str]:
    """Each metric; of one by variable the largest, and of which variable it is."""
    cells = []
    for name, metric in METRICS.items():
        if name in distances:
            cells.append(metric.text(float(np.max(distances[name]))))
            if metric.per_variable:
                cells.append(STATE[int(np.argmax(distances[name]))])
    return cells


def _floor_row(points: Sequence[Measured]) -> list[str]:
    cells = ["noise floor (mean)"]
    for name, metric in METRICS.items():
        mean = float(np.mean([p.estimates[name].value for p in points]))
        cells += [metric.text(mean), ""][: 1 + metric.per_variable]
    return cells


#: Columns of the tables of accuracy.
_HEAD = ("condition", "KS", "of", "sliced W.", "corr.", "AUC")


def _declared_row(limits: dict[str, float]) -> list[str]:
    ks, *others = (f"{limit:g}" for limit in limits.values())
    return ["declared", ks, "", *others]


def _stored_rows(dossier: ReportData) -> list[list[str]]:
    """Cells of the accuracy that the table carries."""
    stored, rows = dossier.stored, []
    for k, (alpha_deg, speed) in enumerate(zip(stored["alpha_deg"], stored["speed"], strict=True)):
        cells = _metric_cells({name: values[k] for name, values in stored.items()})
        rows.append([f"{alpha_deg:.2f}°, {speed:.1f} m/s", *cells])
    return rows


def _worst_cells(dossier: ReportData) -> str:
    """Table of the conditions that come nearest to what is declared."""
    allowed, points = declared(dossier), dossier.atlas.points
    ranked = sorted(
        ((*share_of_allowed(point, allowed, len(points)), point) for point in points),
        key=lambda cell: cell[0],
        reverse=True,
    )
    worst = [
        [*_point_row(point), f"{low:.2f} to {high:.2f}", SHORT[name]]
        for high, low, name, point in ranked[:_WORST]
    ]
    floor = [*_floor_row(dossier.atlas.floor), "", ""]
    return table(
        f"The {len(worst)} conditions of this run that come nearest to what is declared, or "
        "exceed it; shares have the noise taken off",
        [*_HEAD, "share of declared", "by"],
        [*worst, floor, [*_declared_row(allowed), "1.00", ""]],
    )


def accuracy_section(dossier: ReportData) -> str:
    """Map the accuracy over angle and speed, and list the worst cells."""
    atlas, allowed = dossier.atlas, _declared_row(declared(dossier))
    lead = (
        f"Cells: this run, {atlas.samples:,} states a side, against fresh direct simulation. "
        "Ringed dots: what the table itself stores, measured when it was made at conditions "
        "between its nodes. Every number holds the noise of two finite samples, which the last "
        "rows of the tables below show; only what stands out above it is the table's error."
    )
    every = [*map(_point_row, atlas.points), _floor_row(atlas.floor), allowed]
    stored = [*_stored_rows(dossier), allowed]
    return section(
        "accuracy",
        "Accuracy over angle and speed",
        f"<p>{escape(lead)}</p>"
        + controls("Accuracy map", [Choice("map-metric", "Distance", METRIC_WORDS)])
        + plot("plot-map", "Distance of the table from direct simulation", "plot tall")
        + f"<h3>Worst cells</h3>{_worst_cells(dossier)}"
        + folded("Every cell of the map", table("This run", _HEAD, every))
        + folded("Accuracy stored in the table", table("Measured when it was made", _HEAD, stored)),
    )


def views_section(dossier: ReportData) -> str:
    """Show marginals and joint densities at a chosen condition."""
    conditions = {
        str(k): f"{view.alpha_deg:g}°, {view.speed:g} m/s" for k, view in enumerate(dossier.views)
    }
    choices = [
        Choice("view-condition", "Condition", conditions, str(len(conditions) // 2)),
        Choice("view-first", "First component", LABELS, "u"),
        Choice("view-second", "Second component", LABELS, "omega_z"),
    ]
    lead = (
        f"{dossier.views[0].count:,} states a side. The axes span the middle 99.8 % of the direct "
        "states. Colours of the densities are square roots, so that sparse regions show."
    )
    return section(
        "joint",
        "Marginals and joint law",
        f"<p>{escape(lead)}</p>"
        + controls("Marginals and joint law", choices)
        + '<div class="pair">'
        + plot("marginal-first", "Density of the first component")
        + plot("marginal-second", "Density of the second component")
        + '</div><div class="triple">'
        + plot("joint-direct", "Joint density, direct simulation")
        + plot("joint-table", "Joint density, table")
        + plot("joint-gap", "Table minus direct, in standard errors")
        + '</div><p id="joint-note" aria-live="polite"></p>',
    )


def footer_text(dossier: ReportData) -> str:
    """Say how the page was made."""
    evidence = dossier.evidence
    versions = ", ".join(
        f"{name} {number}" for name, number in evidence.machine["packages"].items() if number
    )
    command = f"tablegen report {evidence.table}" + (" --quick" if evidence.quick else "")
    return (
        f"Made by {command} --seed {evidence.seed} in {evidence.seconds:.0f} s (error against run "
        f"time) on {machine_text(evidence)}; {versions}."
    )
