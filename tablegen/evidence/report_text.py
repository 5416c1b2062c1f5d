"""Error against run time as text for a terminal."""

from tablegen.config.metric_table import METRICS
from tablegen.evidence.benchmark import Benchmark, MethodResult
from tablegen.evidence.error_against_time import ErrorAgainstTime
from tablegen.evidence.labels import quantity_text
from tablegen.evidence.method_errors import BatchMean
from tablegen.evidence.spinning_impacts import SpinningImpacts
from tablegen.presentation import table_lines

#: Heads of the columns of `benchmark_rows`.
_HEADS = [metric.head for metric in METRICS.values()]
HEAD = ("method", "ns/draw", "bytes", "set-up s", *_HEADS, "forbidden")


def size_text(count: int) -> str:
    """Bytes in the unit that suits them."""
    return quantity_text(count, "B") if count else "-"


def error_texts(errors: dict[str, BatchMean]) -> list[str]:
    """Mean of each metric, and the share of forbidden states."""
    cells = [metric.text(errors[name].mean) for name, metric in METRICS.items()]
    share = errors["forbidden"].mean
    return [*cells, f"{share:.1%}" if share >= 5e-4 else f"{share:.0e}" if share else "0"]


def method_row(runner: MethodResult) -> list[str]:
    """Cells of one method, for the columns of `HEAD`."""
    return [
        f"{runner.family}: {runner.name}",
        f"{runner.nanoseconds:,.0f}",
        size_text(runner.bytes),
        f"{runner.setup_seconds:.2f}",
        *error_texts(runner.errors),
    ]


def benchmark_rows(race: Benchmark) -> list[list[str]]:
    """Cells of all methods at one condition, the noise floor first."""
    floor = ["noise floor: direct against direct", "", "", "", *error_texts(race.floor)]
    return [floor, *(method_row(runner) for runner in race.runners)]


#: Heads of the columns of `setting_rows`.
SETTING_HEAD = ("angle", "resolution", "tolerance", "ns", "error", "noise", "of")


def setting_rows(evidence: ErrorAgainstTime) -> list[list[str]]:
    """Cells of every setting of the direct model's numerics."""
    return [
        [
            f"{s.alpha_deg:g}",
            f"{s.resolution:g}",
            f"{s.tolerance:g}",
            f"{s.nanoseconds:.0f}",
            f"{s.error:.1e}",
            f"{s.noise:.1e}",
            s.statistic + (", default" if s.is_default else ""),
        ]
        for s in evidence.settings
    ]


#: Heads of the columns of `spinning_rows`.
SPINNING_HEAD = ("way", "ns, batch", "ns, one by one", "KS", "noise", "AUC", "impacts")


def spinning_rows(found: SpinningImpacts) -> list[list[str]]:
    """Cells of every way to rebound spinning particles."""
    ks, auc = METRICS["ks"], METRICS["auc"]
    return [
        [
            way.name,
            f"{way.batch_nanoseconds:,.0f}",
            f"{way.single_nanoseconds:,.0f}",
            ks.text(way.estimates["ks"].value),
            ks.text(way.estimates["ks"].noise),
            auc.text(way.estimates["auc"].value),
            f"{way.states:,}",
        ]
        for way in found.ways
    ]


def ratio_lines(found: SpinningImpacts) -> list[str]:
    """Costs of a draw with spin over others."""
    return [f"{name}: {ratio:.2f}" for name, ratio in found.ratios().items()]


def spinning_lines(found: SpinningImpacts | None) -> list[str]:
    """Particles that arrive spinning, for a terminal."""
    title = "Particles that arrive spinning, at the impacts that occur in chains"
    if found is None:
        return ["", f"{title}: none, since chains leave the table's range"]
    return ["", title, *table_lines(SPINNING_HEAD, spinning_rows(found)), *ratio_lines(found)]


def machine_text(evidence: ErrorAgainstTime) -> str:
    """Say what the timings were measured on."""
    about = evidence.machine
    return (
        f"{about['processor']}, {about['cores']} cores, {about['system']}, Python {about['python']}"
    )


def error_against_time_text(evidence: ErrorAgainstTime) -> str:
    """Report of a run for a terminal."""
    effort = evidence.effort
    lines = [
        f"{evidence.table}: {size_text(evidence.table_bytes)}, "
        f"{evidence.random_nanoseconds:.0f} ns a draw at random conditions",
        machine_text(evidence),
        f"{effort.batches} batches of {effort.batch:,} states against {effort.reference:,} direct "
        f"ones, seed {evidence.seed}",
    ]
    for race in evidence.races:
        lines += ["", f"At {race.alpha_deg:g} degrees, {race.speed:g} m/s"]
        lines += table_lines(HEAD, benchmark_rows(race))
    designs = evidence.designs
    lines += [
        "",
        f"Tables of other sizes at {designs.alpha_deg:g} degrees, {designs.speed:g} m/s",
        *table_lines(HEAD, benchmark_rows(designs)),
        "",
        "Numerics of direct simulation, on the same particles",
        *table_lines(SETTING_HEAD, setting_rows(evidence)),
        *spinning_lines(evidence.spinning),
        "",
        *evidence.left_out,
        f"Measured in {evidence.seconds:.0f} s.",
    ]
    return "\n".join(lines)
