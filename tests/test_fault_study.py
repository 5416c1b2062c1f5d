"""Fault study: outputs appear whole or not at all, on full disks and in folders that vanish."""

import resource
import shutil
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import pytest
from documents import ROOT

VECTORS = ROOT / "tests" / "vectors"
FULL, PLANE = VECTORS / "full.h5", VECTORS / "plane.h5"

#: Seconds after which a program counts as hanging.
LIMIT = 30.0

SIMULATE = (
    "tablegen simulate --pair corundum-steel --shape prism --alpha 45 --speed 200 --seed 1 --quiet"
)
DRAW = f"sampler draw {FULL} --alpha 45 --speed 200 --count 2000 --seed 1 --output"
VALIDATE = "tablegen validate corundum-steel-compact --alpha 45 --speed 200 --seed 1 --quiet"
VALIDATE += " --samples 1000"

#: Commands that write a file, whose name follows.
WRITERS = {
    "draw.npz": DRAW,
    "export.rbt": f"sampler export {FULL} --output",
    "prune.h5": "tablegen prune corundum-steel-compact --dimension 2 --output",
    "rebounds.npz": f"{SIMULATE} --count 2000 --output",
    "statistics.json": f"{SIMULATE} --count 2000 --statistics",
    "validation.json": f"{VALIDATE} --json",
    "validation.html": f"{VALIDATE} --html",
}


def words_of(line, *more):
    """Words of a command line for a new process."""
    program, *words = line.split()
    return [sys.executable, "-m", program, *words, *map(str, more)]


def ended(line, *more, limit=None, seconds=LIMIT):
    """Run a command line to its end, with a limit on the size of files if one is given."""
    limited = partial(resource.setrlimit, resource.RLIMIT_FSIZE, (limit, limit))
    return subprocess.run(
        words_of(line, *more),
        capture_output=True,
        text=True,
        timeout=seconds,
        preexec_fn=None if limit is None else limited,
        check=False,
    )


def last_line(text):
    """Last line of standard error, which holds no traceback."""
    assert "Traceback" not in text
    return text.splitlines()[-1]


@pytest.mark.study
@pytest.mark.parametrize("name", WRITERS)
def test_full_disk_leaves_the_old_file_and_nothing_else(tmp_path, name):
    target = tmp_path / name
    # this run also compiles the kernels, which a limited process could not keep
    made = ended(WRITERS[name], target, seconds=300.0)
    assert made.returncode in (0, 1), made.stderr
    size = target.stat().st_size
    for limit in (0, 1, size // 2, size - 1):
        for before in (None, b"what was there before"):
            target.unlink(missing_ok=True)
            if before is not None:
                target.write_bytes(before)
            found = ended(WRITERS[name], target, limit=limit)
            assert found.returncode == 2, found.stderr
            line = last_line(found.stderr)
            assert "error: output: cannot write" in line
            assert "File too large" in line
            assert [path.name for path in tmp_path.iterdir()] == [name] * (before is not None)
            assert before is None or target.read_bytes() == before
    assert ended(WRITERS[name], target, limit=size + 4096).returncode in (0, 1)
    assert target.stat().st_size == pytest.approx(size, rel=0.1)


def vanish(folder):
    """Remove a folder into which another process writes."""
    deadline = time.monotonic() + LIMIT
    while folder.exists():
        assert time.monotonic() < deadline
        shutil.rmtree(folder, ignore_errors=True)


@pytest.mark.study
@pytest.mark.parametrize("flag", ["--output rebounds.npz", "--statistics statistics.json"])
def test_folder_that_vanishes_while_a_simulation_runs(tmp_path, flag):
    folder = tmp_path / "gone"
    folder.mkdir()
    flag, name = flag.split()
    words = words_of(f"{SIMULATE} --count 3000000 {flag}", folder / name)
    with subprocess.Popen(words, stderr=subprocess.PIPE, text=True) as run:
        time.sleep(2.0)
        assert run.poll() is None
        vanish(folder)
        _, said = run.communicate(timeout=LIMIT)
    assert run.returncode == 2
    assert "allowed: a file in a folder that exists" in last_line(said)
    assert not folder.exists()


@pytest.mark.study
def test_two_commands_that_write_one_file(tmp_path):
    """The file is that of one command, to the last byte."""
    lines = [f"sampler export {path} --output" for path in (FULL, PLANE)]
    alone = []
    for line in lines:
        path = tmp_path / "alone.rbt"
        assert ended(line, path).returncode == 0
        alone.append(path.read_bytes())
    (tmp_path / "alone.rbt").unlink()
    target = tmp_path / "both.rbt"
    for _ in range(5):
        runs = [subprocess.Popen(words_of(line, target)) for line in lines]
        assert [run.wait(LIMIT) for run in runs] == [0, 0]
        assert target.read_bytes() in alone
        assert [path.name for path in Path(tmp_path).iterdir()] == ["both.rbt"]
