"""What starts quickly imports little: what each program and package brings in is listed.

Not timed, because a busy machine would fail. All steps run in one process, lightest first, and a
package counts for the step that brings it in.
"""

import json
import os
import subprocess
import sys

import pytest
from command_lines import PROGRAMS
from documents import ROOT

#: Packages that take a tenth of a second or more, or that a help page has no use for.
HEAVY = ("distributed", "h5py", "llvmlite", "matplotlib", "mpi4py", "numba", "numpy")
HEAVY += ("pydantic", "scipy", "sklearn", "threadpoolctl", "tqdm", "trimesh")

PAGES = [*PROGRAMS, *(f"{name} {c}" for name, cli in PROGRAMS.items() for c in cli.commands)]

#: Commands that look at files and draw nothing.
FILES_ONLY = (
    "sampler list",
    "sampler export corundum-steel-compact --output image.rbt",
    "tablegen inspect corundum-steel",
)

#: What each step may bring in, lightest first: packages without their programs not even click.
ALLOWED = {
    **{name: set() for name in ("sampler", "tablegen")},
    **{f"{name} --version": {"click"} for name in PROGRAMS},
    **{f"{page} --help": {"click"} for page in PAGES},
    **{line: {"numpy", "h5py"} for line in FILES_ONLY},
}

#: Shows that the list is not blind; comes last.
EVERYTHING = "from tablegen import simulate, validate"

SCRIPT = """
import contextlib, importlib, io, json, sys
imported, before = {}, set()
def step(name, action):
    global before
    with contextlib.redirect_stdout(io.StringIO()), contextlib.suppress(SystemExit):
        action()
    now = {module.partition(".")[0] for module in sys.modules}
    imported[name] = sorted((now - before) & {"click", *%(heavy)r})
    before = now
def run(line):
    program, *words = line.split()
    programs = {"sampler": "sampler.cli", "tablegen": "tablegen.commands.main"}
    module = importlib.import_module(programs[program] if words else program)
    if words:
        module.main(words)
for line in %(lines)r:
    step(line, lambda: run(line))
step(%(everything)r, lambda: exec(%(everything)r, {}))
print(json.dumps(imported))
"""


@pytest.fixture(scope="module")
def brought_in(tmp_path_factory):
    """Heavy packages that each step was the first to import."""
    values = {"heavy": HEAVY, "lines": [*ALLOWED], "everything": EVERYTHING}
    path = os.pathsep.join(filter(None, [str(ROOT), os.environ.get("PYTHONPATH")]))
    words = [sys.executable, "-c", SCRIPT % values]
    folder, environment = tmp_path_factory.mktemp("startup"), os.environ | {"PYTHONPATH": path}
    return json.loads(subprocess.check_output(words, cwd=folder, env=environment, text=True))


@pytest.mark.parametrize("step", ALLOWED)
def test_a_step_imports_no_more_than_it_may(step, brought_in):
    assert set(brought_in[step]) <= ALLOWED[step]


def test_files_are_read_and_work_is_imported(brought_in):
    assert {name for step in ALLOWED for name in brought_in[step]} == {"click", "numpy", "h5py"}
    assert {"numba", "scipy", "sklearn", "pydantic", "tqdm"} <= set(brought_in[EVERYTHING])
