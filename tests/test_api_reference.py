"""The API reference is built by the command that the documents name, and has every public name."""

import html
import importlib
import os
import re
import shlex
import subprocess
import sys

import pytest
from documents import ROOT, blocks

PACKAGES = ("sampler", "tablegen")


def documented_command():
    """Words of the command in the page for authors of flow codes."""
    page = (ROOT / "docs" / "flow-code-author.md").read_text(encoding="utf-8")
    lines = [line for block in blocks(page) for line in block.text.splitlines()]
    (line,) = (line for line in lines if line.startswith("pdoc "))
    return shlex.split(line)


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    pytest.importorskip("pdoc")
    folder = tmp_path_factory.mktemp("reference")
    path = os.pathsep.join(filter(None, [str(ROOT), os.environ.get("PYTHONPATH")]))
    words = [sys.executable, "-m", *documented_command()]
    subprocess.run(words, cwd=folder, env=os.environ | {"PYTHONPATH": path}, check=True)
    return {name: (folder / "api" / f"{name}.html").read_text("utf-8") for name in PACKAGES}


def documentation(page, name):
    """Text of what a page says of a name, without its source."""
    section = re.search(rf'<section id="{re.escape(name)}">(.*?)</section>', page, re.S)
    assert section, name
    text = re.search(r'<div class="docstring">(.*?)</div>', section[1], re.S)
    return html.unescape(re.sub(r"<[^>]+>", "", text[1])) if text else ""


@pytest.mark.parametrize("package", PACKAGES)
def test_every_public_name_is_documented(package, pages):
    module = importlib.import_module(package)
    # what a constant means pdoc finds where it is defined only: status codes, in sampler.errors
    names = {name for name in module.__all__ if not isinstance(getattr(module, name), int | str)}
    undocumented = {name for name in names if not documentation(pages[package], name).strip()}
    assert not undocumented


def test_a_compiled_function_is_documented_as_it_is_called(pages):
    section = re.search(r'<section id="draw">(.*?)</section>', pages["sampler"], re.S)[1]
    for name in ("arrays", "alpha1", "speed", "seed", "index", "hit", "state"):
        assert f'<span class="n">{name}</span>' in section
    assert "Impact angle in rad from the wall" in documentation(pages["sampler"], "draw")


def test_sections_of_docstrings_are_headings(pages):
    for name in ("parameters", "returns"):
        assert re.search(rf'<h6 id="{name}[\w-]*">', pages["sampler"])


def test_nothing_generated_is_kept():
    assert "/api/" in (ROOT / ".gitignore").read_text(encoding="utf-8").splitlines()
