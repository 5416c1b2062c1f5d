"""Results as text for a terminal."""

from collections.abc import Mapping, Sequence

from tablegen.accuracy import Comparison
from tablegen.config import AccuracyTargets

_METRICS = ("alpha", "V", "KS", "sliced W", "corr.", "AUC")


def _metric_row(comparison: Comparison) -> str:
    c = comparison
    return (
        f"{c.alpha_deg:8.2f} {c.speed:8.1f} {max(c.ks):9.4f} {c.sliced_wasserstein:9.4f} "
        f"{c.correlation_error:9.4f} {c.auc:9.3f}"
    )


def accuracy_text(comparisons: Sequence[Comparison], declared: AccuracyTargets) -> str:
    """One line a condition with the four distances, then the worst and the declared ones."""
    head = "{:>8} {:>8} {:>9} {:>9} {:>9} {:>9}".format(*_METRICS)
    worst = (
        max(max(c.ks) for c in comparisons),
        max(c.sliced_wasserstein for c in comparisons),
        max(c.correlation_error for c in comparisons),
        max(c.auc for c in comparisons),
    )
    limits = (declared.ks, declared.sliced_wasserstein, declared.correlation_error, declared.auc)
    return "\n".join(
        [
            head,
            *(_metric_row(c) for c in comparisons),
            "{:<17} {:9.4f} {:9.4f} {:9.4f} {:9.3f}".format("worst", *worst),
            "{:<17} {:9.4f} {:9.4f} {:9.4f} {:9.3f}".format("declared", *limits),
        ]
    )


def details_text(comparison: Comparison) -> str:
    """Means, modes, energy and scattering angles at one condition, table beside direct."""
    c = comparison
    lines = [
        f"at {c.alpha_deg:.2f} degrees, {c.speed:.1f} m/s      mean                most probable",
        "                   table    direct      table    direct        KS",
    ]
    for k, name in enumerate(c.components):
        lines.append(
            f"  {name:<12} {c.table.mean[k]:9.4f} {c.direct.mean[k]:9.4f}  "
            f"{c.table.mode[k]:9.4f} {c.direct.mode[k]:9.4f} {c.ks[k]:9.4f}"
        )
    lines.append(
        f"  {'energy':<12} {c.table.translational_energy:9.4f} "
        f"{c.direct.translational_energy:9.4f}   translational, over the energy before"
    )
    for k, name in enumerate(("alpha2", "beta2")):
        lines.append(
            f"  {name:<12} {c.table.scattering_mean_deg[k]:9.2f} "
            f"{c.direct.scattering_mean_deg[k]:9.2f}   degrees; standard deviation "
            f"{c.table.scattering_standard_deviation_deg[k]:.2f} and "
            f"{c.direct.scattering_standard_deviation_deg[k]:.2f}"
        )
    return "\n".join(lines)


def time_text(seconds: Mapping[str, float]) -> str:
    """Say how the time of a generation splits between its stages, all workers together."""
    total = sum(seconds.values())
    parts = (f"{stage} {spent:.0f} s" for stage, spent in seconds.items())
    return f"{total:.0f} worker seconds: " + ", ".join(parts)
