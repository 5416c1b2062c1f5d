"""Public names are imported late, and are the same whatever was imported before."""

import ast
import importlib
import itertools
import pickle
import sys
from types import ModuleType

import numba
import pytest
from documents import ROOT
from sampler.compilation.late import import_late

import sampler
import tablegen

PACKAGES = (sampler, tablegen)
every_package = pytest.mark.parametrize("package", PACKAGES, ids=lambda package: package.__name__)


def checkers_imports(package):
    """Where type checkers are told that the names come from."""
    source = (ROOT / package.__name__ / "__init__.py").read_text(encoding="utf-8")
    (block,) = (node for node in ast.parse(source).body if isinstance(node, ast.If))
    return {alias.asname: node.module for node in block.body for alias in node.names}


@every_package
def test_type_checkers_and_programs_get_the_same_names(package):
    told = checkers_imports(package)
    assert sorted(told) == sorted(package.__all__)
    for name, module in told.items():
        assert package._homes[name] == module
        assert getattr(package, name) is getattr(importlib.import_module(module), name)


@every_package
def test_names_are_listed_and_others_refused(package):
    assert set(package.__all__) <= set(dir(package))
    assert not hasattr(package, "nothing")
    with pytest.raises(AttributeError, match=f"module '{package.__name__}' has no .* 'nothing'"):
        _ = package.nothing
    with pytest.raises(ImportError, match="cannot import name 'nothing'"):
        exec(f"from {package.__name__} import nothing")


@pytest.mark.parametrize("name", ["generate", "simulate", "validate"])
def test_functions_stay_functions_beside_modules_of_their_names(name):
    module = importlib.import_module(f"tablegen.{name}")
    assert isinstance(module, ModuleType)
    function = getattr(tablegen, name)
    assert callable(function)
    assert function is getattr(module, name)


def test_modules_are_found_as_attributes():
    assert sampler.drawing.frames is sys.modules["sampler.drawing.frames"]


def test_classes_can_be_pickled():
    assert pickle.loads(pickle.dumps(sampler.Table)) is sampler.Table


#: Statements after which `job` of the package must be the function, in any order.
STATEMENTS = (
    "import made.job",
    "from made.job import job",
    "from made import job",
    "import made.other",
    "import made; made.job",
)


@pytest.fixture
def made(tmp_path, monkeypatch):
    """A package with a module and a function of one name, another module that imports it."""
    folder = tmp_path / "made"
    folder.mkdir()
    (folder / "__init__.py").write_text(
        "from sampler.compilation.late import import_late\n"
        "import_late(__name__, {'made.job': ('job',)})\n"
    )
    (folder / "job.py").write_text("def job():\n    return 'done'\n")
    (folder / "other.py").write_text("from made.job import job\nimport missing_package\n")
    monkeypatch.syspath_prepend(tmp_path)
    yield "made"
    for name in [name for name in sys.modules if name.partition(".")[0] == "made"]:
        del sys.modules[name]


@pytest.mark.parametrize("order", [*itertools.permutations(STATEMENTS, 2)], ids=" then ".join)
def test_a_function_wins_over_its_module_in_every_order(order, made, monkeypatch):
    monkeypatch.setitem(sys.modules, "missing_package", ModuleType("missing_package"))
    for statement in order:
        exec(statement, {})
    assert importlib.import_module(made).job() == "done"
    assert isinstance(sys.modules["made.job"], ModuleType)


def test_a_plain_package_would_get_the_module(made, tmp_path):
    """Or the orders above would show nothing."""
    (tmp_path / "made" / "__init__.py").write_text("from made.job import job\n")
    importlib.import_module(made)
    assert callable(sys.modules[made].job)
    del sys.modules["made.job"]
    importlib.import_module("made.job")
    assert isinstance(sys.modules[made].job, ModuleType)


def test_star_imports_every_name(made):
    names = {}
    exec("from made import *", names)
    assert names["job"]() == "done"


def test_compiled_code_finds_a_name_through_its_package(made, tmp_path):
    (tmp_path / "made" / "job.py").write_text(
        "import numba\n\n\n@numba.njit\ndef job():\n    return 7\n"
    )
    package = importlib.import_module(made)
    assert "job" not in package.__dict__
    assert numba.njit(lambda: package.job())() == 7


def test_what_a_module_lacks_is_said_and_not_taken_for_a_missing_module(made):
    package = importlib.import_module(made)
    with pytest.raises(ModuleNotFoundError, match="missing_package"):
        _ = package.other


def test_a_package_may_refuse_its_names(made):
    def refuse():
        raise ImportError("needs more")

    package = importlib.import_module(made)
    import_late(made, {"made.job": ("job",)}, refuse)
    with pytest.raises(ImportError, match="needs more"):
        _ = package.job
