"""The options of a command, in one module, are the parameters of its work, in another."""

import importlib
import inspect

import pytest

from sampler.commands.main import _parser
from tablegen.commands.main import cli


def work_of(command):
    """Function to which a command hands its options; its module is named in the command."""
    code = inspect.unwrap(command.callback).__code__
    (module,) = (
        text
        for text in code.co_consts
        if isinstance(text, str) and text.partition(".")[0] in ("sampler", "tablegen")
    )
    return importlib.import_module(module).run


@pytest.mark.parametrize("name", sorted(cli.commands))
def test_work_of_tablegen_takes_the_options(name):
    command = cli.commands[name]
    parameters = list(inspect.signature(work_of(command)).parameters)
    context = ["ranks"] if name == "generate" else []
    assert parameters[: len(context)] == context
    assert set(parameters[len(context) :]) == {option.name for option in command.params}


def test_work_of_sampler_takes_the_options():
    (commands,) = (action for action in _parser()._actions if action.dest == "command")
    assert set(commands.choices) == {"draw", "export", "list"}
    for name, parser in commands.choices.items():
        run = importlib.import_module(f"sampler.commands.{name}_command").run
        options = {action.dest for action in parser._actions} - {"help"}
        assert set(inspect.signature(run).parameters) == options
