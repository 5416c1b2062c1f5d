"""Every command has examples in its help, and the program accepts each of them."""

import argparse
import re

import click
import pytest
from click.testing import CliRunner
from command_lines import calls, logical_lines, parse

from sampler.commands.main import _parser as sampler_parser
from tablegen.commands.main import cli


def tablegen_commands(command, path=()):
    """Paths of a click command and of all below it; that of the program itself is empty."""
    yield path
    if isinstance(command, click.Group):
        for name, child in command.commands.items():
            yield from tablegen_commands(child, (*path, name))


def sampler_helps():
    """Help of the program and of each of its commands, by path."""
    parser = sampler_parser()
    helps = {(): parser.format_help()}
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for name, child in action.choices.items():
                helps[name,] = child.format_help()
    return helps


def help_pages():
    for path in tablegen_commands(cli):
        result = CliRunner().invoke(cli, [*path, "--help"], prog_name="tablegen")
        assert result.exit_code == 0
        yield ("tablegen", *path), result.output
    for path, text in sampler_helps().items():
        yield ("sampler", *path), text


PAGES = dict(help_pages())
every_page = pytest.mark.parametrize("path", PAGES, ids=" ".join)


def examples_of(path):
    """Text of the examples, up to the first blank line."""
    found = re.search(r"^ *examples:\n(.*?)(?:\n\s*\n|\Z)", PAGES[path], re.M | re.S | re.I)
    return found[1] if found else ""


@every_page
def test_examples_are_of_the_command_and_accepted(path, tmp_path):
    text = examples_of(path)
    found = calls(text)
    assert found
    # no line of the examples is anything else
    assert len(found) == len(logical_lines(text))
    for words in found:
        assert tuple(words[: len(path)]) == path
        parse(words, tmp_path)


@pytest.mark.parametrize("name", cli.commands)
def test_says_what_the_command_and_each_option_does(name):
    command = cli.commands[name]
    assert command.help
    for option in command.params:
        if isinstance(option, click.Option):
            assert option.help, option.name


def test_list_of_commands_is_not_cut_off():
    _, listed = PAGES["tablegen",].split("Commands:")
    assert "..." not in listed


@every_page
def test_fits_a_terminal(path):
    assert max(map(len, PAGES[path].splitlines())) <= 100


def test_all_commands_are_walked():
    assert {path[1:] for path in PAGES if path[0] == "tablegen"} == {
        (),
        *((name,) for name in cli.commands),
    }
    assert ("sampler", "draw") in PAGES
