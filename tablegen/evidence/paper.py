"""Paper of Panfilov and Tsirkunov (2022), checked: figures, table and statements, as files."""

from collections.abc import Sequence
from dataclasses import asdict

from sampler.files import json_text
from sampler.table import Table
from tablegen.config.config import Config
from tablegen.evidence.page import Block, Headline, Section, render_page
from tablegen.evidence.paper_figures import paper_pictures
from tablegen.evidence.paper_statements import (
    NOT_CHECKED,
    Statement,
    Verdict,
    check_statements,
    is_of_the_paper,
)
from tablegen.evidence.paper_statistics import (
    ANGLES,
    DIRECT,
    SHAPES,
    SPEED,
    FigureStatistics,
    make_statistics,
)
from tablegen.presentation import TextTable
from tablegen.progress import bar

#: The paper's table: shares of particles with 1, 2, 3, 4, 5 and more collisions, normal impact.
PAPER_TABLE = {
    "ellipsoid": (42.2, 31.2, 8.9, 4.3, 2.6, 10.8),
    "prism": (13.3, 40.1, 19.5, 14.6, 5.4, 7.1),
    "truncated-prism": (25.9, 37.7, 17.8, 9.7, 4.8, 4.1),
    "tetrahedron": (5.2, 12.8, 9.3, 7.9, 8.3, 56.5),
}

#: Files of ``tablegen figures`` beside the pictures.
TEXTS = ("statements.html", "statements.json", "laws.json")

COLLISION_HEAD = ("shape", "source", "1", "2", "3", "4", "5", "> 5")
STATEMENT_HEAD = ("statement", "criterion", "direct model", "table (mixture)")


def collision_rows(statistics: FigureStatistics) -> list[list[str]]:
    """Cells of the paper's table in per cent, ours and, for its pair and particles, its own."""
    rows, of_the_paper = [], is_of_the_paper(statistics.config)
    for shape, paper in PAPER_TABLE.items():
        sample = statistics.at(DIRECT, shape, 90.0)
        if sample is not None and sample.collisions is not None:
            rows.append([shape, "direct", *(f"{100.0 * share:.1f}" for share in sample.collisions)])
        if of_the_paper:
            rows.append([shape, "paper", *(f"{share:.1f}" for share in paper)])
    return rows


def _verdict_text(verdict: Verdict | None) -> str:
    if verdict is None:
        return "cannot tell"
    words = {None: "measured", True: "holds", False: "does not hold"}[verdict.holds]
    return f"{words}: {verdict.measured}"


def statement_rows(statements: Sequence[Statement]) -> list[list[str]]:
    """Cells of `STATEMENT_HEAD`."""
    return [
        [f"{k}. {s.text} ({s.place})", s.criterion, _verdict_text(s.direct), _verdict_text(s.table)]
        for k, s in enumerate(statements, 1)
    ]


def failing_lines(statements: Sequence[Statement]) -> list[str]:
    """Name each statement that does not hold, and for which source."""
    lines = []
    for s in statements:
        sides = (("the direct model", s.direct), ("the table", s.table))
        fails = [words for words, verdict in sides if verdict and verdict.holds is False]
        if fails:
            lines.append(f"{s.text} ({s.place}) Not for {' and '.join(fails)}.")
    return lines


def counts_text(statements: Sequence[Statement]) -> str:
    """Count the statements that hold, or say why none is judged."""
    if any(s.direct is not None and s.direct.holds is None for s in statements):
        return (
            "Statements of the paper: they are about corundum on steel and its particles; laws or "
            "particles here differ, so measurements are given and not judged."
        )
    parts = []
    for name, words in (("direct", "the direct model"), ("table", "the table")):
        verdicts = [v for s in statements if (v := getattr(s, name)) is not None]
        holding = sum(v.holds is True for v in verdicts)
        parts.append(f"{holding} of {len(verdicts)} hold for {words}")
    return "Statements of the paper: " + ", ".join(parts) + "."


def check_paper(
    table: Table, config: Config, count: int, seed: int, progress: bool = False
) -> tuple[list[Statement], dict[str, bytes]]:
    """Simulate, draw and check everything, from `count` particles of each shape at each angle.

    Returns the statements, and the files of ``tablegen figures`` by name: pictures, a page, and
    numbers as JSON.
    """
    steps = len(ANGLES) * len(SHAPES)
    with bar(progress, total=steps, desc="samples of the figures") as counted:
        statistics = make_statistics(table, config, count, seed, counted.update)
    statements, pictures = check_statements(statistics), paper_pictures(statistics)
    rows = collision_rows(statistics)
    blocks: list[Block] = [
        Headline("open", counts_text(statements), failing_lines(statements)),
        f"{count:,} particles of each shape at each angle, {SPEED:g} m/s. A table holds the "
        "mixture, without collisions and rotational energies.",
        TextTable("Statements", STATEMENT_HEAD, statement_rows(statements), "words"),
        Headline("soft", "Not checked:", NOT_CHECKED),
        TextTable("Collisions at normal impact, per cent", COLLISION_HEAD, rows),
        *pictures,
    ]
    title, head = "Panfilov & Tsirkunov (2022), checked", {"count": count, "seed": seed}
    stated = head | {
        "speed": SPEED,
        "judged": is_of_the_paper(config),
        "statements": [asdict(statement) for statement in statements],
        "not_checked": list(NOT_CHECKED),
        "collisions": [dict(zip(COLLISION_HEAD, row, strict=True)) for row in rows],
    }
    laws = head | {
        "laws": [sample.to_dict() for sample in statistics.samples.values()],
        "sphere_alpha2_deg": [
            {"alpha_deg": alpha_deg, "alpha2_deg": low}
            for alpha_deg, (low, _) in statistics.sphere_deg.items()
        ],
    }
    page = render_page(title, [Section(title, blocks)])
    texts = zip(TEXTS, (page, json_text(stated), json_text(laws)), strict=True)
    files = {picture.name: picture.data for picture in pictures}
    return statements, files | {name: text.encode() for name, text in texts}
