"""Without the packages of an extra, one line says how to install them."""

import tomllib
from importlib.metadata import packages_distributions

import pytest
from documents import ROOT

import tablegen
from tablegen import config
from tablegen.commands.main import main

LINE = "the generator is not installed; run: pip install 'rebound-tables[generate]'"
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


@pytest.mark.parametrize("name", config.GENERATOR)
def test_the_program_and_the_package_name_the_extra(name, monkeypatch, capsys):
    _ = tablegen.simulate  # or there is nothing to take away
    monkeypatch.delitem(tablegen.__dict__, "simulate", raising=False)
    monkeypatch.setattr(config, "find_spec", lambda asked: None if asked == name else asked)
    assert main(["--help"]) == 2
    assert capsys.readouterr() == ("", f"tablegen: error: {LINE}\n")
    with pytest.raises(ImportError) as refused:
        _ = tablegen.simulate
    assert (str(refused.value), refused.value.name) == (LINE, name)


def test_the_check_is_of_the_packages_that_the_extra_brings():
    brought = packages_distributions()
    checked = {brought[name][0].lower().replace("_", "-") for name in config.GENERATOR}
    assert {
        line.partition(">")[0] for line in PROJECT["optional-dependencies"]["generate"]
    } == checked
