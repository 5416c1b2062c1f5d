"""Sections of a report's page on cost: every way, tables of other sizes, sample size, numerics."""

from html import escape

from tablegen.studies.report.benchmark import Benchmark
from tablegen.studies.report.labels import METRIC_WORDS
from tablegen.studies.report.report_data import ReportData
from tablegen.studies.report.report_html import Choice, controls, folded, plot, section, table
from tablegen.studies.report.report_text import HEAD, SETTING_HEAD, benchmark_rows, setting_rows
from tablegen.studies.report.tolerances import FINEST

_COSTS = {"nanoseconds": "run time of a draw", "bytes": "bytes", "setup_seconds": "set-up time"}


def _at(race: Benchmark) -> str:
    return f"{race.alpha_deg:g}°, {race.speed:g} m/s"


def ways_section(dossier: ReportData) -> str:
    """Compare every way to get a rebound state."""
    evidence, effort = dossier.evidence, dossier.evidence.effort
    lead = (
        f"Each way gives {effort.batches} batches of {effort.batch:,} states, compared with "
        f"{effort.reference:,} direct ones; the classifier sees {effort.classified:,} a side. "
        "Bars: 95 % confidence intervals of the mean, from a bootstrap over the batches. Band: the "
        "noise floor, direct batches against the same reference; nothing can be seen to be better. "
        "Time: processor time of one thread."
    )
    fairness = (
        "The rivals of the table have the easier task: each is fitted at the very condition at "
        f"which it is judged, to {effort.training:,} states, and its bytes are those of that one "
        "condition. The table answers at any angle and speed, from nodes elsewhere, and its bytes "
        "are those of all. Forbidden: share of states that no rebound can have, which fly into "
        "the wall or have more translational energy than before. Direct simulation reads and sets "
        "up nothing."
    )
    left = "".join(f"<p>{escape(line)}</p>" for line in evidence.left_out)
    conditions = {str(k): _at(race) for k, race in enumerate(evidence.races)}
    tables = "".join(
        folded(
            f"Numbers at {_at(race)}",
            table(f"Every way at {_at(race)}", HEAD, benchmark_rows(race)),
        )
        for race in evidence.races
    )
    last = str(len(evidence.races) - 1)
    return section(
        "ways",
        "Error against run time",
        f"<p>{escape(lead)}</p><p>{escape(fairness)}</p>{left}"
        + controls(
            "Error against run time",
            [
                Choice("race-condition", "Condition", conditions, last),
                Choice("race-metric", "Error", METRIC_WORDS, "sliced_wasserstein"),
                Choice("race-cost", "Against", _COSTS),
            ],
        )
        + plot("plot-race", "Error against cost, every way to get a rebound state", "plot tall")
        + tables,
    )


def designs_section(dossier: ReportData) -> str:
    """Compare tables of other sizes on a small domain."""
    race = dossier.evidence.designs
    base = race.runners[0]
    lead = (
        f"{len(race.runners)} tables of a small part of the range, judged at {_at(race)}, between "
        f"their nodes. The base has {base.name}; each other table changes one of these. "
        "Generation is in worker seconds, simulation included."
    )
    return section(
        "designs",
        "Accuracy against bytes and generation time",
        f"<p>{escape(lead)}</p>"
        + controls(
            "Tables of other sizes",
            [
                Choice("design-metric", "Error", METRIC_WORDS, "auc"),
                Choice("design-cost", "Against", _COSTS, "bytes"),
            ],
        )
        + plot("plot-designs", "Error against cost, tables of other sizes")
        + folded(
            "Numbers of every table", table("Tables of other sizes", HEAD, benchmark_rows(race))
        ),
    )


def sizes_section(dossier: ReportData) -> str:
    """Show the error of samples of growing size."""
    samples = dossier.evidence.sizes
    rows = [
        [
            f"{s.family}, {s.count:,} states",
            f"{1e3 * s.seconds:.3g}",
            f"{s.errors['ks'].mean:.4f}",
            f"{s.errors['sliced_wasserstein'].mean:.4f}",
            f"{s.errors['correlation_error'].mean:.4f}",
        ]
        for s in samples
    ]
    words = {name: text for name, text in METRIC_WORDS.items() if name != "auc"}
    lead = (
        "A small sample is uncertain whatever it is drawn from. Both curves fall with the square "
        "root of the run time, the table's earlier, until the table's own error is left; the "
        "reference's own noise is in both."
    )
    return section(
        "sizes",
        "Error of a sample against its run time",
        f"<p>{escape(lead)} At {_at(dossier.evidence.races[-1])}.</p>"
        + controls("Sample sizes", [Choice("size-metric", "Error", words)])
        + plot("plot-sizes", "Error of samples of growing size")
        + folded(
            "Numbers of every size",
            table("Sample sizes", ["sample", "ms", "KS", "sliced W.", "corr."], rows),
        ),
    )


def numerics_section(dossier: ReportData) -> str:
    """Show what the numerics of the direct model cost and leave."""
    lead = (
        f"Every setting follows the same {dossier.evidence.effort.paths:,} particles as a much "
        f"finer one (resolution {FINEST[0]:g}, tolerance {FINEST[1]:g}), so the differences hold "
        "almost no sampling noise. Error: largest change of a mean, standard deviation, quantile "
        "or correlation."
    )
    return section(
        "numerics",
        "Numerics of direct simulation",
        f"<p>{escape(lead)}</p>"
        + plot("plot-numerics", "Error that contact resolution and flight tolerance leave")
        + folded(
            "Numbers of every setting",
            table("Contact resolution and tolerance", SETTING_HEAD, setting_rows(dossier.evidence)),
        ),
    )
