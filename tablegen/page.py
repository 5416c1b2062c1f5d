"""A validation as one HTML page that needs no network."""

from tablegen.accuracy import Comparison
from tablegen.markup import html_page, html_table, verdict
from tablegen.validate import Validation


def _distances(validation: Validation) -> str:
    head = ["impact angle", "speed", "KS", "sliced Wasserstein", "correlation", "AUC"]
    rows = [
        [
            f"{c.alpha_deg:.2f}°",
            f"{c.speed:.1f} m/s",
            f"{max(c.ks):.4f}",
            f"{c.sliced_wasserstein:.4f}",
            f"{c.correlation_error:.4f}",
            f"{c.auc:.3f}",
        ]
        for c in validation.comparisons
    ]
    d = validation.declared
    limits = [d.ks, d.sliced_wasserstein, d.correlation_error, d.auc]
    return html_table(head, [*rows, ["declared", "", *(f"{x:g}" for x in limits)]])


def _details(c: Comparison) -> str:
    head = ["", "mean, table", "direct", "most probable, table", "direct", "KS"]
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
    rows.append(["translational energy", *(f"{x:.4f}" for x in energies), "", "", ""])
    for k, name in enumerate(("alpha2", "beta2")):
        angles = (c.table.scattering_mean_deg[k], c.direct.scattering_mean_deg[k])
        rows.append([f"{name} [degrees]", *(f"{x:.2f}" for x in angles), "", "", ""])
    title = f"{c.alpha_deg:.2f}°, {c.speed:.1f} m/s"
    return f"<details><summary>{title}</summary>{html_table(head, rows)}</details>"


def validation_page(validation: Validation) -> str:
    """Self-contained HTML of a validation.

    Parameters
    ----------
    validation : Validation

    Returns
    -------
    str
    """
    details = "".join(_details(c) for c in validation.comparisons)
    holds = verdict(
        "The declared accuracy holds at every condition.",
        "The declared accuracy is missed:",
        validation.missed,
    )
    return html_page(
        f"Validation of {validation.table}",
        f"{holds}<p>Seed {validation.seed}; content SHA-256 "
        f"<code>{validation.content_sha256}</code></p><h2>Distances to direct simulation</h2>"
        f"{_distances(validation)}<h2>Means and most probable values</h2>{details}",
    )
