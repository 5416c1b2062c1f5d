"""What the runtime imports: numpy, h5py, lazy_loader and the standard library; commands also click.

`sampler.numba`, for draws in one's own compiled code, is the only module that imports numba.
"""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import sampler

#: Folder of the package that is tested: the sources, or where a wheel is installed.
ROOT = Path(sampler.__file__).resolve().parents[1]

RUNTIME = ("numpy", "h5py", "lazy_loader", "sampler")

#: Modules of the command line, for numba, and of the installation.
OTHERS = {"sampler.cli", "sampler.options", "sampler.numba"}
NAMES = [
    ".".join(path.relative_to(ROOT).with_suffix("").parts)
    for path in sorted((ROOT / "sampler").rglob("*.py"))
    if path.parent.name != "c" and not path.stem.startswith("_")
]
ALL_MODULES = "import " + ", ".join(name for name in NAMES if name not in OTHERS)

#: Packages that are not named here are not found, as if they were not installed.
ALONE = """
import sys
class Only:
    def __init__(self, finder):
        self.finder = finder
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {*sys.stdlib_module_names, *%r}:
            return self.finder.find_spec(name, path, target)
sys.meta_path[:] = map(Only, sys.meta_path)
"""

DRAW = f"""
{ALL_MODULES}
assert sampler.load("PATH").sample(0.5, 100.0, seed=1, index=[0]).shape == (1, 6)
"""

COMMANDS = """
from sampler.cli import main
flags = ["--alpha", "30", "--speed", "100", "--count", "5", "--seed", "1", "--output"]
assert main(["draw", "PATH", *flags, "a.npz"]) == 0
assert main(["export", "PATH", "--output", "a.rbt"]) == 0
assert main(["list"]) == 0
"""


@pytest.mark.parametrize(
    ("packages", "work", "files"),
    [(RUNTIME, DRAW, []), ((*RUNTIME, "click"), COMMANDS, ["a.npz", "a.rbt"])],
    ids=["library", "commands"],
)
def test_works_where_nothing_else_is_installed(table_path, tmp_path, packages, work, files):
    code = (ALONE % (packages,) + work).replace("PATH", str(table_path))
    path = os.pathsep.join(filter(None, [str(ROOT), os.environ.get("PYTHONPATH")]))
    words, environment = [sys.executable, "-c", code], os.environ | {"PYTHONPATH": path}
    run = subprocess.run(words, capture_output=True, text=True, cwd=tmp_path, env=environment)
    assert run.returncode == 0, run.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == files
