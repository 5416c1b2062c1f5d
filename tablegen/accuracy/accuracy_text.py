"""Results of a measurement or validation as tables and sentences, for terminal and page."""

from collections.abc import Sequence
from typing import Any

from tablegen.accuracy.comparison import Comparison
from tablegen.accuracy.decision import FALSE_ALARMS, FALSE_HOLDS, limits, verdict_words
from tablegen.accuracy.joint_law import JointComparison
from tablegen.accuracy.later_hits import LaterHit
from tablegen.accuracy.validate import ValidatedLaw, Validation
from tablegen.config.metric_table import (
    METRICS,
    errors_text,
    little_declared,
    metric_of,
    spin_errors_text,
)
from tablegen.presentation import TextTable

_CERTAINTY = (
    "Noise is the mean distance if the table were exact (AUC: 0.5). The error without noise lies "
    "between the rows 'error at least' and 'error at most'. Of tables that have the accuracy, at "
    f"most {FALSE_ALARMS:.0%} are said to miss it; of tables that miss it at a compared condition, "
    f"at most {FALSE_HOLDS:.0%} are said to hold."
)


def accuracy_table(
    measured: Sequence[Comparison | JointComparison],
    declared: Any,
    asked: Any = None,
    together: int | None = None,
    caption: str = "Distances to direct simulation",
) -> TextTable:
    """Make the table of distances: each comparison, the largest, its limits, and the allowed ones.

    All comparisons have the same metrics. The accuracy asked for is left out if it is None or the
    declared one. ``together`` comparisons are judged together, if more than these.
    """
    metrics = {name: METRICS[name] for name in METRICS if name in measured[0].estimates}
    count, other = together or len(measured), asked is not None and asked != declared
    columns: list[list[str]] = []
    for name, metric in metrics.items():
        estimates = [c.estimates[name] for c in measured]
        lows, highs = zip(*(limits(name, e, count) for e in estimates), strict=True)
        values = [e.value for e in estimates]
        closing = [max(values), max(lows), max(highs), getattr(declared, name)]
        closing += [getattr(asked, name)] if other else []
        columns.append([metric.head, *(metric.text(x) for x in values + closing)])
        if not metric.learned:  # the noise of an AUC is known
            noise = [metric.text(e.noise) for e in estimates]
            columns.append(["noise", *noise, *[""] * len(closing)])
    titles = [c.place.replace(" degrees", "°") for c in measured]
    titles += ["largest", "error at least", "error at most", "declared", "asked for"][: 4 + other]
    states = [f"{c.states:,}" for c in measured] + [""] * (4 + other)
    head, *rows = zip(["condition", *titles], ["states", *states], *columns, strict=True)
    return TextTable(caption, head, rows)


def law_tables(law: ValidatedLaw, together: int) -> list[TextTable]:
    """Make the tables of all comparisons of a law, of ``together`` that are judged together."""
    measured = law.measured
    declared: Any = law.declared
    asked: Any = law.asked
    spin = "Spin law, without spin, with the own grain"
    between = spin if measured.prefix else "Distances to direct simulation"
    found = {between: measured.comparisons, "At the nodes that looked worst": measured.nodes}
    tables = [
        accuracy_table(some, declared, asked, together, caption)
        for caption, some in found.items()
        if some
    ]
    if measured.joint is not None:
        caption, both = "Spin law, over the impacts of chains", (declared.joint, asked.joint)
        tables.append(accuracy_table([measured.joint], *both, together, caption))
    for caption, later in (("cells of conditions", measured.cells), ("chains", measured.hits)):
        if later:
            tables.append(later_table(f"Spin law, {caption}", later, declared, together))
    return tables


def later_table(caption: str, later: Sequence[LaterHit], declared: Any, together: int) -> TextTable:
    """Make the table of later hits: the worst by each limit, and what is declared."""
    rows = []
    for limit in later[0].estimates:
        metric = metric_of(limit)
        worst = max(later, key=lambda one: one.estimates[limit].value)
        low, high = limits(limit, worst.estimates[limit], together)
        middle = sorted(one.estimates[limit].value for one in later)[len(later) // 2]
        numbers = worst.estimates[limit].value, low, high, middle, getattr(declared, limit)
        texts = map(metric.text, numbers)
        rows.append([limit.replace("_", " "), *texts, worst.place.replace(" degrees", "°")])
    head = ["", "largest", "error at least", "error at most", "median", "declared", "largest at"]
    return TextTable(f"{caption}, {len(later)} comparisons", head, rows)


def detail_table(comparison: Comparison) -> TextTable:
    """Make the table of means, modes, energy and scattering angles at one condition."""
    c, distances = comparison, comparison.estimates["ks"].by_variable
    sides = c.table, c.direct
    rows = []
    for k, (name, ks) in enumerate(zip(c.variables, distances, strict=True)):
        numbers = [side.mean[k] for side in sides] + [side.mode[k] for side in sides] + [ks]
        rows.append([name, *(f"{x:.4f}" for x in numbers)])
    energies = [f"{side.translational_energy:.4f}" for side in sides]
    rows.append(["translational energy, relative", *energies, "", "", ""])
    for k, name in enumerate(("alpha2", "beta2")):
        means = [f"{side.scattering_mean_deg[k]:.2f}" for side in sides]
        spreads = [f"{side.scattering_standard_deviation_deg[k]:.2f}" for side in sides]
        rows.append([f"{name}, mean [degrees]", *means, "", "", ""])
        rows.append([f"{name}, deviation [degrees]", *spreads, "", "", ""])
    head = ("", "mean, table", "direct", "most probable, table", "direct", "KS")
    return TextTable(f"At {c.place}", head, rows)


def whose(validation: Validation) -> str:
    """Name the accuracy that the verdict is about."""
    same = all(law.asked == law.declared for law in validation.laws)
    return "declared accuracy" if same else "accuracy asked for"


def verdict_lines(
    missed: Sequence[str], undecided: Sequence[str], accuracy: str = "declared accuracy"
) -> list[str]:
    """Say whether an accuracy holds, and what is missed or undecided."""
    return [
        verdict_words(missed, undecided, accuracy),
        *(f"missed: {line}" for line in missed),
        *(f"undecided: {line}" for line in undecided),
    ]


def validation_tables(validation: Validation) -> list[TextTable]:
    """Make the tables of all comparisons of a validation."""
    return [table for law in validation.laws for table in law_tables(law, validation.together)]


def validation_notes(validation: Validation) -> list[str]:
    """Say what was compared, with which seed, how it was judged, and what the file claims."""
    screening, seed = validation.screening, validation.seed
    law, spin = validation.law, validation.spin
    lines = []
    if screening is not None:
        lines.append(
            f"Looked at all {screening.nodes} nodes with {screening.samples:,} states a side, then "
            f"closely at {_conditions(law)} between nodes and at the {len(law.measured.nodes)} "
            "nodes that looked worst."
        )
    elif law.measured.comparisons:
        lines.append(
            f"Looked at {_conditions(law)} that you chose, and at nothing else of the table."
        )
    if spin is not None:
        lines.append(
            f"Looked at the spin law without spin at {_conditions(spin)}, in "
            f"{len(spin.measured.cells)} cells of conditions and after {len(spin.measured.hits)} "
            "hits of chains."
        )
        if spin.measured.joint is not None:
            lines.append(_joint_line(spin.measured.joint))
        else:
            lines.append("No chains of impacts were compared: they leave the table's range.")
    lines += [f"Seed {seed}: --seed {seed} makes the same validation again.", _CERTAINTY]
    if little := little_declared(validation.law.declared.model_dump()):
        lines.append(f"Note: {little}.")
    for found in validation.laws:
        lines += _stored_lines(found, validation.together)
    return lines


def _conditions(law: ValidatedLaw) -> str:
    """Give the number of conditions between nodes, in words."""
    count = len(law.measured.comparisons)
    return f"{count} condition{'s' if count != 1 else ''}"


def _joint_line(joint: JointComparison) -> str:
    """Say which impacts of chains were compared, and what the classifier knew."""

    def range_of(name: str, digits: int) -> str:
        low, middle, high = (f"{value:.{digits}f}" for value in joint.quantiles[name])
        return f"{middle} ({low} to {high})"

    return (
        "The chains: impacts 2 to 6 on one wall, between opposite walls and on walls of any "
        "direction, each particle with its own grain and orientation; median (1 to 99 %): angle "
        f"{range_of('alpha_deg', 1)} degrees, speed {range_of('speed', 1)} m/s, spin "
        f"{range_of('spin', 2)} V/a. The classifier sees "
        "condition, grain and outcome; without the grain its AUC is "
        f"{METRICS['auc'].text(joint.auc_without_grain.value)}."
    )


def _stored_lines(law: ValidatedLaw, together: int) -> list[str]:
    """Compare the accuracy that the file stores with the measured one."""
    if not law.measured.count:
        return []
    name = " of its spin law" if law.measured.prefix else ""
    text = spin_errors_text if law.measured.prefix else errors_text
    if law.stored is None:
        return [f"The file stores no accuracy{name}."]
    measured = {n: x for n, x in law.worst.items() if n in law.stored}
    lines = [
        f"Worst accuracy{name} stored in the file: {text(law.stored)}. Measured here: "
        f"{text(measured)}."
    ]
    if surpassed := law.surpassed(together):
        lines.append(f"Note: the error is larger than the file says, at least {text(surpassed)}.")
    return lines
