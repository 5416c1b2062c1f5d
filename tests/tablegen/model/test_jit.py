"""Machine code on disk: it is stored once, never used for other sources, and never fails a run."""

import resource
import shutil

import pytest
from numba.core import config

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


def test_an_edit_of_any_source_of_kernels_leads_to_another_folder(tmp_path, monkeypatch):
    """Numba's own cache would go on with the machine code of callers in other files."""
    for name in jit._SOURCES:
        copy = shutil.copytree if (jit._ROOT / name).is_dir() else shutil.copy
        (tmp_path / name).parent.mkdir(exist_ok=True)
        copy(jit._ROOT / name, tmp_path / name)
    monkeypatch.setattr(jit, "_ROOT", tmp_path)
    digests = {jit._digest()}
    assert digests == {jit._SOURCE_DIGEST}
    for name in ("tablegen/model/vectors.py", "sampler/errors.py", "sampler/formats/bounds.py"):
        with open(tmp_path / name, "a", encoding="utf-8") as file:
            file.write("\n")
        digests.add(jit._digest())
    assert len(digests) == 4


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


@pytest.mark.usefixtures("folder")
def test_a_file_that_is_not_taken_fails_no_kernel_and_is_logged_once(caplog):
    kernel(_twice)  # the folder can be written
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (10, limits[1]))  # bytes, as on a full disk
    try:
        found = [comes_from_disk(), comes_from_disk()]
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert found == [False, False]
    (line,) = caplog.messages
    assert line.endswith("with space: [Errno 27] File too large")
    assert not jit.kernels_are_kept()
