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

#: Simulates as a user without a name in the system, and so without a home.
NOBODY = """
import pwd, sys
from tablegen.commands.main import main
def unknown(uid):
    raise KeyError(uid)
pwd.getpwuid = unknown
sys.exit(main(sys.argv[1:]))
"""


def tracked(*folders):
    words = ["git", "ls-files", *folders]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=True)
    return set(done.stdout.split())


def call(*words, folder, status=0, **variables):
    hidden = {"PYTHONPATH", "PYTHONHOME", "NUMBA_CACHE_DIR", "VIRTUAL_ENV"}
    kept = {name: value for name, value in os.environ.items() if name not in hidden}
    changed = {name: value for name, value in (kept | variables).items() if value is not None}
    words = [str(word) for word in words]
    done = subprocess.run(words, cwd=folder, env=changed, capture_output=True, text=True)
    assert done.returncode == status, done.stdout[-2000:] + done.stderr[-2000:]
    return done.stderr if status else done.stdout


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    pytest.importorskip("build")
    folder = tmp_path_factory.mktemp("dist")
    words = (sys.executable, "-m", "build", "--outdir", folder, ROOT)
    call(*words, folder=folder, PATH=str(folder), CC=None)  # pip fetches a compiler
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


def test_the_wheel_has_every_file_of_the_packages_and_no_other(built):
    with zipfile.ZipFile(built.wheel) as wheel:
        names = {name for name in wheel.namelist() if ".dist-info/" not in name}
    files = tracked("sampler", "tablegen", "tables")
    data = {f"sampler/_{name}" if name.startswith("tables/") else name for name in files}
    made = {"sampler/librebound.so", "sampler/c/rebound_sampler.h", "sampler/LICENSE"}
    assert names == data | made


def test_the_source_distribution_is_whole(built):
    with tarfile.open(built.source) as archive:
        names = {str(Path(*Path(name).parts[1:])) for name in archive.getnames()}
    assert not tracked() - names


def test_the_generator_works_elsewhere(installed):
    place = call(
        installed.programs / "python",
        "-c",
        "import sampler, tablegen; print(sampler.__file__); tablegen.load_config('demo')",
        folder=installed.work,
    )
    assert place.startswith(str(installed.programs.parent))
    words = ("tablegen", "inspect", "corundum-steel", "--json")
    facts = call(installed.programs / words[0], *words[1:], folder=installed.work)
    assert json.loads(facts)["pair"] == "corundum-steel"


@pytest.mark.parametrize("cache", [None, "/dev/null/kernels"])
def test_simulates_without_a_home_or_a_folder_for_kernels(installed, tmp_path, cache):
    words = "simulate --pair kharaz-2001 --alpha 30 --speed 3.9 --count 5 --seed 1 --output r.npz"
    command = installed.programs / "python", "-c", NOBODY, *words.split()
    call(*command, folder=tmp_path, HOME=None, XDG_CACHE_HOME=None, NUMBA_CACHE_DIR=cache)
    assert [path.name for path in tmp_path.iterdir()] == ["r.npz"]


def test_sources_for_other_languages_are_found(installed):
    words = ("-m", "sampler", "--include-dir")
    folder = Path(call(installed.programs / "python", *words, folder=installed.work).strip())
    assert folder.is_relative_to(installed.programs.parent)
    assert (folder / "rebound_sampler.h").is_file()
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


def test_a_light_installation_names_what_the_generator_needs(light):
    before = set(light.work.iterdir())
    line = call(light.programs / "tablegen", "demo", folder=light.work, status=2)
    assert line.startswith("tablegen: error: the generator is not installed; run: pip ")
    assert line.count("\n") == 1
    assert set(light.work.iterdir()) == before
