"""The same bytes for any number of threads, and for runs that were stopped and resumed."""

import shutil
import signal
import subprocess
import time
from concurrent.futures import ThreadPoolExecutor

import pytest
from command_line import INTERRUPTED
from processes import generating
from tiny_tables import MEASURED, REFINE, ROUGH

from tablegen.fitting.node import fit_node
from tablegen.tables.generate import generate

#: Twelve nodes that take a tenth of a second each.
TABLE = {"alpha_nodes_deg": [35.0, 38.0, 41.0, 45.0], "speed_nodes": [60.0, 120.0, 300.0]}
CONFIG = ROUGH.with_changes({"table": {"samples_per_node": 5_000, **TABLE}})
NODES = 12


def checkpoints(folder):
    return sorted(folder.glob("t.h5.parts/piece-*"))


def generate_table(folder, patch, config=CONFIG, **options):
    """Generate in this process; returns the conditions of the nodes that were fitted."""
    fitted = []

    def counting(config, alpha_deg, speed, *rest):
        fitted.append((alpha_deg, speed))
        return fit_node(config, alpha_deg, speed, *rest)

    patch.setattr(REFINE, "fit_node", counting)
    patch.setattr("tablegen.accuracy.metrics.TREES", 20)
    generate(config, folder / "t.h5", conditions=1, samples=MEASURED, **options)
    return fitted


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Bytes of a table that one thread made without a stop."""
    folder = tmp_path_factory.mktemp("whole")
    with pytest.MonkeyPatch.context() as patch, ThreadPoolExecutor(1) as pool:
        assert len(generate_table(folder, patch, executor=pool)) == NODES
    return (folder / "t.h5").read_bytes()


@pytest.fixture(scope="module")
def interrupted(tmp_path_factory):
    """Folder of a run that Ctrl-C ended when three nodes were there."""
    folder = tmp_path_factory.mktemp("interrupted")
    words = generating(folder, "--workers", 1, config=CONFIG)
    with subprocess.Popen(words, stderr=subprocess.PIPE, text=True) as run:
        while len(checkpoints(folder)) < 3:
            assert run.poll() is None, "it ended before three nodes were there"
            time.sleep(0.005)
        run.send_signal(signal.SIGINT)
        _, messages = run.communicate(timeout=60)
    assert run.returncode == INTERRUPTED
    assert messages.endswith(
        f"to continue from {folder}/t.h5.parts, give the same command with --resume\n"
    )
    return folder


@pytest.fixture
def left(interrupted, tmp_path):
    """Checkpoints of that run, in the folder of the test."""
    shutil.copytree(interrupted, tmp_path, dirs_exist_ok=True)
    assert 3 <= len(checkpoints(tmp_path)) < NODES
    assert not (tmp_path / "t.h5").exists()
    return checkpoints(tmp_path)


def generate_the_rest(folder, patch, whole):
    """Resume; returns the number of nodes that were fitted."""
    fitted = generate_table(folder, patch, resume=True)
    assert len(fitted) == len(set(fitted))
    assert (folder / "t.h5").read_bytes() == whole
    assert not (folder / "t.h5.parts").exists()
    return len(fitted)


@pytest.mark.processor
def test_same_bytes_for_three_threads_and_over_an_older_file(whole, tmp_path, monkeypatch):
    (tmp_path / "t.h5").write_text("an older file")
    with ThreadPoolExecutor(3) as pool:
        generate_table(tmp_path, monkeypatch, executor=pool)
    assert (tmp_path / "t.h5").read_bytes() == whole
    assert [path.name for path in tmp_path.iterdir()] == ["t.h5"]


def test_interrupted_run_is_resumed_without_any_work_done_twice(left, whole, tmp_path, monkeypatch):
    assert generate_the_rest(tmp_path, monkeypatch, whole) == NODES - len(left)


def test_damaged_pieces_are_computed_again(left, whole, tmp_path, monkeypatch):
    left[0].write_bytes(left[0].read_bytes()[:-1])
    left[1].write_bytes(b"")
    assert generate_the_rest(tmp_path, monkeypatch, whole) == NODES - len(left) + 2


@pytest.mark.parametrize(("version", "resume"), [("another version", True), (None, False)])
def test_pieces_are_not_used_by_another_version_nor_without_the_flag(
    left, whole, tmp_path, monkeypatch, version, resume
):
    if version:
        monkeypatch.setattr("tablegen.tables.generate.software", lambda: version)
    assert len(generate_table(tmp_path, monkeypatch, resume=resume)) == NODES
    assert (tmp_path / "t.h5").read_bytes() == whole
    assert not (tmp_path / "t.h5.parts").exists()
