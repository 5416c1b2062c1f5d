"""The documents of this repository: their fenced blocks, links and anchors."""

import re
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]

_PATTERNS = ("*.md", "docs/*.md", "tables/*.md", "sampler/**/*.md", "tablegen/**/*.md")
DOCUMENTS = sorted(path for pattern in _PATTERNS for path in ROOT.glob(pattern))

#: Fences without a language show a shell, or the output of a program.
SHELL = ("", "sh", "bash", "shell", "console")

_FENCE = re.compile(
    r"^(?P<indent> *)```(?P<language>\w*)\n(?P<text>.*?)^(?P=indent)```$", re.M | re.S
)


class Block(NamedTuple):
    """A fenced block, and the line of the document on which its text begins."""

    language: str
    text: str
    line: int

    @property
    def last_line(self):
        """The line of the closing fence."""
        return self.line + self.text.count("\n")


def blocks(document):
    """Fenced blocks of a text, in order."""
    return [
        Block(m["language"], m["text"], document.count("\n", 0, m.start("text")) + 1)
        for m in _FENCE.finditer(document)
    ]


def links(document):
    """Targets of links and pictures outside fenced blocks and code, in order."""
    prose = re.sub(r"`[^`\n]+`", "", _FENCE.sub("", document))
    return re.findall(r"\[[^\]]*\]\(([^)\s]+)\)", prose)


def anchors(document):
    """Anchors that GitHub gives to the headings."""
    headings = re.findall(r"^#+ +(.+?) *$", _FENCE.sub("", document), re.M)
    return {re.sub(r"[^\w\- ]", "", text.lower()).replace(" ", "-") for text in headings}
