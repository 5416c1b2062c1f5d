"""Command lines in documents and help pages, parsed by the programs themselves; nothing is run."""

import contextlib
import shlex
from importlib.util import find_spec
from pathlib import Path

import click
from documents import ROOT

from sampler.cli import cli as sampler
from tablegen.commands.main import cli as tablegen

PROGRAMS = {"tablegen": tablegen, "sampler": sampler}


def logical_lines(text):
    """Lines of a shell text: continued ones joined, comments and blank lines left out."""
    lines = (line.strip() for line in text.replace("\\\n", " ").splitlines())
    return [line for line in lines if line and not line.startswith("#")]


def _words_of_program(words):
    """The words from a program's name on, or None; ``mpiexec -n 4 tablegen`` starts one too."""
    if words[:1] == ["mpiexec"]:
        words = words[3:]
    if words[1:2] == ["-m"] and Path(words[0]).name in ("python", "python3"):
        words = words[2:]
    if words and Path(words[0]).name in PROGRAMS:
        return [Path(words[0]).name, *words[1:]]
    return None


def calls(text):
    """Calls of our programs in a shell text, each a list of words that begins with the program."""
    word_lists = []
    for line in logical_lines(text):
        reader = shlex.shlex(line, posix=True, punctuation_chars="&;|<>")
        reader.whitespace_split = True
        command = []
        for word in [*reader, ";"]:
            if word[0] not in "&;|<>":
                command.append(word)
                continue
            word_lists.append(_words_of_program(command))
            command = []
    return [words for words in word_lists if words]


def parse(words, folder):
    """Let a program parse a call in a folder; raises `click.ClickException` if it is refused.

    The folders of its outputs are made, for the programs refuse to write into a missing one.
    """
    for word in words[1:]:
        if not word.startswith("-") and not Path(word).is_absolute():
            (folder / word).parent.mkdir(parents=True, exist_ok=True)
    program = PROGRAMS[words[0]]
    # --help, --version and --include-dir end a program at once
    with contextlib.chdir(folder), contextlib.suppress(click.exceptions.Exit):
        context = program.make_context(words[0], words[1:2])
        _, command, rest = program.resolve_command(context, words[1:])
        command.make_context(command.name, rest, parent=context).close()


def mistake_of_script(words):
    """Return the mistake in a call of Python or of a script of this repository, or None."""
    if words[0] in ("python", "python3"):
        words = words[1:]
        if words[:1] == ["-m"]:
            first = words[1].partition(".")[0]
            known = first not in ("sampler", "tablegen") or find_spec(words[1]) is not None
            return None if known else f"no module {words[1]}"
    if not words or not words[0].endswith((".py", ".sh")):
        return None
    script = ROOT / words[0]
    if not script.is_file():
        return f"no file {words[0]}"
    text = script.read_text(encoding="utf-8")
    for word in words[1:]:
        if word.startswith("--") and f'"{word}"' not in text:
            return f"{words[0]} has no option {word}"
    return None
