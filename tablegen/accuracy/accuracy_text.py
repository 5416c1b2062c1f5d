"""Results as text for a terminal."""

from collections.abc import Callable, Mapping, Sequence

from tablegen.accuracy.comparison import Comparison, spin_text
from tablegen.accuracy.decision import limits
from tablegen.config.config import AccuracyTargets
from tablegen.config.metric_table import METRICS
from tablegen.config.spin_targets import SpinTargets
from tablegen.presentation import table_lines

#: Accuracies that a row may end with.
Declared = AccuracyTargets | SpinTargets

#: Heads of the columns of `accuracy_rows`; where noise is known, it is not listed.
HEAD = ["condition", "states"]
for _metric in METRICS.values():
    HEAD += [_metric.head] if _metric.learned else [_metric.head, "noise"]


def condition_text(comparison: Comparison) -> str:
    """Name a condition in a table."""
    c = comparison
    spin = "" if c.spin is None else f", {spin_text(c.spin)}"
    return f"{c.alpha_deg:.2f}°, {c.speed:.1f} m/s{spin}"


def _row(
    title: str, states: str, values: Mapping[str, float], noise: Mapping[str, float]
) -> list[str]:
    """Cells for the columns of `HEAD`."""
    cells = [title, states]
    for name, metric in METRICS.items():
        cells.append(metric.text(values[name]))
        if not metric.learned:
            cells.append(metric.text(noise[name]) if noise else "")
    return cells


def accuracy_rows(
    comparisons: Sequence[Comparison],
    declared: Declared,
    asked: Declared | None = None,
    together: int | None = None,
) -> list[list[str]]:
    """Cells of every condition; then what is largest, its confidence limits, what is allowed.

    Noise is what a distance would be on average if the table were exact; an AUC would be 0.5.

    Parameters
    ----------
    comparisons : sequence of Comparison
    declared, asked : AccuracyTargets or SpinTargets
        The second is left out if it is None or the same.
    together : int, optional
        How many comparisons are judged together, if more than these.

    Returns
    -------
    list of list of str
        For the columns of `HEAD`.
    """
    rows = []
    for c in comparisons:
        values = {name: estimate.value for name, estimate in c.estimates.items()}
        noise = {name: estimate.noise for name, estimate in c.estimates.items()}
        rows.append(_row(condition_text(c), f"{c.states:,}", values, noise))

    def largest(quantity: Callable[[str, Comparison], float]) -> dict[str, float]:
        return {name: max(quantity(name, c) for c in comparisons) for name in METRICS}

    def limit(which: int) -> Callable[[str, Comparison], float]:
        return lambda name, c: limits(name, c.estimates[name], together or len(comparisons))[which]

    closing = {
        "largest": largest(lambda name, c: c.estimates[name].value),
        "error at least": largest(limit(0)),
        "error at most": largest(limit(1)),
        "declared": declared.model_dump(),
    }
    if asked is not None and asked != declared:
        closing["asked for"] = asked.model_dump()
    return rows + [_row(name, "", values, {}) for name, values in closing.items()]


def accuracy_text(
    comparisons: Sequence[Comparison],
    declared: Declared,
    asked: Declared | None = None,
    together: int | None = None,
) -> str:
    """`accuracy_rows` for a terminal."""
    return "\n".join(table_lines(HEAD, accuracy_rows(comparisons, declared, asked, together)))


#: Heads of the columns of `detail_rows`.
DETAIL_HEAD = ("", "mean, table", "direct", "most probable, table", "direct", "KS")


def detail_rows(comparison: Comparison) -> list[list[str]]:
    """Means, modes, energy and scattering angles at one condition, table next to direct."""
    c, distances = comparison, comparison.estimates["ks"].by_variable
    rows = [
        [
            name,
            f"{c.table.mean[k]:.4f}",
            f"{c.direct.mean[k]:.4f}",
            f"{c.table.mode[k]:.4f}",
            f"{c.direct.mode[k]:.4f}",
            f"{ks:.4f}",
        ]
        for k, (name, ks) in enumerate(zip(c.variables, distances, strict=True))
    ]
    energies = (c.table.translational_energy, c.direct.translational_energy)
    rows.append(["translational energy, relative", *(f"{x:.4f}" for x in energies), "", "", ""])
    for k, name in enumerate(("alpha2", "beta2")):
        for words, field in (
            ("mean", "scattering_mean_deg"),
            ("deviation", "scattering_standard_deviation_deg"),
        ):
            angles = (getattr(side, field)[k] for side in (c.table, c.direct))
            rows.append([f"{name}, {words} [degrees]", *(f"{x:.2f}" for x in angles), "", "", ""])
    return rows


def details_text(comparison: Comparison) -> str:
    """`detail_rows` for a terminal."""
    title = f"at {comparison.place}"
    return "\n".join([title, *table_lines(DETAIL_HEAD, detail_rows(comparison))])


def time_text(seconds: Mapping[str, float]) -> str:
    """Say how the time of a generation splits between its stages, all workers together."""
    total = sum(seconds.values())
    parts = (f"{stage} {spent:.0f} s" for stage, spent in seconds.items())
    return f"{total:.0f} worker seconds: " + ", ".join(parts)
