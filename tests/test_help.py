"""Every command has examples in its help, and the program accepts each of them."""

import re

import click
import pytest
from click.testing import CliRunner
from command_lines import PROGRAMS, calls, logical_lines, parse

#: Commands by path; that of a program has its name alone.
COMMANDS = {(name,): program for name, program in PROGRAMS.items()}
COMMANDS |= {(n, c): command for n, cli in PROGRAMS.items() for c, command in cli.commands.items()}


@pytest.mark.parametrize("path", COMMANDS, ids=" ".join)
def test_help_says_what_each_option_does_and_its_examples_are_accepted(path, tmp_path):
    program, *words = path
    pages = [
        CliRunner().invoke(PROGRAMS[program], [*words, flag], prog_name=program)
        for flag in ("--help", "-h")
    ]
    assert {(page.exit_code, page.stderr) for page in pages} == {(0, "")}
    text = pages[0].stdout
    assert pages[1].stdout == text
    assert max(map(len, text.splitlines())) <= 100
    command = COMMANDS[path]
    assert command.help
    assert all(isinstance(p, click.Argument) or p.help for p in command.params)
    examples = re.search(r"^ *Examples:\n(.*?)(?:\n\s*\n|\Z)", text, re.M | re.S)[1]
    example_calls = calls(examples)
    assert 0 < len(example_calls) == len(logical_lines(examples))
    for words in example_calls:
        assert tuple(words[: len(path)]) == path
        parse(words, tmp_path)
