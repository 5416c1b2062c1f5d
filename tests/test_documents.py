"""What the documents show works: examples run, commands are accepted, links lead somewhere."""

import re
import shlex
import sys
import tomllib
from pathlib import Path

import click
import documents
import numpy as np
import pytest
from command_lines import calls, logical_lines, parse
from documents import DOCUMENTS, ROOT, SHELL
from scipy.stats import kstwobign

from tablegen import parse_config

sys.path.insert(0, str(Path(__file__).resolve().parent / "embedding"))
from cupy_on_host import in_place_of_cupy

every_document = pytest.mark.parametrize(
    "path", DOCUMENTS, ids=[str(path.relative_to(ROOT)) for path in DOCUMENTS]
)


def read(path):
    return path.read_text(encoding="utf-8")


def blocks_in(path, *languages):
    return [block for block in documents.blocks(read(path)) if block.language in languages]


@every_document
def test_python_blocks_run(path, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = {}  # the blocks of a page are read one after the other
    with in_place_of_cupy(tmp_path):
        for block in blocks_in(path, "python"):
            # padded, so that a traceback shows the line of the document
            exec(compile("\n" * (block.line - 1) + block.text, str(path), "exec"), names)


@every_document
def test_commands_are_accepted(path, tmp_path):
    for block in blocks_in(path, *SHELL):
        for words in calls(block.text):
            try:
                parse(words, tmp_path)
            except click.ClickException as error:
                pytest.fail(f"{path}:{block.line}: {shlex.join(words)}: {error}")


@every_document
def test_scripts_exist(path):
    for block in blocks_in(path, *SHELL):
        for line in logical_lines(block.text):
            words = line.split()
            script = words[1] if words[0] in ("python", "python3") and words[1:] else words[0]
            if script.endswith((".py", ".sh")):
                assert (ROOT / script).is_file(), f"{path}:{block.line}: {line}"


@every_document
def test_toml_blocks_are_toml(path):
    for block in blocks_in(path, "toml"):
        tomllib.loads(block.text)


@every_document
def test_links_lead_to_files_and_headings(path):
    for target in documents.links(read(path)):
        if target.startswith(("http://", "https://", "mailto:")):
            continue
        name, _, anchor = target.partition("#")
        file = path.parent / name if name else path
        assert file.exists(), f"{path}: {target}"
        if anchor:
            assert anchor in documents.anchors(read(file)), f"{path}: {target}"


def test_scene_of_the_table_maker_is_a_configuration():
    path = ROOT / "docs" / "table-maker.md"
    (block,) = blocks_in(path, "toml")
    scene = parse_config(block.text, "docs/table-maker.md")
    assert scene.name == "my-scene"
    assert scene.domain.dimension == 2
    assert scene.accuracy.preset == "compact"


def test_noise_that_the_validator_is_told_of():
    text = read(ROOT / "docs" / "validator.md")
    factor, distance = map(float, re.search(r"by (\S+) √.*?by (\S+) with", text, re.S).groups())
    mean = kstwobign.mean()
    assert factor == round(mean, 2)
    assert distance == round(mean * np.sqrt(2.0 / 50_000), 4)


def test_documents_are_found():
    names = {str(path.relative_to(ROOT)) for path in DOCUMENTS}
    assert names >= {
        "README.md",
        "CONTRIBUTING.md",
        "tables/FORMAT.md",
        "sampler/c/README.md",
    }


def test_commands_are_found():
    text = (
        "python3 -m venv .venv && .venv/bin/pip install . && .venv/bin/tablegen demo\n"
        "# tablegen is no command here\n"
        "mpiexec -n 4 tablegen generate a.toml \\\n    --output a.h5 > log.txt\n"
        "python -m sampler --include-dir; tablegenerate x\n"
    )
    assert calls(text) == [
        ["tablegen", "demo"],
        ["tablegen", "generate", "a.toml", "--output", "a.h5"],
        ["sampler", "--include-dir"],
    ]


@pytest.mark.parametrize(
    "line",
    [
        "tablegen demonstrate",
        "tablegen demo --outptu a.h5",
        "tablegen validate",
        "tablegen simulate --pair corundum-steel --shape cube --alpha 45 --speed 200 --count 1 "
        "--seed 1 --output a.npz",
        "sampler draw corundum-steel --alpha 45",
        "sampler draw corundum-steel --alpha 95 --speed 200 --count 1 --seed 1 --output a.npz",
    ],
)
def test_a_wrong_command_is_seen(line, tmp_path):
    (words,) = calls(line)
    with pytest.raises(click.ClickException):
        parse(words, tmp_path)


def test_blocks_links_and_anchors_are_read():
    text = "# A b, c\n[x](a.md#b) `[y](b.md)`\n```python\n# no\n[z](c.md)\n```\n\n```\nls\n```\n"
    assert documents.blocks(text) == [
        ("python", "# no\n[z](c.md)\n", 4),
        ("", "ls\n", 9),
    ]
    assert documents.links(text) == ["a.md#b"]
    assert documents.anchors(text) == {"a-b-c"}


def test_table_of_changes_names_few_files_that_exist():
    section = read(ROOT / "CONTRIBUTING.md").partition("## Where to change what")[2]
    rows = re.findall(r"^\| [^|`]+ \| (.*`.*) \|$", section.partition("\n## ")[0], re.M)
    assert 0 < len(rows) <= 12
    for row in rows:
        paths = [name for name in re.findall(r"`([^`]+)`", row) if "/" in name]
        assert len(paths) <= 4, row
        assert all((ROOT / path).exists() for path in paths), row
