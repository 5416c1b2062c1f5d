"""What the runtime imports: numpy, numba, h5py and the standard library.

numba looks at scipy's version where scipy is installed, so "scipy is not in sys.modules" cannot
hold there. What must hold: the runtime brings in nothing beyond numba's own imports, and works
where the other packages cannot be imported at all.
"""

import subprocess
import sys

import pytest

FOREIGN = ("scipy", "sklearn", "matplotlib", "tablegen", "pydantic", "click", "tqdm")

BLOCKED_DRAW = """
import sys
for name in {names}:
    sys.modules[name] = None  # importing it now raises ImportError
import sampler, sampler.cli
print(sampler.load({path!r}).sample(0.5, 100.0, seed=1).shape)
"""


def _run(code):
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)


def _foreign(statement):
    run = _run(f"import sys; {statement}; print(*sys.modules)")
    assert run.returncode == 0, run.stderr
    return {name for name in run.stdout.split() if name.partition(".")[0] in FOREIGN}


def test_nothing_beyond_the_three():
    below = _foreign("import numpy, numba, h5py")
    assert _foreign("import sampler, sampler.cli") == below
    assert _foreign("import sampler, scipy.special") > below  # or the comparison is blind


def test_draws_where_nothing_else_can_be_imported(table_path):
    run = _run(BLOCKED_DRAW.format(names=FOREIGN, path=str(table_path)))
    assert run.stdout == "(1, 6)\n", run.stderr


@pytest.mark.parametrize("name", ["numba", "h5py"])
def test_blocking_does_block(table_path, name):
    run = _run(BLOCKED_DRAW.format(names=(name,), path=str(table_path)))
    assert run.returncode != 0
    assert name in run.stderr
