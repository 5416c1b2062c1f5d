"""Modules and files that configuration files, scripts, comments and pages name exist."""

import re
import tomllib
from importlib.util import find_spec

from documents import ROOT

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))

#: Files that a build makes.
MADE = ("sampler/c/rebound_sampler.h",)

#: A path from the root of the repository to a file: the folder is one of ours.
_PATH = re.compile(
    r"(?<![\w/.$}-])((?:docs|sampler|tablegen|tables|tests|tools|\.ci)/(?:[\w.-]+/)*[\w-]+\.(?:py|md|h|c|cu|f90|h5|toml|csv|sh|png|C|H|j2))\b"
)


def files_named(text):
    """Paths of files of this repository that a text names."""
    return sorted(set(_PATH.findall(text)))


def missing_files(text):
    return [path for path in files_named(text) if path not in MADE and not (ROOT / path).exists()]


def modules_named(project):
    """First-party modules that tools are configured with."""
    tools = project["tool"]
    names = [name for override in tools["mypy"]["overrides"] for name in override["module"]]
    names += [script.partition(":")[0] for script in project["project"]["scripts"].values()]
    for contract in tools["importlinter"]["contracts"]:
        names += contract.get("source_modules", []) + contract.get("forbidden_modules", [])
        for pair in contract.get("ignore_imports", []):
            names += pair.split(" -> ")
        for container in contract.get("containers", []):
            rooms = contract.get("exhaustive_ignores", [])
            rooms = rooms + re.findall(r"\w+", " ".join(contract["layers"]))
            names += [f"{container}.{room}" for room in rooms]
    ours = (name.removesuffix(".*") for name in names)
    return sorted({name for name in ours if name.partition(".")[0] in ("sampler", "tablegen")})


def exists(module):
    # sampler/c is a folder of sources, no package
    folder = ROOT.joinpath(*module.split("."))
    try:
        return folder.is_dir() or find_spec(module) is not None
    except ModuleNotFoundError:  # of a parent
        return False


def test_modules_in_pyproject_exist():
    names = modules_named(PROJECT)
    assert len(names) > 30
    assert [name for name in names if not exists(name)] == []
    assert not exists("tablegen.nowhere.module")


def test_paths_in_pyproject_exist():
    tools = PROJECT["tool"]
    hatch = tools["hatch"]["build"]["targets"]
    paths = [PROJECT["project"]["readme"], *PROJECT["project"]["license-files"]]
    paths += [tools["hatch"]["version"]["path"], *hatch["wheel"]["packages"]]
    paths += [*hatch["wheel"]["force-include"], hatch["wheel"]["hooks"]["custom"]["path"]]
    paths += [path.removeprefix("/") for path in hatch["sdist"]["include"]]
    paths += [*tools["mypy"]["exclude"], *tools["pytest"]["ini_options"]["testpaths"]]
    assert [path for path in paths if not (ROOT / path).exists()] == []
    for pattern in tools["ruff"]["lint"]["per-file-ignores"]:
        folders, end = re.fullmatch(r"(?:\{(.*)\})?(.*)", pattern).groups("")
        for folder in folders.split(","):
            assert any(ROOT.glob(folder + end)), pattern


SUFFIXES = (".md", ".py", ".pyi", ".toml", ".h", ".c", ".cu", ".f90", ".C", ".H", ".sh")
FOLDERS = ("docs", "sampler", "tablegen", "tables", "tests", "tools", ".ci")


def texts_of_the_repository():
    paths = [path for folder in FOLDERS for path in (ROOT / folder).rglob("*") if path.is_file()]
    paths = [path for path in paths if path.suffix in SUFFIXES or path.parent.name == ".ci"]
    paths += [*ROOT.glob("*.md"), ROOT / "pyproject.toml", ROOT / "CITATION.cff"]
    return {path: path.read_text(encoding="utf-8") for path in paths}


def test_files_that_code_comments_and_pages_name_exist():
    texts = texts_of_the_repository()
    assert sum(len(files_named(text)) for text in texts.values()) > 50
    missing = {path: missing_files(text) for path, text in texts.items()}
    assert {str(path): names for path, names in missing.items() if names} == {}
