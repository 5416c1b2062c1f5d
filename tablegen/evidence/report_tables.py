"""What a report's page says in words and cells: verdict, figures that matter most, tables."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from sampler.formats.channels import STATE
from tablegen.accuracy.comparison import Measured
from tablegen.accuracy.decision import judge, limits, verdict_words
from tablegen.config.metric_table import METRICS
from tablegen.evidence.benchmark import Benchmark, MethodResult
from tablegen.evidence.labels import quantity_text
from tablegen.evidence.report_data import ReportData
from tablegen.evidence.report_text import size_text

#: Columns of `stored_rows`.
ACCURACY_HEAD = (
    "condition",
    *(cell for m in METRICS.values() for cell in (m.head, "of")[: 1 + m.per_variable]),
)

#: Columns of `map_rows`.
MAP_HEAD = (*ACCURACY_HEAD, "share of declared", "by")

#: Columns of `sample_rows`.
SAMPLE_HEAD = ("sample", "ms", *(m.head for m in METRICS.values() if not m.learned))


def declared(report: ReportData) -> dict[str, float]:
    """Largest distances that the table declares."""
    targets = report.config.accuracy
    return {name: getattr(targets, name) for name in METRICS}


def _worst_share(point: Measured, report: ReportData) -> tuple[float, float, str]:
    """Limits of the error in units of what is declared, high and low; and of which metric."""
    count, shares = len(report.atlas.points), []
    for name, most in declared(report).items():
        low, high = limits(name, point.estimates[name], count)
        shares.append((METRICS[name].share(high, most), METRICS[name].share(low, most), name))
    return max(shares)


def headline(report: ReportData) -> tuple[str, str, list[str]]:
    """Kind, sentence and lines: whether the declared accuracy holds, by this run and as stored."""
    judged = judge(report.atlas.points, report.config.accuracy)
    stored = [
        f"{name}: the table stores {largest:.4f}, noise included, where {most:g} is declared"
        for name, most in declared(report).items()
        if (largest := float(np.max(report.stored.get(name, 0.0), initial=0.0))) > most
    ]
    words = verdict_words(judged.missed, [*judged.undecided, *stored], "declared accuracy")
    lines = [*judged.missed, *judged.undecided, *stored]
    return "bad" if judged.missed else "open" if lines else "good", words, lines


def _fastest(race: Benchmark, family: str) -> MethodResult:
    """First method of a family: as configured, or the table of the report."""
    return next(runner for runner in race.runners if runner.family == family)


def key_figures(report: ReportData) -> list[tuple[str, str, str]]:
    """Name, figure and remark of what matters most."""
    evidence, stored, points = report.evidence, report.stored, report.atlas.points
    race = evidence.races[-1]
    direct, drawn = _fastest(race, "direct simulation"), _fastest(race, "table")
    slow, fast = (quantity_text(1e-9 * runner.nanoseconds, "s") for runner in (direct, drawn))
    high, low, name = max(_worst_share(point, report) for point in points)
    measured = len(stored["alpha_deg"])
    return [
        ("size of the table", size_text(evidence.table_bytes), "whole range of angles and speeds"),
        (
            "one draw, one thread",
            quantity_text(1e-9 * evidence.random_nanoseconds, "s"),
            "at random conditions",
        ),
        (
            "direct simulation takes",
            f"{direct.nanoseconds / drawn.nanoseconds:.1f} ×",
            f"as long: {slow} against {fast} at {race.alpha_deg:g}°, {race.speed:g} m/s",
        ),
        *(
            (
                f"worst {METRICS[metric].short}",
                METRICS[metric].text(float(np.max(stored[metric]))),
                f"declared at most {limit:g}; {measured} conditions, noise included",
            )
            for metric, limit in declared(report).items()
            if measured and metric in stored
        ),
        (
            "worst cell of this run",
            f"{low:.0%} to {high:.0%}",
            f"of what is declared, noise allowed for, by {METRICS[name].short}; "
            f"{len(points)} conditions",
        ),
    ]


def _cells(distances: Mapping[str, Any], of_variable: bool = True) -> list[str]:
    """Each metric; of one by variable the largest, and of which variable it is."""
    cells = []
    for name, metric in METRICS.items():
        if name in distances:
            cells.append(metric.text(float(np.max(distances[name]))))
            if metric.per_variable:
                cells.append(STATE[int(np.argmax(distances[name]))] if of_variable else "")
    return cells


def _point_row(point: Measured) -> list[str]:
    return [f"{point.alpha_deg:.2f}°, {point.speed:.1f} m/s", *_cells(point.distances())]


def _closing_rows(report: ReportData) -> list[list[str]]:
    """Give what noise alone leaves, and what is declared."""
    points = report.atlas.floor
    floor = {name: np.mean([p.estimates[name].value for p in points]) for name in METRICS}
    limits_ = ["declared"]
    for name, limit in declared(report).items():
        limits_ += [f"{limit:g}", ""][: 1 + METRICS[name].per_variable]
    return [["noise floor (mean)", *_cells(floor, of_variable=False)], limits_]


def stored_rows(report: ReportData) -> list[list[str]]:
    """Accuracy that the table carries, for the columns of `ACCURACY_HEAD`."""
    stored, rows = report.stored, []
    for k, (alpha_deg, speed) in enumerate(zip(stored["alpha_deg"], stored["speed"], strict=True)):
        cells = _cells({name: values[k] for name, values in stored.items()})
        rows.append([f"{alpha_deg:.2f}°, {speed:.1f} m/s", *cells])
    return [*rows, _closing_rows(report)[-1]]


def map_rows(report: ReportData, count: int | None = None) -> list[list[str]]:
    """Cells of the map that come nearest to what is declared first: `MAP_HEAD`."""
    points = report.atlas.points
    ranked = sorted(((*_worst_share(p, report), k) for k, p in enumerate(points)), reverse=True)
    rows = [
        [*_point_row(points[k]), f"{low:.2f} to {high:.2f}", METRICS[name].short]
        for high, low, name, k in ranked[:count]
    ]
    floor, limit = _closing_rows(report)
    return [*rows, [*floor, "", ""], [*limit, "1.00", ""]]


def identity_rows(report: ReportData) -> list[list[str]]:
    """Say what the table is and where it comes from."""
    config, file = report.config, report.identity
    alpha, speed = config.domain.alpha_deg, config.domain.speed
    made_with = f"rebound-tables {file['software_version']}, format {file['format_version']}"
    return [
        ["Particle on wall", f"{config.pair.particle} on {config.pair.wall} ({file['pair']})"],
        ["Impact angle", f"{alpha[0]:g}° to {alpha[1]:g}°"],
        ["Speed", f"{speed[0]:g} to {speed[1]:g} m/s"],
        ["Restitution law", config.pair.restitution.source],
        ["Resistance law", config.pair.resistance.source],
        ["Content SHA-256", file["content_sha256"]],
        ["Seed", file["seed"]],
        ["Made with", made_with],
        ["Size of the file", f"{report.evidence.table_bytes:,} bytes"],
    ]


def sample_rows(report: ReportData) -> list[list[str]]:
    """List samples of growing size: name, milliseconds, and the metrics without a classifier."""
    return [
        [
            f"{s.family}, {s.count:,} states",
            f"{1e3 * s.seconds:.3g}",
            *_cells({name: error.mean for name, error in s.errors.items()}, of_variable=False),
        ]
        for s in report.evidence.sizes
    ]
