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


def test_an_edit_of_a_called_function_reaches_its_callers(tmp_path):
    """Numba's own cache would go on with the old machine code."""
    root = jit._ROOT
    for name in ("tablegen", "sampler"):
        subprocess.run(["cp", "-r", root / name, tmp_path], check=True)
    script = (
        "from tablegen.model.tumbling import axes_of_tumbling as f\n"
        "print(f((0.1, 0.2, 0.3), 0.25, (0.0, 0.0, 1.0), (0.1, 0.2, 0.3)))"
    )

    def run():
        command = [sys.executable, "-c", script]
        environment = {"PYTHONPATH": str(tmp_path), "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
        ended = subprocess.run(
            command, env=environment, cwd=tmp_path, capture_output=True, text=True, check=True
        )
        match = re.fullmatch(
            r"compiling the .*\ncompiled axes_of_tumbling in \d+\.\d s\n", ended.stderr
        )
        return ended.stdout, match is not None

    before, compiled = run()
    assert compiled
    assert run() == (before, False)
    callee = tmp_path / "tablegen" / "model" / "vectors.py"
    callee.write_text(callee.read_text().replace("combine(cosine, zero", "combine(sine, zero"))
    after, compiled = run()
    assert compiled
    assert after != before
