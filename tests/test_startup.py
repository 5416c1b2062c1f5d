"""What starts quickly imports little: what each program and package brings in is listed.

Not timed, because a busy machine would fail. All steps run in one process, lightest first, and a
package counts for the step that brings it in.
"""

import json
import os
import subprocess
import sys

import pytest
from documents import ROOT

from tablegen.commands.main import cli

#: Packages that take a tenth of a second or more, or that a help page has no use for.
HEAVY = (
    "distributed",
    "h5py",
    "llvmlite",
    "matplotlib",
    "mpi4py",
    "numba",
    "numpy",
    "plotly",
    "pydantic",
    "scipy",
    "sklearn",
    "threadpoolctl",
    "tqdm",
    "trimesh",
)

PACKAGES = ("sampler", "tablegen")
TABLEGEN = ((), *((name,) for name in sorted(cli.commands)))
SAMPLER = ((), ("draw",), ("export",), ("list",))
HELP_PAGES = [" ".join(("tablegen", *path)) for path in TABLEGEN]
HELP_PAGES += [" ".join(("sampler", *path)) for path in SAMPLER]

#: Commands that look at files and draw nothing.
FILES_ONLY = (
    "sampler list",
    "sampler export corundum-steel-compact --output image.rbt",
    "tablegen list --json",
    "tablegen export corundum-steel-compact --output image.rbt",
    "tablegen inspect corundum-steel",
    "tablegen inspect corundum-steel --json",
)

#: Shows that the list is not blind; comes last.
EVERYTHING = "from tablegen import simulate, validate"

PROGRAM = """
import contextlib, importlib, io, json, sys
found, before = {}, set()
def step(name, action):
    global before
    with contextlib.redirect_stdout(io.StringIO()), contextlib.suppress(SystemExit):
        action()
    now = {module.partition(".")[0] for module in sys.modules}
    found[name] = sorted((now - before) & set(%(heavy)r))
    before = now
def run(line):
    program, *words = line.split()
    modules = {"sampler": "sampler.commands.main", "tablegen": "tablegen.commands.program"}
    importlib.import_module(modules[program]).main(words)
for name in %(packages)r:
    step(name, lambda: importlib.import_module(name))
for line in %(lines)r:
    step(line, lambda: run(line))
step(%(everything)r, lambda: exec(%(everything)r, {}))
print(json.dumps(found))
"""


@pytest.fixture(scope="module")
def brought_in(tmp_path_factory):
    """Heavy packages that each step was the first to import."""
    lines = [f"{program} --version" for program in PACKAGES]
    lines += [f"{page} --help" for page in HELP_PAGES]
    values = {
        "heavy": HEAVY,
        "packages": PACKAGES,
        "lines": [*lines, *FILES_ONLY],
        "everything": EVERYTHING,
    }
    path = os.pathsep.join(filter(None, [str(ROOT), os.environ.get("PYTHONPATH")]))
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM % values],
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path_factory.mktemp("startup"),
        env=os.environ | {"PYTHONPATH": path},
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.parametrize("step", [*PACKAGES, *(f"{program} --version" for program in PACKAGES)])
def test_packages_and_versions_import_nothing_heavy(step, brought_in):
    assert brought_in[step] == []


@pytest.mark.parametrize("page", HELP_PAGES)
def test_help_imports_nothing_heavy(page, brought_in):
    assert brought_in[f"{page} --help"] == []


@pytest.mark.parametrize("line", FILES_ONLY)
def test_commands_that_draw_nothing_compile_nothing(line, brought_in):
    assert set(brought_in[line]) <= {"numpy", "h5py"}


def test_files_are_read_and_work_is_imported(brought_in):
    read = {name for line in FILES_ONLY for name in brought_in[line]}
    assert read == {"numpy", "h5py"}
    assert {"numba", "scipy", "sklearn", "pydantic", "tqdm"} <= set(brought_in[EVERYTHING])
