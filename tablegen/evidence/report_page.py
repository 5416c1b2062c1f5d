"""A report as one HTML page that needs no network.

Plotly draws in the browser; its library travels in the page. Everything that the plots show is in
tables too.
"""

import base64
import gzip
import importlib.util
from urllib.parse import quote

from markupsafe import Markup

from sampler.errors import InputError
from tablegen.evidence import report_tables, report_text, statement_text
from tablegen.evidence.rendering import render_page
from tablegen.evidence.report_data import ReportData
from tablegen.evidence.sample_statistics import SPEED
from tablegen.evidence.stability_page import stability_values
from tablegen.evidence.tolerances import FINEST
from tablegen.presentation import Picture

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


def _plots(report: ReportData) -> dict[str, Markup]:
    """Every plot as HTML; those of views and of methods are numbered."""
    from tablegen.evidence import cost_plots, table_plots
    from tablegen.evidence.plot_style import plot_html

    evidence, allowed = report.evidence, report_tables.declared(report)
    figures = {
        "map": table_plots.accuracy_map(report.atlas, report.stored, allowed),
        "table-sizes": cost_plots.table_sizes_plot(evidence.designs),
        "sample-sizes": cost_plots.sample_sizes_plot(evidence.sizes),
        "numerics": cost_plots.numerics_plot(evidence.settings),
    }
    for k, view in enumerate(report.views):
        figures[f"marginals-{k}"] = table_plots.marginals(view)
        figures[f"pairs-{k}"] = table_plots.joint_densities(view)
    for k, race in enumerate(evidence.races):
        figures[f"methods-{k}"] = cost_plots.methods_plot(race)
    return {name: plot_html(figure, name) for name, figure in figures.items()}


def data_address(picture: Picture) -> str:
    """Address that holds a picture; SVG as text, which takes a quarter less than base 64."""
    if picture.name.endswith(".svg"):
        text = picture.data.decode("utf-8").replace("\n", " ")
        return f"data:{picture.media_type},{quote(text, safe=_PLAIN)}"
    return f"data:{picture.media_type};base64,{base64.b64encode(picture.data).decode('ascii')}"


def report_page(report: ReportData) -> str:
    """Self-contained HTML of a report.

    Raises
    ------
    InputError
        If plotly is not installed.
    """
    require_plotly()
    evidence = report.evidence
    return render_page(
        "report",
        title=f"Rebound table {evidence.table}",
        report=report,
        evidence=evidence,
        effort=evidence.effort,
        tables=report_tables,
        text=report_text,
        finest=FINEST,
        stability=stability_values(report.stability),
        gallery=report.gallery,
        speed=SPEED,
        statements=statement_text,
        data_address=data_address,
        plots=_plots(report),
        library=_packed_library(),
    )
