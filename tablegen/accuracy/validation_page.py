"""A validation as one HTML page, which needs no network and runs nothing."""

from collections.abc import Iterable
from html import escape

from tablegen.accuracy.accuracy_text import (
    detail_tables,
    numbers_table,
    validation_notes,
    verdict_lines,
)
from tablegen.accuracy.validate import Validation
from tablegen.presentation import TextTable

_STYLE = """
:root { color-scheme: light dark; }
body { margin: 0 auto; max-width: 68rem; padding: 1rem; font: 1rem/1.5 system-ui, sans-serif; }
div { overflow-x: auto; }
table { border-collapse: collapse; margin: 0.5rem 0 1.5rem; font-size: 0.875rem; }
caption { text-align: left; }
th, td { padding: 0.3rem 0.55rem; text-align: right; white-space: nowrap; }
tr { border-bottom: 1px solid; }
th:first-child { text-align: left; font-weight: 400; }
"""


def validation_page(validation: Validation) -> str:
    """Render a validation as an HTML page; texts are escaped."""
    title = f"Validation of {validation.table}"
    verdict, *advice = verdict_lines(validation)
    notes = [*validation_notes(validation), f"Content SHA-256: {validation.content_sha256}"]
    body = [
        f"<h1>{escape(title)}</h1>",
        f"<p><strong>{escape(verdict)}</strong></p>",
        *_paragraphs(advice),
        _table(numbers_table(validation.numbers, validation.stored)),
        *_paragraphs(notes),
        "<h2>Conditions</h2>",
        *map(_table, detail_tables(validation)),
    ]
    head = (
        '<meta charset="utf-8"><meta name="viewport" content="width=device-width">'
        f"<title>{escape(title)}</title><style>{_STYLE}</style>"
    )
    lines = "\n".join(body)
    return f'<!doctype html>\n<html lang="en"><head>{head}</head><body>\n{lines}\n</body></html>\n'


def _paragraphs(lines: Iterable[str]) -> list[str]:
    return [f"<p>{escape(line)}</p>" for line in lines]


def _table(table: TextTable) -> str:
    """Write a table; the first cell of a row is its head."""
    head = "".join(f'<th scope="col">{escape(cell)}</th>' for cell in table.head)
    rows = "\n".join(
        f'<tr><th scope="row">{escape(first)}</th>'
        + "".join(f"<td>{escape(cell)}</td>" for cell in cells)
        + "</tr>"
        for first, *cells in table.rows
    )
    caption = escape(table.caption)
    return f"<div><table><caption>{caption}</caption><tr>{head}</tr>\n{rows}\n</table></div>"
