"""HTML pages that need no network: the frame of a page, and tables."""

from collections.abc import Sequence
from html import escape

_STYLE = """
:root { color-scheme: light dark; }
body { font: 1rem/1.5 system-ui, sans-serif; margin: 2rem auto; max-width: 60rem; padding: 0 1rem; }
table { border-collapse: collapse; margin: 1rem 0; display: block; overflow-x: auto; }
th, td { padding: 0.25rem 0.75rem; text-align: right; border-bottom: 1px solid #8886; }
th:first-child, td:first-child { text-align: left; }
.missed { font-weight: bold; }
"""


def html_table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Table of plain texts, which are escaped."""
    heads = "".join(f'<th scope="col">{escape(cell)}</th>' for cell in head)
    body = "".join(
        "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows
    )
    return f"<table><thead><tr>{heads}</tr></thead><tbody>{body}</tbody></table>"


def verdict(good: str, bad: str, lines: Sequence[str]) -> str:
    """Paragraph that says ``good``, or ``bad`` and why where there are lines; plain texts."""
    if not lines:
        return f"<p>{escape(good)}</p>"
    items = "".join(f"<li>{escape(line)}</li>" for line in lines)
    return f'<p class="missed">{escape(bad)}</p><ul>{items}</ul>'


def html_page(title: str, body: str) -> str:
    """Whole page with a plain title and a body of HTML."""
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{escape(title)}</title><style>{_STYLE}</style></head><body><main>"
        f"<h1>{escape(title)}</h1>{body}</main></body></html>\n"
    )
