"""A validation as one HTML page that needs no network."""

from collections.abc import Sequence
from html import escape

from tablegen.accuracy.comparison import Comparison
from tablegen.accuracy.verdict import verdict_words
from tablegen.studies.html_page import html_page, html_table, verdict
from tablegen.studies.validation.accuracy_text import (
    HEAD,
    closing_cells,
    closing_rows,
    metric_row,
)
from tablegen.studies.validation.validation_text import certainty_line, coverage_lines, whose
from tablegen.validate import Validation


def _distances(comparisons: Sequence[Comparison], validation: Validation) -> str:
    head = ["impact angle [degrees]", "speed [m/s]", *HEAD[2:]]
    rows = [metric_row(c) for c in comparisons]
    accuracies = validation.declared, validation.asked
    for name, values in closing_rows(comparisons, *accuracies, len(validation.measured)):
        rows.append([name, *closing_cells(values)[1:]])
    return html_table(head, rows)


def _details(c: Comparison) -> str:
    head = ["", "mean, table", "direct", "most probable, table", "direct", "KS"]
    rows = [
        [
            name,
            f"{c.table.mean[k]:.4f}",
            f"{c.direct.mean[k]:.4f}",
            f"{c.table.mode[k]:.4f}",
            f"{c.direct.mode[k]:.4f}",
            f"{c.estimates['ks'].by_variable[k]:.4f}",
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
    words = verdict_words(validation.missed, validation.undecided, whose(validation))
    holds = verdict(words, words, [*validation.missed, *validation.undecided])
    told = [*coverage_lines(validation), certainty_line()]
    nodes = ""
    if validation.nodes:
        nodes = f"<h2>At the nodes that looked worst</h2>{_distances(validation.nodes, validation)}"
    return html_page(
        f"Validation of {validation.table}",
        f"{holds}{''.join(f'<p>{escape(line)}</p>' for line in told)}<p>Content SHA-256 "
        f"<code>{validation.content_sha256}</code></p><h2>Distances to direct simulation</h2>"
        f"{_distances(validation.comparisons, validation)}{nodes}"
        f"<h2>Means and most probable values</h2>{details}",
    )
