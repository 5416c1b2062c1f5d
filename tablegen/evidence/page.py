"""Pages and texts: sections of paragraphs, verdicts, tables and pictures, as HTML or text.

A page is one file that needs no network and runs nothing.
"""

import base64
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from urllib.parse import quote

from jinja2 import Environment, PackageLoader, StrictUndefined

from tablegen.accuracy import accuracy_text, spin_text
from tablegen.accuracy.validate import Validation
from tablegen.accuracy.validation_text import certainty_line, coverage_lines, whose
from tablegen.accuracy.verdict import verdict_words
from tablegen.presentation import Picture, table_lines


@dataclass(frozen=True)
class Headline:
    """A sentence that is "good", "bad" or "open" news, with further lines."""

    kind: str
    words: str
    lines: Sequence[str] = ()


@dataclass(frozen=True)
class DataTable:
    """A table; its style is "words" if the cells are sentences."""

    caption: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    style: str = ""


@dataclass(frozen=True)
class Section:
    """A part of a page with a heading; a folded part is opened by a click."""

    heading: str
    blocks: Sequence["Block"]
    folded: bool = False


Block = str | Headline | DataTable | Picture | Section


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
        elif isinstance(block, DataTable):
            yield from ("", block.caption, *table_lines(block.head, block.rows))
        elif isinstance(block, Section):
            yield from ("", block.heading, *_lines(block))


def validation_page(validation: Validation) -> str:
    """Render a validation as an HTML page."""
    missed, undecided, spin = validation.missed, validation.undecided, validation.spin
    judged = (validation.declared, validation.asked, validation.together)
    kind = "bad" if missed else "open" if undecided else "good"
    blocks: list[Block] = [
        Headline(kind, verdict_words(missed, undecided, whose(validation)), [*missed, *undecided]),
        *coverage_lines(validation),
        certainty_line(),
        Headline("soft", "Content SHA-256", [validation.content_sha256]),
    ]
    for caption, found in (
        ("Distances to direct simulation", validation.comparisons),
        ("At the nodes that looked worst", validation.nodes),
    ):
        if found:
            rows = accuracy_text.accuracy_rows(found, *judged)
            blocks.append(DataTable(caption, accuracy_text.HEAD, rows))
    sections, every = [Section("Accuracy", blocks)], list(validation.comparisons)
    if spin:
        declared, asked, measured = spin.declared, spin.asked, spin.measured
        every += measured.comparisons
        rows = accuracy_text.accuracy_rows(measured.comparisons, declared, asked, judged[2])
        blocks = [DataTable("At spinning conditions", accuracy_text.HEAD, rows)]
        if measured.joint:
            limits = declared.joint, asked.joint if asked else None, judged[2]
            rows = spin_text.joint_rows(measured.joint, *limits)
            blocks.append(DataTable("Over the impacts of chains", spin_text.JOINT_HEAD, rows))
        sections.append(Section("The spin law", blocks))
    details = []
    for c in every:
        table = DataTable(
            "Table and direct", accuracy_text.DETAIL_HEAD, accuracy_text.detail_rows(c)
        )
        details.append(Section(accuracy_text.condition_text(c), [table], folded=True))
    sections.append(Section("Means and most probable values", details))
    return render_page(f"Validation of {validation.table}", sections)
