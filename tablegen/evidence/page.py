"""Pages and texts: sections of paragraphs, verdicts, tables and pictures, as HTML or text.

A page is one file that needs no network and runs nothing.
"""

import base64
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from urllib.parse import quote

from jinja2 import Environment, PackageLoader, StrictUndefined

from tablegen.accuracy.accuracy_text import (
    detail_tables,
    numbers_table,
    validation_notes,
    verdict_lines,
)
from tablegen.accuracy.validate import Validation
from tablegen.presentation import Picture, TextTable


@dataclass(frozen=True)
class Headline:
    """A sentence that is "good" or "bad" news, with further lines."""

    kind: str
    words: str
    lines: Sequence[str] = ()


@dataclass(frozen=True)
class Section:
    """A part of a page with a heading; a folded part is opened by a click."""

    heading: str
    blocks: Sequence["Block"]
    folded: bool = False


Block = str | Headline | TextTable | Picture | Section


def render_page(title: str, sections: Sequence[Section]) -> str:
    """Render sections as one HTML page; texts are escaped."""
    environment = Environment(
        loader=PackageLoader("tablegen.evidence"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    template = environment.get_template("page.html.j2")
    return template.render(title=title, sections=sections, address=_address).lstrip() + "\n"


def _address(picture: Picture) -> str:
    """Make the data address of a picture: SVG as text, which is shorter than base 64."""
    if picture.name.endswith(".svg"):
        text = picture.data.decode("utf-8").replace("\n", " ")
        return "data:image/svg+xml," + quote(text, safe=" ,;:=/'().-+*&?!")
    return f"data:{picture.media_type};base64,{base64.b64encode(picture.data).decode('ascii')}"


def render_text(sections: Sequence[Section]) -> str:
    """Render sections as text for a terminal, without the pictures."""
    parts = ("\n".join([section.heading, *_lines(section)]) for section in sections)
    return "\n\n".join(parts)


def _lines(section: Section) -> Iterator[str]:
    for block in section.blocks:
        if isinstance(block, str):
            yield block
        elif isinstance(block, Headline):
            yield from (block.words, *block.lines)
        elif isinstance(block, TextTable):
            yield from ("", str(block))
        elif isinstance(block, Section):
            yield from ("", block.heading, *_lines(block))


def validation_page(validation: Validation) -> str:
    """Render a validation as an HTML page."""
    words, *lines = verdict_lines(validation)
    blocks: list[Block] = [
        Headline("good" if validation.holds else "bad", words, lines),
        numbers_table(validation.numbers, validation.stored),
        *validation_notes(validation),
        Headline("soft", "Content SHA-256", [validation.content_sha256]),
    ]
    tables = detail_tables(validation)
    details = [Section(t.caption, [t._replace(caption="Table and direct")], True) for t in tables]
    sections = [Section("Accuracy", blocks), Section("Conditions", details)]
    return render_page(f"Validation of {validation.table}", sections)
