"""Results of a validation as tables and sentences, for terminal and page."""

from collections.abc import Mapping, Sequence

from tablegen.accuracy.comparison import Comparison, Measured
from tablegen.accuracy.judgement import Judged, advice
from tablegen.accuracy.validate import Validation
from tablegen.config.metric_table import METRICS, little_declared, metric_of
from tablegen.presentation import TextTable

_JUDGED = (
    "A number holds if it is within its limit when three errors are taken off. Of numbers that are "
    "within, at most one in 700 is said to miss. All hold noise."
)


def numbers_table(numbers: Sequence[Judged], stored: Mapping[str, float]) -> TextTable:
    """Make the table of judged numbers, beside those that the table file stores."""
    head = ["", "worst", "error", "limit", "", "stored", "worst at"]
    rows = []
    for number in numbers:
        metric, estimate = metric_of(number.name), number.estimate
        rows.append(
            [
                number.name,
                metric.text(estimate.value),
                metric.text(estimate.error),
                f"{number.allowed:g}",
                "holds" if number.holds else "MISSED",
                metric.text(stored[number.name]) if number.name in stored else "",
                number.place.replace(" degrees", "°"),
            ]
        )
    return TextTable("Distances to direct simulation", head, rows)


def conditions_table(measured: Sequence[Measured], caption: str) -> TextTable:
    """Make the table of the distances at each condition, with their errors."""
    head = ["condition", *(column for m in METRICS.values() for column in (m.head, "error"))]
    rows = []
    for comparison in measured:
        cells = [comparison.place.replace(" degrees", "°")]
        for name, metric in METRICS.items():
            estimate = comparison.estimates[name]
            cells += [metric.text(estimate.value), metric.text(estimate.error)]
        rows.append(cells)
    return TextTable(caption, head, rows)


def detail_tables(validation: Validation) -> list[TextTable]:
    """Make the tables of all conditions of a validation, and of the means at each."""
    spin = "Spin law, without spin, with the own grain"
    laws = {"First impacts": validation.comparisons, spin: validation.own}
    tables = [conditions_table(some, caption) for caption, some in laws.items() if some]
    return tables + [detail_table(c) for some in laws.values() for c in some]


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


def verdict_words(missed: Sequence[object], accuracy: str = "declared accuracy") -> str:
    """Say in one sentence whether an accuracy holds; every text and page uses these words.

    ``accuracy`` is "declared accuracy" or "accuracy asked for".
    """
    return f"The {accuracy} is missed." if missed else f"The {accuracy} holds."


def verdict_lines(validation: Validation) -> list[str]:
    """Say whether the accuracy holds, and if not, what to change."""
    config, missed = validation.config, validation.missed
    same = (validation.asked, validation.asked_spin) == (config.accuracy, config.spin_targets)
    words = verdict_words(missed, "declared accuracy" if same else "accuracy asked for")
    return [words, advice(validation.numbers)] if missed else [words]


def validation_notes(validation: Validation) -> list[str]:
    """Say what was compared, with which seed, and how it was judged."""
    seed, count = validation.seed, len(validation.comparisons)
    states = f"{validation.comparisons[0].states:,} states a side" if count else "no states"
    lines = [f"{count} condition{'s' * (count != 1)} of the first-impact law, {states}."]
    if validation.own:
        lines.append(
            f"Spin law: {len(validation.own)} conditions without spin, and {len(validation.hits)} "
            "groups of hits along chains."
        )
    lines += [_JUDGED, f"Seed {seed}: --seed {seed} makes the same validation again."]
    if little := little_declared(validation.config.accuracy.model_dump()):
        lines.append(f"Note: {little}.")
    return lines
