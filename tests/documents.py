"""The documents of this repository: their fenced blocks and their links."""

import re
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]

_PATTERNS = (
    "README.md",
    "CONTRIBUTING.md",
    "CHANGELOG.md",
    "docs/*.md",
    "tables/*.md",
    "sampler/**/*.md",
    "tablegen/**/*.md",
)

DOCUMENTS = sorted(path for pattern in _PATTERNS for path in ROOT.glob(pattern))

#: Fences without a language show a shell, or what a program prints.
SHELL = ("", "sh", "bash", "shell", "console")

_FENCE = re.compile(
    r"^(?P<indent> *)```(?P<language>\w*)\n(?P<text>.*?)^(?P=indent)```$", re.M | re.S
)
_LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
_HEADING = re.compile(r"^#+ +(.+?) *$", re.M)


class Block(NamedTuple):
    """A fenced block.

    Attributes
    ----------
    language : str
        Empty where the fence names none.
    text : str
    line : int
        Of the document, on which the text begins, from 1.
    """

    language: str
    text: str
    line: int


def blocks(document):
    """Fenced blocks of a text, in order."""
    return [
        Block(m["language"], m["text"], document.count("\n", 0, m.start("text")) + 1)
        for m in _FENCE.finditer(document)
    ]


def links(document):
    """Targets of links and pictures outside fenced blocks and code, in order."""
    prose = re.sub(r"`[^`\n]+`", "", _FENCE.sub("", document))
    return _LINK.findall(prose)


def anchors(document):
    """Anchors that GitHub gives to the headings."""
    prose = _FENCE.sub("", document)
    return {
        re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")
        for heading in _HEADING.findall(prose)
    }
