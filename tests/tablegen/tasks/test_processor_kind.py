"""Kinds of processor: told apart, stored with every checkpoint, and named in the table."""

import json
import os
import subprocess
import sys
from dataclasses import replace
from itertools import cycle

import numpy as np
import processors
import pytest
from command_line import DONE, config_file
from tiny_tables import GENERATE, ROUGH

import sampler
from sampler.formats.hdf5 import read_table, write_table
from tablegen.fitting.node import fit_node
from tablegen.fitting.resolution import resolution
from tablegen.tables.axes import first_grid
from tablegen.tables.generate import generate
from tablegen.tables.intervals import Grid
from tablegen.tables.refine import fit_nodes, node_key
from tablegen.tasks import runner
from tablegen.tasks.checkpoint import CheckpointStore
from tablegen.tasks.processor_kind import processor_kind
from tablegen.tasks.runner import TaskRunner
from tablegen.tasks.software import software

pytestmark = pytest.mark.usefixtures("quick_measurement")

FINGERPRINT = f"{software()}\n{ROUGH.text}"
ANGLES, SPEEDS = first_grid(ROUGH)
NODES = [(ANGLES[0], speed) for speed in SPEEDS]

#: Two kinds that no processor is of.
ONE, OTHER = "one kind", "other kind"


@pytest.fixture
def kinds_of_tasks(monkeypatch):
    """Let tasks run on processors of the given kinds in turn, and the rest on the first."""

    def of(*kinds):
        turns = cycle(kinds)
        monkeypatch.setattr(runner, "processor_kind", lambda: next(turns))
        monkeypatch.setattr(GENERATE, "processor_kind", lambda: kinds[0])

    return of


def half_of_the_tasks(path):
    """Fit two of the four nodes of the rough table, as an interrupted run leaves them."""
    with CheckpointStore(path, FINGERPRINT) as store:
        fit_nodes(ROUGH, Grid(ANGLES[:1], SPEEDS), TaskRunner(store))


def test_is_one_line_and_stays_the_same():
    assert processor_kind() == processor_kind()
    assert len(processor_kind().splitlines()) == 1
    libraries = [part.split()[0] for part in processor_kind().split("; ")]
    assert libraries[0] == "numpy"
    assert libraries[-1] == "libm"


@pytest.mark.skipif(not processors.numpy_features(), reason="needs what can be switched off")
@pytest.mark.parametrize("name", processors.SETTINGS)
def test_another_processor_is_of_another_kind(name):
    above = processors.SETTINGS[name].above
    if not any(feature.startswith(above) for feature in processors.numpy_features()):
        pytest.skip("this processor is of that kind")
    script = "from tablegen.tasks.processor_kind import processor_kind; print(processor_kind())"
    environment = os.environ | processors.environment(name)
    ended = subprocess.run(
        [sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=True
    )
    assert ended.stdout.strip() != processor_kind()


def test_table_of_one_kind(kinds_of_tasks, run, tmp_path):
    kinds_of_tasks(ONE)
    output = tmp_path / "t.h5"
    ended = run("generate", config_file(tmp_path, ROUGH), "--output", output, "--conditions", 1)
    assert ended.status == DONE
    assert "kinds" not in ended.err
    assert read_table(output).processors == (ONE,)
    assert f"made on           {ONE}\n" in ended.out
    assert "kinds" not in run("inspect", output).out


def test_table_of_two_kinds_says_so(kinds_of_tasks, run, tmp_path):
    kinds_of_tasks(ONE, OTHER)
    output = tmp_path / "t.h5"
    ended = run("generate", config_file(tmp_path, ROUGH), "--output", output, "--conditions", 1)
    said = "made on processors of 2 kinds: made again, last digits may differ"
    assert ended.status == DONE
    assert f"tablegen: note: {said}\n" in ended.err
    assert read_table(output).processors == (ONE, OTHER)
    shown = run("inspect", output).out
    assert said in shown
    for kind in (ONE, OTHER):
        assert f"made on           {kind}\n" in shown


def test_kind_of_the_measurement_counts(kinds_of_tasks, tmp_path, monkeypatch):
    kinds_of_tasks(ONE)
    monkeypatch.setattr(GENERATE, "processor_kind", lambda: OTHER)
    generate(ROUGH, tmp_path / "t.h5", conditions=1)
    assert read_table(tmp_path / "t.h5").processors == (ONE, OTHER)


def test_checkpoints_keep_their_kind(kinds_of_tasks, tmp_path):
    kinds_of_tasks(OTHER)
    half_of_the_tasks(tmp_path / "t.h5")
    kinds_of_tasks(ONE)
    generate(ROUGH, tmp_path / "t.h5", conditions=1, resume=True)
    assert read_table(tmp_path / "t.h5").processors == (ONE, OTHER)


def test_json_names_the_kinds_and_older_tables_have_none(tiny, run, tmp_path):
    contents = sampler.load(tiny.path).contents
    assert contents.processors == (processor_kind(),)
    assert json.loads(run("inspect", tiny.path, "--json").out)["processors"] == [processor_kind()]
    older = tmp_path / "older.h5"
    write_table(older, replace(contents, processors=()))
    assert json.loads(run("inspect", older, "--json").out)["processors"] == []
    assert "made on           not recorded\n" in run("inspect", older).out


@pytest.fixture
def begun(tmp_path):
    """Checkpoints of half of the rough table, from this processor as it is."""
    path = tmp_path / "t.h5"
    script = (
        "import pathlib, test_processor_kind\n"
        f"test_processor_kind.half_of_the_tasks(pathlib.Path({str(path)!r}))"
    )
    folders = os.pathsep.join(p for p in sys.path if p)
    ended = subprocess.run(
        [sys.executable, "-c", script],
        env=processors.as_it_is() | {"PYTHONPATH": folders},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert ended.returncode == 0, ended.stderr
    return path


@pytest.mark.processor
@pytest.mark.skipif(processors.IMITATED not in os.environ, reason="runs as on this processor")
class TestTwoProcessors:
    def test_a_run_goes_on_on_another(self, begun):
        assert len(list(begun.with_name("t.h5.parts").glob("piece-*.npz"))) == 2
        with CheckpointStore(begun, FINGERPRINT, resume=True) as store:
            there = str(store.load(node_key(*NODES[0], resolution(ROUGH)))[runner.PROCESSOR])
        generate(ROUGH, begun, conditions=1, resume=True)
        assert read_table(begun).processors == tuple(sorted({there, processor_kind()}))
        # only a processor that is of the kind by itself computes results of that kind
        assert there != processor_kind() or os.environ[processors.IMITATED] == "avx2"

    def test_nodes_differ_by_no_more_than_steps_of_rounding(self, begun):
        """Particles are the same; a mean at the edge of two steps of 1/4096 may fall on either."""
        store = CheckpointStore(begun, FINGERPRINT, resume=True)
        for alpha_deg, speed in NODES:
            there = store.load(node_key(alpha_deg, speed, resolution(ROUGH)))
            assert steps_between(there, fit_node(ROUGH, alpha_deg, speed)) <= 1.0
        # other particles at the same condition are many steps away
        other = ROUGH.with_changes({"table": {"seed": 6}})
        assert steps_between(there, fit_node(other, alpha_deg, speed)) > 10.0


def steps_between(found, node):
    """Largest difference of means and factors, and of quantiles in steps of 2e-4."""
    steps = [
        np.abs(found[name].astype(int) - getattr(node, name).astype(int)).max()
        for name in ("mean", "cholesky", "reflection")
    ]
    return max(*steps, np.abs(found["quantiles"] - node.quantiles).max() / 2e-4)
