"""Machine code on disk: it is stored once, never used for other sources, and never fails a run."""

import errno
import re
import subprocess
import sys

import pytest
from numba.core import config
from numba.core.caching import IndexDataCacheFile

from tablegen.model import jit
from tablegen.model.jit import kernel


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Empty folder of the cache."""
    monkeypatch.setattr(config, "CACHE_DIR", str(tmp_path / "cache"))
    jit._can_be_written.cache_clear()
    monkeypatch.setattr(jit, "_WRITE_FAILURES", set())
    return jit.cache_folder()


def _twice(x):
    return x + x


def comes_from_disk():
    compiled = kernel(_twice)
    assert compiled(3.0) == 6.0
    return sum(compiled.stats.cache_hits.values()) == 1


def test_a_kernel_is_compiled_once(folder):
    assert [comes_from_disk(), comes_from_disk()] == [False, True]


def test_a_kernel_in_another_has_no_machine_code_of_its_own(folder):
    inner = kernel(_twice)
    outer = kernel(lambda x: inner(x) + 1.0)
    assert outer(3.0) == 7.0
    assert (len(outer.overloads), len(inner.overloads)) == (1, 0)
    assert inner(3.0) == 6.0


def test_the_oldest_folders_of_other_sources_are_removed(folder):
    for k in range(9):
        (folder.parent / f"tablegen-{k}").mkdir(parents=True)
    kernel(_twice)
    assert len([*folder.parent.iterdir()]) == 8


def test_where_nothing_can_be_written_one_line_is_logged(folder, caplog):
    folder.parent.write_text("a file where the folder would be")
    assert [comes_from_disk(), comes_from_disk()] == [False, False]
    (line,) = caplog.messages
    assert line.startswith("compiled kernels cannot be kept, set NUMBA_CACHE_DIR to a folder with ")


def test_a_full_disk_fails_no_kernel_and_is_logged_once(folder, caplog, monkeypatch):
    def fail(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(IndexDataCacheFile, "save", fail)
    assert [comes_from_disk(), comes_from_disk()] == [False, False]
    (line,) = caplog.messages
    assert line.endswith("with space: [Errno 28] No space left on device")
    assert not jit.kernels_are_kept()


_KERNELS = """
import numpy as np
from tablegen.model.roughness import draw_tilt, mark_leaving
leaving = np.empty(2, dtype=np.bool_)
mark_leaving(np.array([[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]]), np.array([[0.0, 2.0, 0.0]]), leaving)
result = draw_tilt(0.3, 0.2, (np.uint64(1), np.uint64(2), np.uint32(3))), *leaving.astype(float)
"""

_REBOUNDS = """
from tablegen.config.config import load_config
from tablegen.simulation.direct import DirectModel
model = DirectModel(load_config("corundum-steel"))
result = model.sample(0.3, 90.0, spin=[0.1, 0, 0.5], seed=1, index=range(99), hit=1).ravel()
"""

#: What another version of numba may bring, and a private name that it may lack.
_CHANGES = [
    "import numba; numba.version_info = numba.version_info._replace(short=(0, 99))",
    "import numba.core.codegen; del numba.core.codegen.JITCodeLibrary",
]


@pytest.mark.parametrize("change", _CHANGES)
@pytest.mark.parametrize(
    "script",
    [_KERNELS, pytest.param(_REBOUNDS, marks=pytest.mark.study)],  # which compiles half a minute
)
def test_without_private_names_of_numba_the_bits_are_the_same(tmp_path, script, change):
    usual = {}
    exec(script, usual)
    end = "from tablegen.model import jit\nassert jit.parts is None\nprint(*map(float.hex, result))"
    ended = subprocess.run(
        [sys.executable, "-c", f"{change}\n{script}\n{end}"],
        env={"PYTHONPATH": str(jit._ROOT), "NUMBA_CACHE_DIR": str(tmp_path)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert ended.stdout.split() == [float(x).hex() for x in usual["result"]]


def test_an_edit_of_a_called_function_reaches_its_callers(tmp_path):
    """Numba's own cache would go on with the old machine code."""
    root = jit._ROOT
    for name in ("tablegen", "sampler"):
        subprocess.run(["cp", "-r", root / name, tmp_path], check=True)
    script = (
        "from tablegen.model.roughness import proposed_score as f; print(f(1.0, 0.1, 0.5, 0.5))"
    )

    def run():
        command = [sys.executable, "-c", script]
        environment = {"PYTHONPATH": str(tmp_path), "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
        ended = subprocess.run(
            command, env=environment, cwd=tmp_path, capture_output=True, text=True, check=True
        )
        match = re.fullmatch(
            r"compiling the .*\ncompiled proposed_score in \d+\.\d s\n", ended.stderr
        )
        return ended.stdout, match is not None

    before, compiled = run()
    assert compiled
    assert run() == (before, False)
    callee = tmp_path / "tablegen" / "model" / "random_numbers.py"
    callee.write_text(callee.read_text().replace("0.5 * math.erfc", "0.25 * math.erfc"))
    after, compiled = run()
    assert compiled
    assert after != before
