"""Machine code on disk: kept once, never that of other sources, and never a reason to fail."""

import re
import subprocess
import sys

import pytest
from numba.core import config

from tablegen.model import jit
from tablegen.model.jit import kernel


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Empty folder of the cache, and a log that has not said anything yet."""
    monkeypatch.setattr(config, "CACHE_DIR", str(tmp_path / "cache"))
    jit._log_once.cache_clear()
    return jit.cache_folder()


def _twice(x):
    return x + x


def comes_from_disk():
    compiled = kernel(_twice)
    assert compiled(3.0) == 6.0
    return sum(compiled.stats.cache_hits.values()) == 1


def test_a_kernel_is_compiled_once(folder):
    assert [comes_from_disk(), comes_from_disk()] == [False, True]
    (path,) = folder.iterdir()
    path.write_bytes(b"")
    assert [comes_from_disk(), comes_from_disk()] == [False, True]


def test_a_kernel_in_another_has_no_machine_code_of_its_own(folder):
    inner = kernel(_twice)
    outer = kernel(lambda x: inner(x) + 1.0)
    assert outer(3.0) == 7.0
    assert (len(outer.overloads), len(inner.overloads)) == (1, 0)
    assert len([*folder.iterdir()]) == 1
    assert inner(3.0) == 6.0
    assert len([*folder.iterdir()]) == 2


def test_the_oldest_folders_of_other_sources_are_removed(folder):
    for k in range(9):
        (folder.parent / f"tablegen-{k}").mkdir(parents=True)
    comes_from_disk()
    assert len([*folder.parent.iterdir()]) == 8


def test_where_nothing_can_be_written_one_line_is_logged(folder, caplog):
    folder.parent.write_text("a file where the folder would be")
    assert [comes_from_disk(), comes_from_disk()] == [False, False]
    (line,) = caplog.messages
    assert line.startswith("compiled kernels cannot be kept, set NUMBA_CACHE_DIR to a folder: ")


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
        told = re.fullmatch(
            r"compiling the .*\ncompiled proposed_score in \d+\.\d s\n", ended.stderr
        )
        return ended.stdout, told is not None

    before, compiled = run()
    assert compiled
    assert run() == (before, False)
    callee = tmp_path / "tablegen" / "model" / "random_numbers.py"
    callee.write_text(callee.read_text().replace("0.5 * math.erfc", "0.25 * math.erfc"))
    after, compiled = run()
    assert compiled
    assert after != before
