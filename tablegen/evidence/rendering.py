"""HTML pages from the templates next to this file. A page needs no network."""

from functools import cache
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined


@cache
def _environment() -> Environment:
    return Environment(
        loader=PackageLoader("tablegen.evidence"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def render_page(template: str, **values: Any) -> str:
    """Fill in a template.

    Parameters
    ----------
    template : str
        Name of the template without its endings.
    **values
        What the template shows; texts are escaped, those of type `markupsafe.Markup` are not.

    Returns
    -------
    str
        Whole page.
    """
    return _environment().get_template(f"{template}.html.j2").render(**values) + "\n"
