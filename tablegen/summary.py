"""Results as text for a terminal."""

from collections.abc import Mapping, Sequence
from typing import Any

from sampler.table import Table
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


def identity(table: Table) -> dict[str, Any]:
    """Say what a table is: provenance, nodes, size in memory, measured accuracy.

    Parameters
    ----------
    table : Table

    Returns
    -------
    dict
        Numbers, texts and lists, for JSON. Angles in degrees, speeds in m/s, sizes in bytes.
        ``worst`` has the largest of each error in ``accuracy``, or None if nothing was measured.
    """
    contents, accuracy = table.contents, table.accuracy
    errors = ("ks", "sliced_wasserstein", "correlation_error", "auc")
    measured = accuracy["auc"].size > 0
    return {
        "pair": table.pair,
        "components": list(table.components),
        "alpha_deg": contents["axes/alpha_deg"].tolist(),
        "speed": contents["axes/speed"].tolist(),
        "mixture_components": table.arrays.n_components,
        "quantile_knots": table.arrays.n_knots,
        "seed": contents.seed,
        "software_version": contents.software_version,
        "content_sha256": contents.content_sha256,
        "processors": list(contents.processors),
        "bytes_in_memory": table.nbytes,
        "worst": {name: float(accuracy[name].max()) for name in errors} if measured else None,
        "accuracy": {name: values.tolist() for name, values in accuracy.items()},
    }


def several_processors(table: Table) -> str:
    """Say that processors of several kinds made a table, and what follows from it."""
    count = len(table.contents.processors)
    return f"made on processors of {count} kinds: made again, last digits may differ"


def _processor_lines(table: Table) -> list[str]:
    """Kinds of processor that made a table, for people."""
    kinds = table.contents.processors or ("not recorded",)
    if len(kinds) == 1:
        return [f"made on           {kinds[0]}"]
    return [several_processors(table), *(f"made on           {kind}" for kind in kinds)]


def identity_text(table: Table) -> str:
    """Say what a table is, as `identity` does, for people."""
    facts = identity(table)
    alpha, speed, worst = facts["alpha_deg"], facts["speed"], facts["worst"]
    measured = "nothing"
    if worst is not None:
        measured = (
            f"at {len(facts['accuracy']['auc'])} conditions between nodes, worst: "
            f"KS {worst['ks']:.4f}, sliced Wasserstein {worst['sliced_wasserstein']:.4f}, "
            f"correlation {worst['correlation_error']:.4f}, AUC {worst['auc']:.3f}"
        )
    return "\n".join(
        [
            f"pair              {facts['pair']}",
            f"impact angle      {alpha[0]:g} to {alpha[-1]:g} degrees, {len(alpha)} nodes",
            f"speed             {speed[0]:g} to {speed[-1]:g} m/s, {len(speed)} nodes",
            f"a draw gives      {', '.join(facts['components'])}",
            f"mixture           {facts['mixture_components']} components a node",
            f"quantile knots    {facts['quantile_knots']}",
            f"seed              {facts['seed']}",
            f"software          rebound-tables {facts['software_version']}",
            f"content SHA-256   {facts['content_sha256']}",
            *_processor_lines(table),
            f"in memory         {facts['bytes_in_memory'] / 1e6:.2f} MB",
            f"measured          {measured}",
        ]
    )
