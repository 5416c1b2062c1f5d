"""Statements and table of the paper as text, Markdown and JSON."""

from collections.abc import Sequence

from sampler.files import json_text
from tablegen.evidence.all_figures import (
    COLLISION_HEAD,
    PaperFigures,
    collision_rows,
    to_dict,
)
from tablegen.evidence.checked_statement import Verdict
from tablegen.evidence.sample_statistics import SPEED
from tablegen.evidence.statements import NOT_CHECKED, Statement


def verdict_word(verdict: Verdict | None) -> str:
    """One or three words for a verdict."""
    if verdict is None:
        return "cannot tell"
    if verdict.holds is None:
        return "measured"
    return "holds" if verdict.holds else "does not hold"


def statement_rows(statements: Sequence[Statement]) -> list[list[str]]:
    """Cells: number and text, verdicts and figures of the direct model and the table."""
    rows = []
    for k, s in enumerate(statements, 1):
        cells = [f"{k}. {s.text} ({s.place})", s.criterion]
        cells += [
            verdict_word(verdict) + (f": {verdict.measured}" if verdict else "")
            for verdict in (s.direct, s.table)
        ]
        rows.append(cells)
    return rows


def failing_lines(statements: Sequence[Statement]) -> list[str]:
    """Name each statement that does not hold, and what it does not hold for."""
    lines = []
    for s in statements:
        sides = (("the direct model", s.direct), ("the table", s.table))
        fails = [words for words, verdict in sides if verdict and verdict.holds is False]
        if fails:
            lines.append(f"{s.text} ({s.place}) Not for {' and '.join(fails)}.")
    return lines


#: Head of `statement_rows`.
STATEMENT_HEAD = ("statement", "asked for", "direct model", "table (mixture)")


def are_judged(statements: Sequence[Statement]) -> bool:
    """Whether the statements are about the pair and the particles that were measured."""
    return all(s.direct is None or s.direct.holds is not None for s in statements)


def counts_text(statements: Sequence[Statement]) -> str:
    """Count what holds, or say why nothing is judged."""
    if not are_judged(statements):
        return (
            "Statements of the paper: they are about corundum on steel and its particles; laws or "
            "particles here are others, so what was measured is given and not judged."
        )
    parts = []
    for name in ("direct", "table"):
        verdicts = [v for s in statements if (v := getattr(s, name)) is not None]
        holding = sum(v.holds is True for v in verdicts)
        words = "the direct model" if name == "direct" else "the table"
        parts.append(f"{holding} of {len(verdicts)} hold for {words}")
    return "Statements of the paper: " + ", ".join(parts) + "."


def _markdown_table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [
        "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"
        for cells in (head, *rows)
    ]
    return "\n".join([lines[0], "|" + "---|" * len(head), *lines[1:]])


def statements_page(gallery: PaperFigures) -> str:
    """Markdown of the statements, the paper's table and the figures."""
    figures = "\n\n".join(
        f"### {picture.title}\n\n![{picture.alternative}]({picture.name})"
        for picture in gallery.pictures
    )
    unchecked = "\n".join(f"- {line}" for line in NOT_CHECKED)
    return (
        "# Panfilov & Tsirkunov (2022), checked\n\n"
        f"{counts_text(gallery.statements)} {gallery.count:,} particles of each shape at each "
        f"angle, {SPEED:g} m/s, seed {gallery.statistics.seed}. A table holds the mixture, without "
        "collisions and rotational energies.\n\n## Statements\n\n"
        f"{_markdown_table(STATEMENT_HEAD, statement_rows(gallery.statements))}\n\n"
        f"Not checked:\n\n{unchecked}\n\n"
        "## Collisions in a rebound at normal impact, in per cent of the particles\n\n"
        f"{_markdown_table(COLLISION_HEAD, collision_rows(gallery.statistics))}\n\n"
        f"## Figures\n\n{figures}\n"
    )


def statements_json(gallery: PaperFigures) -> str:
    """JSON of the statements."""
    data = {
        "count": gallery.count,
        "seed": gallery.statistics.seed,
        "speed": SPEED,
        "judged": are_judged(gallery.statements),
        "statements": [statement.to_dict() for statement in gallery.statements],
        "not_checked": list(NOT_CHECKED),
        "collisions": [
            dict(zip(COLLISION_HEAD, row, strict=True))
            for row in collision_rows(gallery.statistics)
        ],
    }
    return json_text(data)


def laws_json(gallery: PaperFigures) -> str:
    """JSON of the numbers behind the curves."""
    return json_text(to_dict(gallery))


def statements_text(statements: Sequence[Statement]) -> str:
    """Statements for a terminal."""
    lines = []
    for k, s in enumerate(statements, 1):
        lines.append(f"{k:2d}. {s.text}")
        for name, verdict in (("direct", s.direct), ("table", s.table)):
            if verdict is not None:
                lines.append(f"      {name:<7} {verdict_word(verdict)}: {verdict.measured}")
    return "\n".join([*lines, counts_text(statements)])
