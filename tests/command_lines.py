"""Command lines in documents and help pages, parsed by the programs themselves; nothing is run."""

import contextlib
import shlex
from pathlib import Path

import click

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
    found = []
    for line in logical_lines(text):
        reader = shlex.shlex(line, posix=True, punctuation_chars="&;|<>")
        reader.whitespace_split = True
        command = []
        for word in [*reader, ";"]:
            if word[0] not in "&;|<>":
                command.append(word)
                continue
            found.append(_words_of_program(command))
            command = []
    return [words for words in found if words]


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
