"""Texts of which a program writes the parts between two marks; people write the other parts."""

from collections.abc import Callable, Mapping
from pathlib import Path

from sampler.errors import InputError
from sampler.files import write_text


def filled(
    text: str, name: str, parts: Mapping[str, Callable[[], str]], mark: str = "<!-- {} {} -->"
) -> str:
    """Replace the parts of a text by what makes them; `name` is that of its file.

    Each is between a line ``<!-- begin PART -->`` and a line ``<!-- end PART -->``, or of the form
    `mark`; raises `InputError` if a part is not marked exactly once.
    """
    for part, write_part in parts.items():
        begin, end = (mark.format(word, part) + "\n" for word in ("begin", "end"))
        if text.count(begin) != 1 or text.count(end) != 1 or text.index(begin) > text.index(end):
            problem = f"part '{part}' is not marked exactly once"
            remedy = f"write {begin.strip()} and {end.strip()} around it"
            raise InputError("", problem=problem, remedy=remedy, source=name)
        before, rest = text.split(begin)
        text = f"{before}{begin}{write_part()}{end}{rest.split(end)[1]}"
    return text


def fill_file(path: Path, fill: Callable[[str], str]) -> None:
    """Bring the marked parts of a file up to date; ``fill`` does so in its text."""
    write_text(path, fill(path.read_text(encoding="utf-8")))
