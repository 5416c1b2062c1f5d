"""Results as text for a terminal."""

from collections.abc import Callable, Mapping, Sequence

from tablegen.accuracy.comparison import Comparison
from tablegen.accuracy.decision import limits
from tablegen.config import AccuracyTargets
from tablegen.configuration.defaults import METRICS
from tablegen.studies.text_table import table_lines

#: Heads of the columns of `metric_row`, and their widths.
HEAD = ("alpha", "V", "states", "KS", "noise", "sliced W", "noise", "corr.", "noise", "AUC")
_WIDTHS = (8, 7, 11, 8, 7, 9, 7, 8, 7, 7)


def metric_row(comparison: Comparison) -> list[str]:
    """Condition, states a side, and the four distances, each but the AUC with its noise."""
    cells = [f"{comparison.alpha_deg:.2f}", f"{comparison.speed:.1f}", f"{comparison.states:,}"]
    for name in METRICS[:-1]:
        estimate = comparison.estimates[name]
        cells += [f"{estimate.value:.4f}", f"{estimate.noise:.4f}"]
    return [*cells, f"{comparison.auc:.3f}"]


def closing_rows(
    comparisons: Sequence[Comparison],
    declared: AccuracyTargets,
    asked: AccuracyTargets | None,
    together: int | None,
) -> list[tuple[str, list[float]]]:
    """Rows below the conditions: what is largest, its confidence limits, what is allowed.

    Parameters
    ----------
    comparisons : sequence of Comparison
    declared, asked : AccuracyTargets
        The second is left out if it is None or the same.
    together : int, optional
        How many comparisons are judged together, if more than these.

    Returns
    -------
    list of (str, list of four float)
        In the order of `METRICS`.
    """

    def largest(quantity: Callable[[str, Comparison], float]) -> list[float]:
        return [max(quantity(name, c) for c in comparisons) for name in METRICS]

    def limit(which: int) -> Callable[[str, Comparison], float]:
        return lambda name, c: limits(name, c.estimates[name], together or len(comparisons))[which]

    rows = [
        ("largest", largest(lambda name, c: c.estimates[name].value)),
        ("error at least", largest(limit(0))),
        ("error at most", largest(limit(1))),
        ("declared", [getattr(declared, name) for name in METRICS]),
    ]
    if asked is not None and asked != declared:
        rows.append(("asked for", [getattr(asked, name) for name in METRICS]))
    return rows


def accuracy_text(
    comparisons: Sequence[Comparison],
    declared: AccuracyTargets,
    asked: AccuracyTargets | None = None,
    together: int | None = None,
) -> str:
    """One line a condition with the four distances and their noise, then the rows that close.

    Noise is what a distance would be on average if the table were exact; an AUC would be 0.5.
    """
    lines = [_aligned(HEAD), *(_aligned(metric_row(c)) for c in comparisons)]
    for name, values in closing_rows(comparisons, declared, asked, together):
        cells = ["", "", ""]
        for value in values[:-1]:
            cells += [f"{value:.4f}", ""]
        line = _aligned([*cells, f"{values[-1]:.3f}"])
        lines.append(name + line[len(name) :])
    return "\n".join(lines)


def _aligned(cells: Sequence[str]) -> str:
    return " ".join(cell.rjust(width) for cell, width in zip(cells, _WIDTHS, strict=True))


#: Heads of the columns of `detail_rows`.
DETAIL_HEAD = ("", "mean, table", "direct", "most probable, table", "direct", "KS")


def detail_rows(comparison: Comparison) -> list[list[str]]:
    """Means, modes, energy and scattering angles at one condition, table beside direct."""
    c = comparison
    rows = [
        [
            name,
            f"{c.table.mean[k]:.4f}",
            f"{c.direct.mean[k]:.4f}",
            f"{c.table.mode[k]:.4f}",
            f"{c.direct.mode[k]:.4f}",
            f"{c.ks[k]:.4f}",
        ]
        for k, name in enumerate(c.components)
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
    title = f"at {comparison.alpha_deg:.2f} degrees, {comparison.speed:.1f} m/s"
    return "\n".join([title, *table_lines(DETAIL_HEAD, detail_rows(comparison))])


def time_text(seconds: Mapping[str, float]) -> str:
    """Say how the time of a generation splits between its stages, all workers together."""
    total = sum(seconds.values())
    parts = (f"{stage} {spent:.0f} s" for stage, spent in seconds.items())
    return f"{total:.0f} worker seconds: " + ", ".join(parts)
