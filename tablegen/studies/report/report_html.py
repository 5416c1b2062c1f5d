"""Pieces of a report's HTML: tables that scroll, native controls, plots, pictures."""

import base64
import gzip
from collections.abc import Mapping, Sequence
from html import escape
from typing import NamedTuple


class Choice(NamedTuple):
    """A native control that chooses among values."""

    identity: str
    label: str
    #: From value to words.
    values: Mapping[str, str]
    #: The value to begin with; the first if None.
    first: str | None = None


def table(caption: str, head: Sequence[str], rows: Sequence[Sequence[str]], style: str = "") -> str:
    """Table of plain texts with a caption, in a box that scrolls by keyboard too."""
    heads = "".join(f'<th scope="col">{escape(cell)}</th>' for cell in head)
    body = "".join(
        f'<tr><th scope="row">{escape(row[0])}</th>'
        + "".join(f"<td>{escape(cell)}</td>" for cell in row[1:])
        + "</tr>"
        for row in rows
    )
    kind = f' class="{style}"' if style else ""
    return (
        f'<div class="scroll" role="region" tabindex="0" aria-label="{escape(caption)}">'
        f"<table{kind}><caption>{escape(caption)}</caption><thead><tr>{heads}</tr></thead>"
        f"<tbody>{body}</tbody></table></div>"
    )


def folded(summary: str, body: str) -> str:
    """Body that shows on demand."""
    return f"<details><summary>{escape(summary)}</summary>{body}</details>"


def controls(legend: str, choices: Sequence[Choice]) -> str:
    """Row of native selects."""
    return f"<fieldset><legend>{escape(legend)}</legend>{''.join(map(_select, choices))}</fieldset>"


def _select(choice: Choice) -> str:
    first = choice.first if choice.first is not None else next(iter(choice.values))
    options = "".join(
        f'<option value="{escape(value)}"{" selected" if value == first else ""}>'
        f"{escape(words)}</option>"
        for value, words in choice.values.items()
    )
    # browsers may restore an earlier choice, which the plots would not know of
    return (
        f'<label for="{choice.identity}">{escape(choice.label)}'
        f'<select id="{choice.identity}" autocomplete="off">{options}</select></label>'
    )


def plot(identity: str, caption: str, style: str = "plot") -> str:
    """Place of a plot that the page's script draws; it names the plot as it draws it."""
    return (
        f'<figure><div id="{identity}" class="{style}" role="img" aria-label="{escape(caption)}">'
        f'<p class="waiting">The plot needs JavaScript.</p></div>'
        f"<figcaption>{escape(caption)}</figcaption></figure>"
    )


def picture(data: bytes, media_type: str, alternative: str, caption: str) -> str:
    """Picture with the page around it."""
    text = base64.b64encode(data).decode("ascii")
    return (
        f'<figure><img class="picture" src="data:{media_type};base64,{text}" '
        f'alt="{escape(alternative)}"><figcaption>{escape(caption)}</figcaption></figure>'
    )


def packed(identity: str, text: str) -> str:
    """Text that the page's script unpacks: compressed, as base 64."""
    # no time stamp, so that the same text gives the same page
    data = gzip.compress(text.encode("utf-8"), mtime=0)
    return (
        f'<script type="application/octet-stream" id="{identity}">'
        f"{base64.b64encode(data).decode('ascii')}</script>"
    )


def tiles(items: Sequence[tuple[str, str, str]]) -> str:
    """Figures that matter most: (name, figure, remark)."""
    cells = "".join(
        f"<div><dt>{escape(name)}</dt><dd>{escape(figure)}"
        + (f"<small>{escape(remark)}</small>" if remark else "")
        + "</dd></div>"
        for name, figure, remark in items
    )
    return f'<dl class="tiles">{cells}</dl>'


def section(identity: str, title: str, body: str) -> str:
    """Part of the page with a heading that links can reach."""
    return (
        f'<section aria-labelledby="{identity}"><h2 id="{identity}">{escape(title)}</h2>'
        f"{body}</section>"
    )
