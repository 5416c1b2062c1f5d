"""Nothing lost: runs that are killed, interrupted, or find the disk full, and are resumed.

The commands run in processes of their own. What a resumed run has to do is counted in this one.
"""

import resource
import shutil
import signal
import subprocess
import time
from functools import partial
from typing import NamedTuple

import pytest
from command_line import BAD_INPUT, DONE, INTERRUPTED, config_file
from processes import TABLEGEN, command
from tiny_tables import GENERATE, MEASURED, REFINE, ROUGH

from sampler.errors import InputError
from sampler.formats.hdf5 import write_table
from tablegen.fitting.node import fit_node
from tablegen.tables.generate import generate

#: Twelve nodes that take some tenths of a second each.
CONFIG = ROUGH.with_changes(
    {
        "table": {
            "samples_per_node": 100_000,
            "alpha_nodes_deg": [35.0, 38.0, 41.0, 45.0],
            "speed_nodes": [60.0, 120.0, 300.0],
        }
    }
)
NODES = 12


def generating(folder, *words):
    output = ("--output", folder / "t.h5")
    config = config_file(folder, CONFIG)
    settings = ("--conditions", 1, "--samples", 1000, "--workers", 1, "--quiet")
    return [*TABLEGEN, "generate", config, *output, *settings, *words]


def checkpoints(folder):
    return sorted(folder.glob("t.h5.parts/piece-*.npz"))


def made_here(path, patch, **options):
    """Generate in this process; conditions of the nodes that were really fitted."""
    fitted = []

    def counting(config, alpha_deg, speed, *rest):
        fitted.append((alpha_deg, speed))
        return fit_node(config, alpha_deg, speed, *rest)

    patch.setattr(REFINE, "fit_node", counting)
    generate(CONFIG, path, conditions=1, samples=MEASURED, **options)
    return fitted


class Undisturbed(NamedTuple):
    """A run that nothing disturbed: the table, and bytes on disk of all checkpoints and of it."""

    whole: bytes
    checkpoints: int
    table: int


@pytest.fixture(scope="module")
def sizes(tmp_path_factory):
    path = tmp_path_factory.mktemp("whole") / "t.h5"
    on_disk = []

    def weighing(target, contents):
        on_disk.extend(-(-file.stat().st_size // 4096) * 4096 for file in checkpoints(path.parent))
        write_table(target, contents)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(GENERATE, "write_table", weighing)
        assert len(made_here(path, patch)) == NODES
    return Undisturbed(path.read_bytes(), sum(on_disk), path.stat().st_size)


@pytest.fixture(scope="module")
def whole(sizes):
    return sizes.whole


def ended_by(number, folder):
    """Run that gets a signal when three nodes are there: status and standard error."""
    words = [str(word) for word in generating(folder)]
    with subprocess.Popen(words, stderr=subprocess.PIPE, text=True) as run:
        deadline = time.monotonic() + 120.0
        while len(checkpoints(folder)) < 3:
            assert run.poll() is None, "it ended before three nodes were there"
            assert time.monotonic() < deadline, "three nodes were never there"
            time.sleep(0.005)
        run.send_signal(number)
        _, said = run.communicate(timeout=60)
    assert 3 <= len(checkpoints(folder)) < NODES
    assert not (folder / "t.h5").exists()
    return run.returncode, said


@pytest.fixture(scope="module")
def killed_once(tmp_path_factory):
    """Folder of a run that was killed."""
    folder = tmp_path_factory.mktemp("killed")
    assert ended_by(signal.SIGKILL, folder)[0] == -signal.SIGKILL
    return folder


@pytest.fixture
def killed(killed_once, tmp_path):
    """Copy of what the killed run has left; returns its checkpoints."""
    shutil.copytree(killed_once, tmp_path, dirs_exist_ok=True)
    return checkpoints(tmp_path)


def made_the_rest(folder, patch, whole):
    """Resume; number of nodes that were fitted. The table is that of an undisturbed run."""
    fitted = made_here(folder / "t.h5", patch, resume=True)
    assert len(fitted) == len(set(fitted))
    assert (folder / "t.h5").read_bytes() == whole
    assert not (folder / "t.h5.parts").exists()
    return len(fitted)


def test_killed_run_is_resumed_without_doing_anything_twice(killed, whole, tmp_path, monkeypatch):
    assert made_the_rest(tmp_path, monkeypatch, whole) == NODES - len(killed)


def test_interrupted_run_says_how_to_go_on(whole, tmp_path, monkeypatch):
    how = "interrupted: the same command with --resume continues from"
    status, said = ended_by(signal.SIGINT, tmp_path)
    assert (status, said) == (INTERRUPTED, f"tablegen: {how} {tmp_path / 't.h5.parts'}\n")
    kept = len(checkpoints(tmp_path))
    assert made_the_rest(tmp_path, monkeypatch, whole) == NODES - kept


def test_run_without_a_word_on_the_pieces_is_refused(killed, tmp_path, monkeypatch):
    kept = {path: path.stat().st_mtime_ns for path in killed}
    with pytest.raises(InputError, match=r"of an unfinished run, allowed: --resume.* --discard"):
        made_here(tmp_path / "t.h5", monkeypatch)
    assert {path: path.stat().st_mtime_ns for path in checkpoints(tmp_path)} == kept


def test_second_run_is_told_of_the_first_until_that_has_ended(tmp_path):
    words = [str(word) for word in generating(tmp_path)]
    with subprocess.Popen(words) as run:
        while len(checkpoints(tmp_path)) < 1:
            assert run.poll() is None, "it ended before a node was there"
            time.sleep(0.005)
        for config in (CONFIG, ROUGH):
            for flags in ({}, {"resume": True}, {"discard": True}):
                with pytest.raises(InputError, match="which another run is making, allowed"):
                    generate(config, tmp_path / "t.h5", conditions=1, samples=MEASURED, **flags)
        assert run.poll() is None
        run.kill()
    assert len(checkpoints(tmp_path)) >= 1
    generate(ROUGH, tmp_path / "t.h5", conditions=1, samples=MEASURED, discard=True)
    assert [path.name for path in tmp_path.glob("t.h5*")] == ["t.h5"]


def spoiled(file, foreign):
    data = file.read_bytes()
    return {
        "truncated": data[:-40],
        "flipped": data[:500] + bytes([data[500] ^ 16]) + data[501:],
        "foreign": foreign.read_bytes(),
        "empty": b"",
    }


@pytest.mark.parametrize("how", ["truncated", "flipped", "foreign", "empty"])
def test_bad_checkpoint_of_a_killed_run_is_made_again(killed, whole, tmp_path, monkeypatch, how):
    killed[0].write_bytes(spoiled(killed[0], killed[1])[how])
    assert made_the_rest(tmp_path, monkeypatch, whole) == NODES - len(killed) + 1


def test_file_that_cannot_grow_is_one_line_and_keeps_the_checkpoints(
    killed, whole, tmp_path, monkeypatch
):
    """A limit on the size of files stands for a full disk, wherever this test runs."""
    kept = {path: path.read_bytes() for path in killed}
    limit = partial(resource.setrlimit, resource.RLIMIT_FSIZE, (1000, 1000))
    words = [str(word) for word in generating(tmp_path, "--resume")]
    ended = subprocess.run(words, capture_output=True, text=True, timeout=120, preexec_fn=limit)
    assert (ended.returncode, ended.stdout) == (BAD_INPUT, "")
    assert ended.stderr.count("\n") == 1
    assert "File too large; earlier pieces are kept for --resume" in ended.stderr
    assert {path: path.read_bytes() for path in checkpoints(tmp_path)} == kept
    assert made_the_rest(tmp_path, monkeypatch, whole) == NODES - len(kept)


#: Make a small file system that only this shell sees, and vanishes with it.
_MOUNT = 'mount -t tmpfs -o size={size} tablegen-test "$1" && cd "$1" && cp "$2" my.toml'
_UNSHARE = ("unshare", "--mount", "--map-root-user", "sh", "-c")


@pytest.fixture
def file_system(tmp_path):
    """Run a script on a small file system of its own: what it printed, words on each line."""
    own = tmp_path / "own"
    own.mkdir()
    config = config_file(tmp_path, CONFIG)

    def runner(size, *steps):
        script = "\n".join([_MOUNT.format(size=size), *steps])
        return command(*_UNSHARE, script, "sh", own, config)

    if shutil.which("unshare") is None or runner("64k", "true").status != 0:
        pytest.skip("needs unshare and leave to mount a file system")
    return runner


_WORDS = "generate my.toml --output t.h5 --conditions 1 --samples 1000 --workers 1 --quiet"
_GENERATE = f"{TABLEGEN[0]} -m tablegen {_WORDS}"


#: Fill the disk as soon as there is a node.
_FILL = (
    "(until ls t.h5.parts/piece* > out 2>&1; do sleep 0.01; done; cat /dev/zero > filler 2> out) &"
)


@pytest.mark.parametrize(
    "full",
    [
        pytest.param("at once", marks=pytest.mark.study),
        "after some nodes",
        pytest.param("at the table", marks=pytest.mark.study),
    ],
)
def test_full_disk_is_one_line_and_keeps_the_checkpoints(file_system, sizes, full):
    size, least, most = {
        "at once": (4096, 0, 0),
        "after some nodes": (2 * (sizes.checkpoints + sizes.table), 1, NODES - 1),
        "at the table": (sizes.checkpoints + sizes.table // 2, NODES, NODES),
    }[full]
    ended = file_system(
        size,
        f"{_FILL if full == 'after some nodes' else ''} {_GENERATE}; echo status $?; rm -f filler",
        "ls t.h5.parts 2> out | grep -c piece; ls -A | grep -c h5$",
        "mount -o remount,size=10M tablegen-test .",
        f"{_GENERATE} --resume > out; echo status $?; ls -A",
    )
    assert ended.err.count("\n") == 1
    assert ended.err.startswith("tablegen: error: output: cannot ")
    assert "No space left on device" in ended.err
    first, kept, tables, second, *files = ended.out.split("\n")
    assert (first, second) == (f"status {BAD_INPUT}", f"status {DONE}")
    assert least <= int(kept) <= most
    assert int(tables) == 0
    assert [name for name in files if name] == ["my.toml", "out", "t.h5"]


def test_folder_that_turned_read_only_is_one_line(file_system):
    ended = file_system(
        "10M",
        f"mkdir t.h5.parts; mount -o remount,ro tablegen-test .; {_GENERATE}; echo status $?",
        "mount -o remount,rw tablegen-test .",
        f"{_GENERATE} --resume > out; echo status $?",
    )
    assert ended.err.count("\n") == 1
    assert "allowed: a file in a folder that can be written" in ended.err
    assert ended.out == f"status {BAD_INPUT}\nstatus {DONE}\n"
