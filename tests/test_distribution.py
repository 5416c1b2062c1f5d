"""The source distribution and the wheel are whole: built, installed and used without the checkout.

The wheel is built from the source distribution, as an index would do it, and installed with its
dependencies into fresh environments: one with the generator, one with the runtime alone.
"""

import json
import os
import subprocess
import sys
import tarfile
import venv
import zipfile
from pathlib import Path
from types import SimpleNamespace

import pytest
from documents import ROOT

pytestmark = pytest.mark.study

#: What users need of the package that is no Python file.
DATA = (
    "sampler/_tables/corundum-steel.h5",
    "sampler/_tables/corundum-steel.toml",
    "sampler/_tables/demo.toml",
    "sampler/_tables/FORMAT.md",
    "sampler/_tables/LAWS.md",
    "sampler/_tables/MEASUREMENTS.md",
    "sampler/_tables/measurements/grant-tabakoff-1975.csv",
    "sampler/c/rebound_sampler.h",
    "sampler/fortran/rebound_sampler.f90",
    "sampler/c/README.md",
    "sampler/code_saturne/README.md",
    "sampler/code_saturne/install.sh",
    "sampler/code_saturne/src/rebound_wall.c",
    "sampler/code_saturne/src/rebound_wall.cfg",
    "sampler/openfoam/README.md",
    "sampler/openfoam/bend.sh",
    "sampler/openfoam/build.sh",
    "sampler/openfoam/plugin/TabulatedRebound.C",
    "sampler/openfoam/plugin/Make/files",
    "sampler/openfoam/cases/bend/system/controlDict",
    "sampler/librebound.so",
    "sampler/py.typed",
    "tablegen/evidence/templates/page.html.j2",
)

#: What the sources have besides the packages.
SOURCES = (
    "README.md",
    "CHANGELOG.md",
    "CITATION.cff",
    "CONTRIBUTING.md",
    "LICENSE",
    "pyproject.toml",
    "docs/method.md",
    "docs/examples/wall_laws.py",
    "tables/corundum-steel.h5",
    "tests/conftest.py",
    "tests/data/direct.json",
    "tests/vectors/full.h5",
)


def without_checkout():
    hidden = {"PYTHONPATH", "PYTHONHOME", "NUMBA_CACHE_DIR", "VIRTUAL_ENV"}
    return {name: value for name, value in os.environ.items() if name not in hidden}


def call(*words, folder, status=0):
    done = subprocess.run(
        [str(word) for word in words],
        cwd=folder,
        env=without_checkout(),
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == status, done.stdout[-2000:] + done.stderr[-2000:]
    return done.stderr if status else done.stdout


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    pytest.importorskip("build")
    folder = tmp_path_factory.mktemp("dist")
    call(sys.executable, "-m", "build", "--outdir", folder, ROOT, folder=folder)
    (wheel,), (source,) = folder.glob("*.whl"), folder.glob("*.tar.gz")
    return SimpleNamespace(wheel=wheel, source=source)


def environment(folder, requirement):
    """Folder of the programs of a fresh environment that has a requirement, and one to work in."""
    venv.create(folder / "environment", with_pip=True)
    programs = folder / "environment" / "bin"
    call(programs / "python", "-m", "pip", "install", "--quiet", requirement, folder=folder)
    work = folder / "work"
    work.mkdir()
    return SimpleNamespace(programs=programs, work=work)


@pytest.fixture(scope="module")
def installed(built, tmp_path_factory):
    return environment(tmp_path_factory.mktemp("clean"), f"{built.wheel}[generate]")


@pytest.fixture(scope="module")
def light(built, tmp_path_factory):
    return environment(tmp_path_factory.mktemp("light"), built.wheel)


def test_wheel_has_the_data(built):
    with zipfile.ZipFile(built.wheel) as wheel:
        names = set(wheel.namelist())
    assert not set(DATA) - names
    # and nothing that belongs to developers or to a machine
    tops = {name.split("/")[0] for name in names}
    assert {top for top in tops if not top.endswith(".dist-info")} == {"sampler", "tablegen"}
    assert not [name for name in names if name.endswith((".pyc", ".nbi"))]


def test_sources_are_whole(built):
    with tarfile.open(built.source) as archive:
        names = {str(Path(*Path(name).parts[1:])) for name in archive.getnames()}
    assert not set(SOURCES) - names
    pages = {str(path.relative_to(ROOT)) for path in (ROOT / "docs").glob("*.*")}
    assert not pages - names


def test_library_works_elsewhere(installed):
    told = call(
        installed.programs / "python",
        "-c",
        "import sampler, tablegen\n"
        "table = sampler.load('corundum-steel')\n"
        "print(sampler.__file__, sampler.__version__)\n"
        "print(table.sample(0.5, 150.0, seed=1, index=range(3)).shape)\n",
        folder=installed.work,
    )
    place, shape = told.splitlines()
    assert place.startswith(str(installed.programs.parent))
    assert shape == "(3, 6)"


def test_the_generator_works_elsewhere(installed):
    words = ("tablegen", "inspect", "corundum-steel", "--json")
    facts = call(installed.programs / words[0], *words[1:], folder=installed.work)
    assert json.loads(facts)["pair"] == "corundum-steel"


def test_sources_for_other_languages_are_found(installed):
    words = ("-m", "sampler", "--include-dir")
    folder = Path(call(installed.programs / "python", *words, folder=installed.work).strip())
    assert folder.is_relative_to(installed.programs.parent)
    for name in ("rebound_sampler.h", "rebound_sampler.f90", "../openfoam/build.sh"):
        assert (folder / name).is_file()
    assert os.access(folder / "../openfoam/build.sh", os.X_OK)


def test_a_light_installation_has_the_runtime_only(light):
    words = ("-m", "pip", "list", "--format=json")
    listed = json.loads(call(light.programs / "python", *words, folder=light.work))
    names = {package["name"] for package in listed} - {"pip", "setuptools", "rebound-tables"}
    assert names == {"click", "h5py", "lazy-loader", "numpy", "packaging"}


def test_a_light_installation_draws_exports_and_lists(light):
    for line in (
        "draw corundum-steel --alpha 30 --speed 150 --count 10 --seed 1 --output states.npz",
        "export corundum-steel --output corundum-steel.rbt",
    ):
        call(light.programs / "sampler", *line.split(), folder=light.work)
    assert {path.name for path in light.work.iterdir()} == {"states.npz", "corundum-steel.rbt"}
    assert "corundum-steel-compact" in call(light.programs / "sampler", "list", folder=light.work)


@pytest.mark.parametrize("words", [("tablegen", "demo"), ("python", "-m", "tablegen", "--help")])
def test_a_light_installation_names_what_the_generator_needs(light, words):
    program, *rest = words
    before = set(light.work.iterdir())
    said = call(light.programs / program, *rest, folder=light.work, status=2)
    assert said.startswith("tablegen: error: the generator is not installed, allowed after: pip ")
    assert said.count("\n") == 1
    assert set(light.work.iterdir()) == before
