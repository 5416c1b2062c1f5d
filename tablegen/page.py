"""A validation as one HTML page that needs no network."""

from html import escape

from sampler.channels import COMPONENTS
from tablegen.accuracy import Comparison
from tablegen.validate import Validation

_STYLE = """
:root { color-scheme: light dark; }
body { font: 1rem/1.5 system-ui, sans-serif; margin: 2rem auto; max-width: 60rem; padding: 0 1rem; }
table { border-collapse: collapse; margin: 1rem 0; display: block; overflow-x: auto; }
th, td { padding: 0.25rem 0.75rem; text-align: right; border-bottom: 1px solid #8886; }
th:first-child, td:first-child { text-align: left; }
.missed { font-weight: bold; }
"""


def _table(head: list[str], rows: list[list[str]]) -> str:
    heads = "".join(f'<th scope="col">{escape(cell)}</th>' for cell in head)
    body = "".join(
        "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows
    )
    return f"<table><thead><tr>{heads}</tr></thead><tbody>{body}</tbody></table>"


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
    return _table(head, [*rows, ["declared", "", *(f"{x:g}" for x in limits)]])


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
        for k, name in enumerate(COMPONENTS)
    ]
    energies = (c.table.translational_energy, c.direct.translational_energy)
    rows.append(["translational energy", *(f"{x:.4f}" for x in energies), "", "", ""])
    for k, name in enumerate(("alpha2", "beta2")):
        angles = (c.table.scattering_mean_deg[k], c.direct.scattering_mean_deg[k])
        rows.append([f"{name} [degrees]", *(f"{x:.2f}" for x in angles), "", "", ""])
    title = f"{c.alpha_deg:.2f}°, {c.speed:.1f} m/s"
    return f"<details><summary>{title}</summary>{_table(head, rows)}</details>"


def validation_page(validation: Validation) -> str:
    """Self-contained HTML of a validation.

    Parameters
    ----------
    validation : Validation

    Returns
    -------
    str
    """
    if validation.holds:
        verdict = "<p>The declared accuracy holds at every condition.</p>"
    else:
        items = "".join(f"<li>{escape(line)}</li>" for line in validation.missed)
        verdict = f'<p class="missed">The declared accuracy is missed:</p><ul>{items}</ul>'
    title = f"Validation of {escape(validation.table)}"
    details = "".join(_details(c) for c in validation.comparisons)
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{title}</title><style>{_STYLE}</style></head><body><main><h1>{title}</h1>"
        f"{verdict}<p>Seed {validation.seed}; content SHA-256 "
        f"<code>{validation.content_sha256}</code></p><h2>Distances to direct simulation</h2>"
        f"{_distances(validation)}<h2>Means and most probable values</h2>{details}"
        "</main></body></html>\n"
    )
