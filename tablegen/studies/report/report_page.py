"""A report as one HTML page that needs no network.

Plotly draws in the browser; its library travels in the page. Everything that the plots show is in
tables too.
"""

import base64
import gzip
import importlib.util
from typing import Any
from urllib.parse import quote

from markupsafe import Markup

from sampler.errors import InputError
from tablegen.studies.pages.rendering import render_page
from tablegen.studies.paper_figures.all_figures import COLLISION_HEAD, PaperFigures, collision_rows
from tablegen.studies.paper_figures.sample_statistics import SPEED
from tablegen.studies.paper_figures.statement_text import (
    STATEMENT_HEAD,
    counts_text,
    failing_lines,
    statement_rows,
)
from tablegen.studies.paper_figures.style import Picture
from tablegen.studies.report import report_tables
from tablegen.studies.report.report_data import ReportData
from tablegen.studies.report.report_text import (
    HEAD,
    SETTING_HEAD,
    benchmark_rows,
    machine_text,
    setting_rows,
)
from tablegen.studies.report.tolerances import FINEST
from tablegen.studies.stability.stability_page import stability_values

#: Characters of a picture that stand in an address as they are.
_PLAIN = " ,;:=/'().-+*&?!"


def require_plotly() -> None:
    """Refuse to go on without plotly.

    Raises
    ------
    InputError
        If it is not installed.
    """
    if importlib.util.find_spec("plotly") is None:
        raise InputError(
            "--html: needs plotly, which is not installed, allowed: "
            "pip install 'rebound-tables[report]', or no --html"
        )


def _packed_library() -> str:
    """Source of plotly.js as base 64 of gzip: 2.0 MB in place of 4.8."""
    from plotly.offline import get_plotlyjs

    # no time stamp, so that the same report gives the same page
    return base64.b64encode(gzip.compress(get_plotlyjs().encode("utf-8"), mtime=0)).decode("ascii")


def _plots(dossier: ReportData) -> dict[str, Markup]:
    """Every plot as HTML; those of views and of methods are numbered."""
    from tablegen.studies.report import cost_plots, table_plots
    from tablegen.studies.report.plot_style import plot_html

    evidence, allowed = dossier.evidence, report_tables.declared(dossier)
    figures = {
        "map": table_plots.accuracy_map(dossier.atlas, dossier.stored, allowed),
        "table-sizes": cost_plots.table_sizes_plot(evidence.designs),
        "sample-sizes": cost_plots.sample_sizes_plot(evidence.sizes),
        "numerics": cost_plots.numerics_plot(evidence.settings),
    }
    for k, view in enumerate(dossier.views):
        figures[f"marginals-{k}"] = table_plots.marginals(view)
        figures[f"pairs-{k}"] = table_plots.joint_densities(view)
    for k, race in enumerate(evidence.races):
        figures[f"methods-{k}"] = cost_plots.methods_plot(race)
    return {name: plot_html(figure, name) for name, figure in figures.items()}


def _data_address(picture: Picture) -> str:
    """Address that holds a picture; SVG as text, which takes a quarter less than base 64."""
    if picture.name.endswith(".svg"):
        text = picture.data.decode("utf-8").replace("\n", " ")
        return f"data:{picture.media_type},{quote(text, safe=_PLAIN)}"
    return f"data:{picture.media_type};base64,{base64.b64encode(picture.data).decode('ascii')}"


def _paper(gallery: PaperFigures) -> dict[str, Any]:
    """Statements, collisions and figures of the paper."""
    return {
        "speed": SPEED,
        "count": gallery.count,
        "counts": counts_text(gallery.statements),
        "failing": failing_lines(gallery.statements),
        "statement_head": STATEMENT_HEAD,
        "statements": statement_rows(gallery.statements),
        "collision_head": COLLISION_HEAD,
        "collisions": collision_rows(gallery.statistics),
        "pictures": [(p.title, p.alternative, _data_address(p)) for p in gallery.pictures],
    }


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
    require_plotly()
    evidence = dossier.evidence
    races = (*evidence.races, evidence.designs)
    return render_page(
        "report",
        title=f"Rebound table {evidence.table}",
        dossier=dossier,
        evidence=evidence,
        effort=evidence.effort,
        rows=report_tables,
        machine=machine_text(evidence),
        method_head=HEAD,
        method_rows=[benchmark_rows(race) for race in races],
        places=[f"{race.alpha_deg:g}°, {race.speed:g} m/s" for race in races],
        views=[f"{view.alpha_deg:g}°, {view.speed:g} m/s" for view in dossier.views],
        setting_head=SETTING_HEAD,
        setting_rows=setting_rows(evidence),
        finest=FINEST,
        stability=stability_values(dossier.stability),
        paper=None if dossier.gallery is None else _paper(dossier.gallery),
        plots=_plots(dossier),
        library=_packed_library(),
    )
