"""Without the packages of an extra, what needs them names the extra in one line."""

import tomllib
from importlib.metadata import packages_distributions
from types import SimpleNamespace

import pytest
from documents import ROOT

import tablegen
from tablegen.commands.main import main
from tablegen.config import requirements

LINE = "the generator is not installed, allowed after: pip install 'rebound-tables[generate]'"
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
EXTRAS = PROJECT["optional-dependencies"]


@pytest.fixture
def without(monkeypatch):
    """Hide a package from the check."""

    def hide(name):
        def find(asked):
            return None if asked == name else SimpleNamespace(name=asked)

        monkeypatch.setattr(requirements, "find_spec", find)

    return hide


@pytest.mark.parametrize("name", requirements.GENERATOR)
def test_the_program_names_the_extra(name, without, capsys):
    without(name)
    assert main(["--help"]) == 2
    assert capsys.readouterr() == ("", f"tablegen: error: {LINE}\n")


def test_the_package_names_the_extra(without, monkeypatch):
    _ = tablegen.simulate  # or there is nothing to take away
    monkeypatch.delitem(tablegen.__dict__, "simulate")
    without("pydantic")
    with pytest.raises(ImportError) as refused:
        _ = tablegen.simulate
    assert str(refused.value) == LINE
    assert refused.value.name == "pydantic"


def test_with_everything_the_program_runs(without, capsys):
    without("none of them")
    assert main(["--version"]) == 0
    assert capsys.readouterr().out.startswith("tablegen, version ")


def names_of(requirements):
    return {requirement.partition(">")[0] for requirement in requirements}


def test_the_check_is_of_the_packages_that_the_extra_brings():
    brought = packages_distributions()
    checked = {
        name.lower().replace("_", "-")
        for import_name in requirements.GENERATOR
        for name in brought[import_name]
    }
    assert names_of(EXTRAS["generate"]) == checked


def test_the_runtime_brings_its_three_the_compiler_and_the_command_line():
    assert names_of(PROJECT["dependencies"]) == {"click", "h5py", "llvmlite", "numba", "numpy"}


@pytest.mark.parametrize("name", ["plot", "report", "dask", "mpi", "docs"])
def test_every_extra_brings_the_generator(name):
    """One word after pip install is enough for a program that works."""

    def all_of(name):
        found = set()
        for requirement in EXTRAS[name]:
            if requirement.startswith("rebound-tables["):
                inner = requirement.partition("[")[2].rstrip("]").split(",")
                found |= set().union(*({part} | all_of(part) for part in inner))
        return found

    assert "generate" in all_of(name)
