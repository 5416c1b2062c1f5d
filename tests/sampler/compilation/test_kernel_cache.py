"""Machine code on disk: never that of other sources, and never a reason to fail."""

import ast
import inspect
import logging
import os
import pickle
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numba
import pytest
from numba.core import config
from numba.core.caching import FunctionCache
from sampler.compilation import kernel_cache
from sampler.compilation.jit import kernel
from sampler.compilation.kernel_cache import KEPT, KernelCache, kernel_sources

import sampler

#: Folder of the packages that are tested, installed or not.
ROOT = Path(sampler.__file__).resolve().parents[1]

#: A small kernel of one file that calls kernels of another.
SCORE = "from sampler.drawing.roughness import proposed_score as f; print(f(1.0, 0.1, 0.5, 0.5))"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Where the kernels of this process are kept, and nothing is there yet."""
    monkeypatch.setattr(config, "CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setattr(KernelCache, "_told", False)
    return tmp_path / "cache" / f"rebound-tables-{kernel_cache._IMPORTED}"


def _twice(x):
    return x + x


def hit():
    """Whether a kernel comes from the disk; its result is right either way."""
    compiled = kernel(_twice)
    assert compiled(3.0) == 6.0
    return sum(compiled.stats.cache_hits.values()) == 1


@pytest.fixture
def copied(tmp_path):
    """A copy of the runtime in a folder, as pip puts it there."""
    folder = tmp_path / "site-packages"
    for path in (ROOT / "sampler").rglob("*.*"):
        if path.suffix in (".py", ".npy"):
            target = folder / path.relative_to(ROOT)
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(path, target)
    return folder


def run(copied, script, **environment):
    """Output and log of a script that uses the copy."""
    hidden = ("NUMBA_CACHE_DIR", "HOME", "XDG_CACHE_HOME")
    kept = {name: value for name, value in os.environ.items() if name not in hidden}
    ended = subprocess.run(
        [sys.executable, "-c", script],
        cwd=copied,
        env=kept | {"PYTHONPATH": str(copied), "XDG_CACHE_HOME": os.devnull} | environment,
        capture_output=True,
        text=True,
        check=True,
    )
    return ended.stdout, ended.stderr


def test_a_kernel_is_compiled_once(folder):
    assert [hit(), hit()] == [False, True]
    (path,) = folder.iterdir()
    assert path.match("test_kernel_cache._twice-*.kernel")


def test_an_upgrade_in_place_reaches_kernels_of_other_files(copied):
    before, log = run(copied, SCORE)
    assert "compiling the draw" in log
    assert run(copied, SCORE) == (before, "")
    callee = copied / "sampler" / "drawing" / "normal.py"
    old = callee.read_text(encoding="utf-8")
    callee.write_text(old.replace("0.5 * math.erfc", "0.25 * math.erfc"), encoding="utf-8")
    after, log = run(copied, SCORE)
    assert "compiling the draw" in log
    assert after != before
    # as where nothing was ever kept
    assert after == run(copied, SCORE, NUMBA_CACHE_DIR=str(copied / "new"))[0]
    # and back: the old release is still there
    callee.write_text(old, encoding="utf-8")
    assert run(copied, SCORE) == (before, "")


def test_an_upgrade_under_a_running_process_keeps_nothing_of_it(folder, monkeypatch):
    monkeypatch.setattr(kernel_cache, "_digest", lambda: "0" * 16)
    assert not hit()
    assert not folder.exists()


@pytest.mark.parametrize("module", ["numba", "llvmlite", "np"])
def test_other_versions_are_other_caches(module, monkeypatch):
    assert kernel_cache._digest() == kernel_cache._IMPORTED
    monkeypatch.setattr(getattr(kernel_cache, module), "__version__", "0.0.1")
    assert kernel_cache._digest() != kernel_cache._IMPORTED


_FROM = re.compile(r"^from ((?:sampler|tablegen)[.\w]*) import", re.MULTILINE)
_COMPILES = re.compile(r"^(from|import) (sampler\.compilation\.jit|numba)\b", re.MULTILINE)
_STREAMING = ROOT / "tablegen" / "accuracy" / "streaming_statistics.py"


def test_all_sources_of_kernels_count():
    counted = set(kernel_sources())
    assert ROOT / "sampler" / "formats" / "normal_cubics.npy" in counted
    modules = [p for name in ("sampler", "tablegen") for p in (ROOT / name).rglob("*.py")]
    texts = {path: path.read_text(encoding="utf-8") for path in modules}
    assert {path for path, text in texts.items() if _COMPILES.search(text)} <= counted
    # a module of kernels may take constants from what it imports
    for path in counted & texts.keys() - {_STREAMING}:
        for name in _FROM.findall(texts[path]):
            module = ROOT.joinpath(*name.split("."))
            files = {module.with_suffix(".py"), module / "__init__.py"}
            assert files & counted, f"{path} imports {name}"


def test_kernels_of_a_module_whose_imports_do_not_count_use_none_of_them():
    from tablegen.accuracy import streaming_statistics

    tree = ast.parse(_STREAMING.read_text(encoding="utf-8"))
    imports = [node for node in tree.body if isinstance(node, ast.ImportFrom)]
    ours = {
        alias.asname or alias.name
        for node in imports
        if (node.module or "").startswith(("sampler.", "tablegen."))
        for alias in node.names
    }
    kernels = [v.py_func for v in vars(streaming_statistics).values() if hasattr(v, "py_func")]
    own = [k for k in kernels if inspect.getmodule(k) is streaming_statistics]
    assert own
    for function in own:
        assert not ours & {*function.__code__.co_names}


def _garbage(path):
    path.write_bytes(b"")
    kernel_cache._write(path, b"no pickle")


def _of_another_kernel(path):
    kernel_cache._write(path, pickle.dumps(("another", ())))


def _not_to_be_rebuilt(path):
    key, _ = kernel_cache._read(path)
    kernel_cache._write(path, kernel_cache.dumps((key, ("no", "kernel"))))


def _flipped(path):
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)


@pytest.mark.parametrize(
    "damage",
    [
        pytest.param(lambda path: path.write_bytes(b""), id="empty"),
        pytest.param(lambda path: path.write_bytes(path.read_bytes()[:-100]), id="truncated"),
        _flipped,
        _garbage,
        _of_another_kernel,
        _not_to_be_rebuilt,
    ],
)
def test_a_damaged_file_is_replaced(damage, folder, caplog):
    assert not hit()
    (path,) = folder.iterdir()
    damage(path)
    caplog.clear()
    assert [hit(), hit()] == [False, True]
    assert not caplog.records
    assert [*folder.iterdir()] == [path]


def test_a_folder_in_place_of_the_file(folder, caplog):
    hit()
    (path,) = folder.iterdir()
    path.unlink()
    path.mkdir()
    with caplog.at_level(logging.WARNING, "sampler"):
        assert [hit(), hit()] == [False, False]
    assert len(caplog.records) == 1


def test_nothing_can_be_written(copied):
    # a superuser can write to any folder: files are in their places
    for folder in {path.parent for path in copied.rglob("*.py")}:
        (folder / "__pycache__").write_bytes(b"")
    many = f"{SCORE}\nfrom sampler.drawing.normal import normal_cdf as f; print(f(0.0))"
    result, log = run(copied, many)
    assert result.split()[1] == "0.5"
    compiling, kept = log.splitlines()
    assert compiling.startswith("compiling the draw ")
    assert kept.startswith("compiled kernels cannot be kept")
    assert "NUMBA_CACHE_DIR" in kept
    assert str(copied / "sampler" / "__pycache__") in kept
    assert os.devnull in kept
    # what compiles nothing says nothing
    script = (
        "import sys, runpy, sampler.table; sys.argv[1:] = ['--help'];"
        "runpy.run_module('sampler', run_name='__main__')"
    )
    result, log = run(copied, script)
    assert (result.startswith("Usage: "), log) == (True, "")


def test_the_disk_is_full(copied, tmp_path):
    """A limit to the size of files ends a write in its middle, as a full disk does."""
    cache = tmp_path / "cache"
    full = "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))\n"
    result, log = run(copied, full + SCORE, NUMBA_CACHE_DIR=str(cache))
    assert float(result) > 0.0
    assert [line.split(":")[0] for line in log.splitlines()[1:]] == [
        "compiled kernels cannot be kept, and every process compiles them again, unless "
        "NUMBA_CACHE_DIR names a folder for them"
    ]
    assert "File too large" in log
    assert not [path for path in cache.rglob("*") if path.is_file()]
    # and afterwards there is room
    assert run(copied, SCORE, NUMBA_CACHE_DIR=str(cache))[0] == result
    assert run(copied, SCORE, NUMBA_CACHE_DIR=str(cache)) == (result, "")


def test_kernels_are_read_where_they_cannot_be_written(folder, tmp_path, monkeypatch):
    assert not hit()
    blocked = tmp_path / "file"
    blocked.write_bytes(b"")
    monkeypatch.setattr(kernel_cache, "_places", lambda: [blocked, folder.parent])
    assert hit()


def test_without_a_home_no_folder_is_called_by_its_sign(monkeypatch):
    monkeypatch.setattr(config, "CACHE_DIR", "")
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    assert len(kernel_cache._places()) == 2
    monkeypatch.setattr(os.path, "expanduser", lambda path: path)
    assert kernel_cache._places() == [ROOT / "sampler" / "__pycache__"]


def test_an_upgrade_that_removes_files_meanwhile_is_no_error(folder, monkeypatch):
    monkeypatch.setattr(kernel_cache, "kernel_sources", lambda: [folder / "removed.py"])
    assert not hit()
    assert not folder.exists()


def test_without_sources_nothing_is_kept(folder, monkeypatch, caplog):
    monkeypatch.setattr(kernel_cache, "_PACKAGE", folder / "sampler")
    assert kernel_cache._digest() == ""
    monkeypatch.setattr(kernel_cache, "_IMPORTED", "")
    with caplog.at_level(logging.WARNING, "sampler"):
        assert [hit(), hit()] == [False, False]
    assert len(caplog.records) == 1
    assert "no sources can be read" in caplog.text
    assert not folder.exists()


def test_kernels_without_a_file_are_not_mixed_up(folder):
    """Two functions made by exec differ in a constant only."""
    results = []
    for constant in (1.0, 2.0):
        made = {}
        exec(f"def f(x):\n    return x + {constant}", made)
        results.append(kernel(made["f"])(0.0))
    assert results == [1.0, 2.0]
    assert not folder.exists()


def test_kernels_of_an_edited_and_reloaded_file_are_not_mixed_up(folder, tmp_path):
    path = tmp_path / "edited.py"
    results = []
    for number in ("1.0", "20.0"):
        path.write_text(f"def f(x):\n    return x + {number}\n")
        made = {"__name__": "edited"}
        exec(compile(path.read_text(), str(path), "exec"), made)
        results.append(kernel(made["f"])(0.0))
    assert results == [1.0, 20.0]


def test_a_new_folder_removes_the_oldest(folder):
    others = [folder.with_name(f"rebound-tables-{k:016x}") for k in range(KEPT + 3)]
    not_ours = [folder.with_name(name) for name in ("rebound-tables", "rebound-tables-0-beef", "x")]
    for age, path in enumerate([*others, *not_ours]):
        path.mkdir(parents=True)
        (path / "f.kernel").write_bytes(b"")
        os.utime(path, (1e9 - age, 1e9 - age))
    hit()
    assert {*folder.parent.iterdir()} == {folder, *others[:KEPT], *not_ours}
    assert hit()


def test_recompiling_does_not_read_the_old_file(folder):
    compiled = kernel(_twice)
    compiled(3.0)
    (path,) = folder.iterdir()
    written = path.stat().st_mtime_ns
    compiled.recompile()
    assert compiled(3.0) == 6.0
    assert path.stat().st_mtime_ns > written
    assert hit()


def test_kernels_of_users_are_kept_by_numba():
    assert type(numba.njit(cache=True)(_twice)._cache) is FunctionCache
