"""``tablegen figures``: what it writes, the same each time, and what it refuses."""

import json
import re
import sys

import pytest
from command_line import DONE
from tablegen.evidence.all_figures import PAPER_TABLE

from tablegen.evidence import all_figures as galleries

pytest.importorskip("matplotlib")

NAMES = {
    *(f"figure-{k:02d}.svg" for k in (3, 4, 5, 6, 7, 8, 9, 10, 13)),
    *(f"figure-{k:02d}.png" for k in (11, 12)),
    *("statements.md", "statements.json", "laws.json"),
}


@pytest.fixture(scope="module")
def folder(tiny, tmp_path_factory):
    """Figures of few particles, beside the tiny table."""
    from tablegen.commands.main import main

    place = tmp_path_factory.mktemp("figures") / "made"
    words = ["figures", str(tiny.path), "--output", str(place), "--count", "1000", "--quiet"]
    assert main(words) == DONE
    return place


def test_writes_every_figure(folder):
    assert {path.name for path in folder.iterdir()} == NAMES
    for path in folder.glob("*.svg"):
        assert path.read_text().rstrip().endswith("</svg>")
    for path in folder.glob("*.png"):
        assert path.read_bytes().startswith(b"\x89PNG")


def test_lists_every_statement_with_what_was_measured(folder):
    data = json.loads((folder / "statements.json").read_text())
    assert len(data["statements"]) >= 20
    assert len(data["not_checked"]) >= 2
    page = (folder / "statements.md").read_text()
    for k, statement in enumerate(data["statements"], 1):
        assert statement["direct"]["measured"]
        assert f"| {k}. {statement['text']}" in page
    verdicts = {s["direct"]["holds"] for s in data["statements"]}
    assert verdicts == {True, False}
    assert "does not hold" in page
    for name in NAMES:
        if name.startswith("figure"):
            assert f"]({name})" in page


def test_paper_s_table_stands_beside_ours(folder):
    page = (folder / "statements.md").read_text()
    for shape, shares in PAPER_TABLE.items():
        assert sum(shares) == pytest.approx(100.0, abs=0.15)
        cells = " | ".join(f"{share:.1f}" for share in shares)
        assert f"| {shape} | paper | {cells} |" in page
        assert re.search(rf"\| {shape} \| direct \| [\d.]+ \|", page)


def test_table_s_laws_are_where_the_table_is(folder):
    laws = json.loads((folder / "laws.json").read_text())["laws"]
    of_table = [law["alpha_deg"] for law in laws if law["source"] == "table"]
    assert of_table == [35.0, 40.0, 45.0]
    assert all(law["shape"] == "mixture" for law in laws if law["source"] == "table")


@pytest.mark.study
def test_same_seed_same_bytes(folder, tiny, run, tmp_path):
    place = tmp_path / "again"
    ended = run("figures", tiny.path, "--output", place, "--count", 1000, "--quiet")
    assert (ended.status, ended.err) == (DONE, "")
    assert "Statements of the paper: " in ended.out
    for path in folder.iterdir():
        assert (place / path.name).read_bytes() == path.read_bytes(), path.name


@pytest.mark.parametrize(
    ("words", "parts"),
    [
        ((), ("--output",)),
        (("no-such-table", "--output", "x"), ("no-such-table",)),
        (("--output", "none/there/x"), ("--output", "none/there/x", "a folder")),
        (("--output", "x", "--count", 10), ("--count", "got '10'")),
        (("--output", "x", "--seed", -1), ("--seed", "got '-1'")),
    ],
)
def test_refusals_name_flag_and_value(refused, monkeypatch, tmp_path, words, parts):
    monkeypatch.chdir(tmp_path)
    line = refused("figures", *words)
    assert all(part in line for part in parts)


def test_a_file_is_no_folder(refused, tmp_path):
    (tmp_path / "taken").write_text("mine")
    line = refused("figures", "--output", tmp_path / "taken")
    assert "allowed: a folder" in line


def test_without_matplotlib_nothing_is_simulated(refused, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    monkeypatch.setattr(galleries, "make_statistics", None)
    line = refused("figures", "--output", tmp_path / "x")
    assert line.startswith("tablegen figures: needs matplotlib, which is not installed")
