"""Every command has examples in its help, and the program accepts each of them."""

import re

import click
import pytest
from click.testing import CliRunner
from command_lines import PROGRAMS, calls, logical_lines, parse

#: Commands by path; that of a program has its name alone.
COMMANDS = {(name,): program for name, program in PROGRAMS.items()}
COMMANDS |= {(n, c): command for n, cli in PROGRAMS.items() for c, command in cli.commands.items()}

every_page = pytest.mark.parametrize("path", COMMANDS, ids=" ".join)


def page_of(path, flag="--help"):
    program, *words = path
    shown = CliRunner().invoke(PROGRAMS[program], [*words, flag], prog_name=program)
    assert (shown.exit_code, shown.stderr) == (0, "")
    return shown.stdout


@every_page
def test_examples_are_of_the_command_and_accepted(path, tmp_path):
    page = page_of(path)
    assert page_of(path, "-h") == page
    text = re.search(r"^ *Examples:\n(.*?)(?:\n\s*\n|\Z)", page, re.M | re.S)[1]
    found = calls(text)
    assert found
    # no line of the examples is anything else
    assert len(found) == len(logical_lines(text))
    for words in found:
        assert tuple(words[: len(path)]) == path
        parse(words, tmp_path)


@every_page
def test_says_what_the_command_and_each_option_does(path):
    assert COMMANDS[path].help
    for option in COMMANDS[path].params:
        assert option.help or isinstance(option, click.Argument), option.name


@every_page
def test_fits_a_terminal(path):
    assert max(map(len, page_of(path).splitlines())) <= 100


@pytest.mark.parametrize("program", PROGRAMS)
def test_list_of_commands_is_whole(program):
    _, listed = page_of((program,)).split("Commands:")
    assert "..." not in listed
    assert all(f"  {name} " in listed for name in PROGRAMS[program].commands)
