"""A report as one HTML page that needs no network.

Plots are drawn in the browser by plotly.js, which travels in the page. Everything that they show
is in tables too, and every control is a native one.
"""

import json
from html import escape
from importlib import resources
from typing import Any

from sampler.errors import InputError
from sampler.formats.channels import STATE
from tablegen.studies.paper_figures.all_figures import COLLISION_HEAD, collision_rows
from tablegen.studies.paper_figures.sample_statistics import SPEED
from tablegen.studies.paper_figures.statement_text import STATEMENT_HEAD, statement_rows
from tablegen.studies.paper_figures.statement_text import counts_text as counts_text_of
from tablegen.studies.report.cost_sections import (
    designs_section,
    numerics_section,
    sizes_section,
    ways_section,
)
from tablegen.studies.report.labels import LABELS, SHORT
from tablegen.studies.report.method_styles import LOOKS
from tablegen.studies.report.report_data import ReportData
from tablegen.studies.report.report_html import folded, packed, picture, section, table
from tablegen.studies.report.table_sections import (
    accuracy_section,
    declared,
    footer_text,
    identity_section,
    summary_section,
    views_section,
)
from tablegen.studies.stability.stability_summary import HEAD, LEGEND, extremes, group_rows
from tablegen.studies.stability.stability_text import counts_text, failure_lines

_LINKS = {
    "summary": "Summary",
    "identity": "Identity",
    "accuracy": "Accuracy",
    "joint": "Joint law",
    "ways": "Error against run time",
    "designs": "Sizes of tables",
    "sizes": "Sample size",
    "numerics": "Numerics",
    "stability": "Stability",
    "paper": "The paper",
}


def plotting_library() -> str:
    """Source of plotly.js.

    Raises
    ------
    InputError
        If plotly is not installed.
    """
    try:
        from plotly.offline import get_plotlyjs
    except ImportError as error:
        raise InputError(
            "--html: needs plotly, which is not installed, allowed: "
            "pip install 'rebound-tables[report]', or no --html"
        ) from error
    return str(get_plotlyjs())


def _asset(name: str) -> str:
    return (
        resources.files("tablegen.studies.report")
        .joinpath("assets", name)
        .read_text(encoding="utf-8")
    )


def plot_data(dossier: ReportData) -> dict[str, Any]:
    """Everything that the page's script draws, JSON-ready."""
    evidence = dossier.evidence.to_dict()
    stored = {name: values.tolist() for name, values in dossier.stored.items()}
    stored["ks"] = [max(row) for row in stored["ks"]]
    return {
        "components": list(STATE),
        "labels": LABELS,
        "plain": {name: name.replace("_", " ") for name in STATE},
        "short": SHORT,
        "declared": declared(dossier),
        "stored": stored,
        "families": {
            family: {"light": look.light, "dark": look.dark, "symbol": look.symbol}
            for family, look in LOOKS.items()
        },
        "atlas": dossier.atlas.to_dict(),
        "views": [view.to_dict() for view in dossier.views],
        **{name: evidence[name] for name in ("races", "designs", "sizes")},
        "settings": [
            {**setting, "is_default": point.is_default}
            for setting, point in zip(evidence["settings"], dossier.evidence.settings, strict=True)
        ],
    }


def stability_section(dossier: ReportData) -> str:
    """Show the stability study of the direct model."""
    study = dossier.stability
    lines = failure_lines(study)
    verdict = (
        '<p class="good">The model holds in every case.</p>'
        if study.holds
        else '<p class="bad">The model fails in some cases:</p><ul>'
        + "".join(f"<li>{escape(line)}</li>" for line in lines)
        + "</ul>"
    )
    worst = [
        [e.quantity, f"{e.value:.4g}", str(e.outcome.case), str(e.outcome.seed)]
        for e in extremes(study.outcomes)
    ]
    return section(
        "stability",
        "Stability of the direct model",
        f"{verdict}<p>{escape(counts_text(study.outcomes))}.</p>"
        f"<p>Contact resolution {study.contact_resolution:g}, flight tolerance "
        f"{study.tolerance:g}, {study.count} particles a case, seed {study.seed}.</p>"
        + table("Cases by group", HEAD, group_rows(study.outcomes))
        + f"<p>{escape(' '.join(LEGEND))}</p>"
        + table(
            "Worst case of each quantity", ["quantity", "value", "case", "seed"], worst, "words"
        ),
    )


def paper_section(dossier: ReportData) -> str:
    """Show the figures and the statements of the paper."""
    gallery = dossier.gallery
    if gallery is None:
        note = "Left out: matplotlib is not installed (pip install 'rebound-tables[plot]')."
        return section("paper", "The paper", f"<p>{escape(note)}</p>")
    lead = (
        f"Figures and statements of Panfilov & Tsirkunov (2022) at {SPEED:g} m/s, from "
        f"{gallery.count:,} particles of each shape at each angle, and from the table, which holds "
        "the mixture. Paper and model are not tuned to each other; what does not hold is listed "
        "as well."
    )
    pictures = "".join(
        picture(p.data, p.media_type, p.alternative, p.title) for p in gallery.pictures
    )
    return section(
        "paper",
        "The paper: statements and figures",
        f"<p>{escape(lead)}</p><p><strong>{escape(counts_text_of(gallery.statements))}</strong></p>"
        + folded(
            "Every statement",
            table(
                "Statements of the paper, what was asked for, and what was measured",
                STATEMENT_HEAD,
                statement_rows(gallery.statements),
                "words statements",
            ),
        )
        + table(
            "Collisions in a rebound at normal impact, in per cent of the particles",
            COLLISION_HEAD,
            collision_rows(gallery.laws),
        )
        + "<h3>Figures</h3>"
        + pictures,
    )


def report_page(dossier: ReportData) -> str:
    """Self-contained HTML of a report.

    Parameters
    ----------
    dossier : ReportData

    Returns
    -------
    str

    Raises
    ------
    InputError
        If plotly is not installed.
    """
    library = plotting_library()
    title = f"Rebound table {dossier.evidence.table}"
    sections = (
        summary_section,
        identity_section,
        accuracy_section,
        views_section,
        ways_section,
        designs_section,
        sizes_section,
        numerics_section,
        stability_section,
        paper_section,
    )
    links = "".join(f'<li><a href="#{name}">{words}</a></li>' for name, words in _LINKS.items())
    lead = f"{dossier.config.pair.particle} on {dossier.config.pair.wall}: what the table is worth."
    data = json.dumps(plot_data(dossier), separators=(",", ":"), allow_nan=False)
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{escape(title)}</title><style>{_asset('page.css')}</style></head><body>"
        '<a class="skip" href="#summary">Skip to the summary</a>'
        f'<header><h1>{escape(title)}</h1><p class="lead">{escape(lead)}</p>'
        f'<nav aria-label="Sections"><ul>{links}</ul></nav></header>'
        f"<main>{''.join(make(dossier) for make in sections)}</main>"
        f"<footer><p>{escape(footer_text(dossier))}</p></footer>"
        f"{packed('data', data)}{packed('library', library)}"
        f"<script>{_asset('page.js')}</script></body></html>\n"
    )
