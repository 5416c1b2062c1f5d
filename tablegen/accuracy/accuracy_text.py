"""Write the result of a validation as tables and sentences, for the terminal and for HTML pages."""

from collections.abc import Mapping, Sequence

from tablegen.accuracy.comparison import Comparison, ConditionDistances
from tablegen.accuracy.judgement import Judged, advice
from tablegen.accuracy.validate import Validation
from tablegen.config.metric_table import METRICS, SPIN, little_declared, metric_of
from tablegen.presentation import TextTable

_JUDGEMENT_RULE = (
    "A number holds if number - 3 error is within its limit. If the true distance is within the "
    "limit, the number misses it with a probability of at most 1 in 700. All numbers include "
    "sampling noise."
)

_NEARLY_ROUND = (
    "Nearly round grains rebound almost alike, so small errors of their spin law are large "
    "distances."
)


def numbers_table(numbers: Sequence[Judged], stored: Mapping[str, float]) -> TextTable:
    """Make the table of judged numbers, beside the numbers that the table file stores."""
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


def conditions_table(measured: Sequence[ConditionDistances], caption: str) -> TextTable:
    """Make a table of the distances at each condition, with their errors."""
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
    """Make the tables of distances at all conditions, then a table of means for each condition."""
    laws = {
        "Law of first impacts": validation.comparisons,
        "Spin law, at impacts without spin": validation.own,
    }
    tables = [conditions_table(law, caption) for caption, law in laws.items() if law]
    return tables + [detail_table(one) for law in laws.values() for one in law]


def detail_table(comparison: Comparison) -> TextTable:
    """Make a table of means, modes, energy and scattering angles at one condition."""
    distances = comparison.estimates["ks"].by_variable
    sides = comparison.table, comparison.direct
    rows = []
    for k, (name, ks) in enumerate(zip(comparison.variables, distances, strict=True)):
        numbers = [side.mean[k] for side in sides] + [side.mode[k] for side in sides] + [ks]
        rows.append([name, *(f"{x:.4f}" for x in numbers)])
    energies = [f"{side.translational_energy:.4f}" for side in sides]
    rows.append(["translational energy after / kinetic energy before", *energies, "", "", ""])
    for k, name in enumerate(("alpha2", "beta2")):
        means = [f"{side.scattering_mean_deg[k]:.2f}" for side in sides]
        spreads = [f"{side.scattering_standard_deviation_deg[k]:.2f}" for side in sides]
        rows.append([f"{name}, mean [degrees]", *means, "", "", ""])
        rows.append([f"{name}, standard deviation [degrees]", *spreads, "", "", ""])
    head = ("", "mean, table", "direct", "most probable, table", "direct", "KS")
    return TextTable(f"At {comparison.place}", head, rows)


def verdict_words(missed: Sequence[object], accuracy: str = "declared accuracy") -> str:
    """Return one sentence on whether an accuracy holds; all texts and pages use this sentence.

    ``accuracy`` is "declared accuracy" or "accuracy asked for".
    """
    return f"The {accuracy} is missed." if missed else f"The {accuracy} holds."


def verdict_lines(validation: Validation) -> list[str]:
    """Return whether the accuracy holds, and if not, what to change."""
    config, missed = validation.config, validation.missed
    same = (validation.asked, validation.asked_spin) == (config.accuracy, config.spin_targets)
    words = verdict_words(missed, "declared accuracy" if same else "accuracy asked for")
    if not missed:
        return [words]
    lines = [words]
    if config.population.nearly_round and any(number.name.startswith(SPIN) for number in missed):
        lines.append(_NEARLY_ROUND)
    return [*lines, advice(validation.numbers)]


def validation_notes(validation: Validation) -> list[str]:
    """Return what was compared, with which seed, and how it was judged."""
    seed, count = validation.seed, len(validation.comparisons)
    lines = [f"The law of first impacts was compared at {count} condition{'s' * (count != 1)}."]
    if count:
        states = validation.comparisons[0].states
        lines = [f"{lines[0][:-1]}, with {states:,} states on each side."]
    if validation.own:
        lines.append(
            f"The spin law was compared at {len(validation.own)} conditions without spin, and at "
            f"{len(validation.hits)} groups of hits along chains."
        )
    lines += [_JUDGEMENT_RULE, f"To repeat this validation, give --seed {seed}."]
    if little := little_declared(validation.config.accuracy.model_dump()):
        lines.append(f"Note: {little}.")
    return lines
