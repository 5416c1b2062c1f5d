"""Examples in documents run, commands are accepted, links, paths and names lead somewhere."""

import itertools
import pkgutil
import re
import shlex
import tomllib

import click
import documents
import pytest
import trimesh
import yaml
from command_lines import (
    calls,
    logical_lines,
    mistake_of_script,
    parse,
)
from documents import DOCUMENTS, ROOT, SHELL

import sampler
from tablegen import parse_config

#: Run by tests/embedding/test_trackers.py: one needs CuPy, the other takes long to compile.
ELSEWHERE = [ROOT / "sampler" / "device" / "README.md", ROOT / "sampler" / "NUMBA.md"]

every_document = pytest.mark.parametrize("path", DOCUMENTS, ids=lambda p: str(p.relative_to(ROOT)))


def read(path):
    return path.read_text(encoding="utf-8")


def blocks_in(path, *languages):
    return [block for block in documents.blocks(read(path)) if block.language in languages]


@every_document
def test_python_blocks_run_and_print_what_the_page_shows(path, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "agg")
    names = {}  # the blocks of a page are read one after the other
    following = itertools.pairwise([*documents.blocks(read(path)), None])
    for block, after in following if path not in ELSEWHERE else []:
        if block.language != "python":
            continue
        # padded, so that a traceback shows the line of the document
        exec(compile("\n" * (block.line - 1) + block.text, str(path), "exec"), names)
        printed = capsys.readouterr().out
        # the block of text that stands right behind a program is its output
        if after and after.language == "text" and after.line <= block.last_line + 3:
            assert printed == after.text, f"{path}:{after.line}"


@every_document
def test_commands_are_accepted_and_scripts_exist(path, tmp_path):
    for block in blocks_in(path, *SHELL):
        for words in calls(block.text):
            try:
                parse(words, tmp_path)
            except click.ClickException as error:
                pytest.fail(f"{path}:{block.line}: {shlex.join(words)}: {error}")
        # a fence without a language may show output, which is no shell text
        for line in logical_lines(block.text):
            assert mistake_of_script(line.split()) is None, f"{path}:{block.line}: {line}"


@every_document
def test_links_lead_to_files_and_headings(path):
    for target in documents.links(read(path)):
        if target.startswith(("http://", "https://", "mailto:")):
            continue
        name, _, anchor = target.partition("#")
        file = path.parent / name if name else path
        assert file.exists(), target
        assert not anchor or anchor in documents.anchors(read(file)), target


@pytest.mark.parametrize("page", ["own-grain.md", "scenes.md", "from-diameter-to-flow.md"])
def test_scenes_in_guides_are_configurations(page, tmp_path):
    for name in ("grain-1.stl", "grain-2.stl"):
        trimesh.creation.box().export(tmp_path / name)
    scenes = blocks_in(ROOT / "docs" / page, "toml")
    assert scenes
    for block in scenes:
        parse_config(block.text, f"docs/{page}:{block.line}", tmp_path)


def exists(name):
    """Whether a dotted name is a module, an attribute of one, or of a class in one."""
    try:
        pkgutil.resolve_name(name)
    except (ImportError, AttributeError):
        return False
    return True


def test_names_in_docstrings_exist():
    names = {
        (name, str(path.relative_to(ROOT)))
        for package in ("sampler", "tablegen")
        for path in (ROOT / package).rglob("*.py")
        for name in re.findall(r"`((?:sampler|tablegen)(?:\.\w+)+)`", read(path))
    }
    assert len(names) > 20
    assert [pair for pair in sorted(names) if not exists(pair[0])] == []
    assert not exists("sampler.nowhere")
    assert not exists("sampler.Table.x")


def test_citation_agrees_with_the_package():
    citation = yaml.safe_load(read(ROOT / "CITATION.cff"))
    project = tomllib.loads(read(ROOT / "pyproject.toml"))["project"]
    assert citation["version"] == sampler.__version__
    for field in ("license", "keywords"):
        assert citation[field] == project[field]
    assert citation["title"] == project["name"]
    assert [a["name"] for a in citation["authors"]] == [a["name"] for a in project["authors"]]
