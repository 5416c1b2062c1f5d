"""Executors: the same bytes on each, and one line where one cannot be opened."""

import os
import sys

import numpy as np
import pytest
from command_line import BAD_INPUT, DONE, config_file
from processes import command, generating, mpiexec, needs_dask, needs_mpi, our_lines
from tiny_tables import MEASURED, ROUGH

from sampler.errors import InputError
from tablegen.checkpoints import Task, TaskRunner
from tablegen.tables import executors
from tablegen.tables.executors import open_executor
from tablegen.tables.generate import generate


@pytest.fixture(scope="module")
def rough_bytes(tmp_path_factory):
    path = tmp_path_factory.mktemp("rough") / "t.h5"
    with open_executor("threads", workers=1) as pool:
        generate(ROUGH, path, executor=pool, conditions=1, samples=MEASURED)
    return path.read_bytes()


@pytest.mark.apart
@needs_dask
def test_dask_makes_the_same_bytes(rough_bytes, tmp_path):
    with open_executor("dask", workers=1) as pool:  # two: `test_running_scheduler_is_used`
        assert pool.submit(os.getpid).result() != os.getpid()
        generate(ROUGH, tmp_path / "t.h5", executor=pool, conditions=1, samples=MEASURED)
    assert (tmp_path / "t.h5").read_bytes() == rough_bytes


@pytest.mark.apart
@needs_dask
def test_running_scheduler_is_used():
    from distributed import LocalCluster

    with (
        LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        open_executor("dask", scheduler=cluster.scheduler_address) as pool,
    ):
        tasks = {f"{n}": Task(dict, ([("number", np.array(n))],)) for n in range(4)}
        results = TaskRunner(executor=pool).run("numbers", tasks)
    assert [int(arrays["number"]) for arrays in results.values()] == [0, 1, 2, 3]


@pytest.mark.apart
@needs_dask
def test_task_that_kills_every_worker_is_one_line():
    import dask

    with (
        dask.config.set({"distributed.scheduler.allowed-failures": 0}),
        pytest.raises(InputError, match=r"^--executor: the Dask workers were lost"),
        open_executor("dask", workers=1) as pool,
    ):
        TaskRunner(executor=pool).run("deaths", {"0": Task(os._exit, (1,))})


@pytest.mark.apart
@needs_dask
@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "no-such-host.invalid:8786", "?"])
def test_scheduler_out_of_reach_is_one_line(refused, tmp_path, monkeypatch, address):
    monkeypatch.setattr(executors, "_TIMEOUT", 1)
    words = ("--output", tmp_path / "t.h5", "--executor", "dask", "--scheduler", address)
    line = refused("generate", config_file(tmp_path), *words)
    assert line.startswith(f"--scheduler: no Dask scheduler answered at {address} within ")


@pytest.mark.apart
@needs_mpi
def test_mpi_makes_the_same_bytes(rough_bytes, tmp_path):
    ended = command(*mpiexec(3), *generating(tmp_path, "--executor", "mpi"))
    assert ended.status == DONE, ended.err
    assert (tmp_path / "t.h5").read_bytes() == rough_bytes
    assert ended.out.count("The declared accuracy holds") == 1


@pytest.mark.apart
@needs_mpi
def test_bad_input_ends_all_ranks(tmp_path):
    ended = command(*mpiexec(2), *generating(tmp_path, "--executor", "mpi", "--workers", 2))
    assert ended.status == BAD_INPUT
    (line,) = set(our_lines(ended.err))
    assert line.startswith("tablegen: error: --workers: is given with mpi")


@pytest.mark.parametrize(
    ("engine", "package", "extra"), [("dask", "distributed", "dask"), ("mpi", "mpi4py", "mpi")]
)
def test_missing_package_is_one_line(refused, tmp_path, monkeypatch, engine, package, extra):
    monkeypatch.setitem(sys.modules, package, None)
    words = ("--output", tmp_path / "t.h5", "--executor", engine)
    line = refused("generate", config_file(tmp_path), *words)
    assert f"pip install 'rebound-tables[{extra}]'" in line


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("--executor", "cluster"), "'cluster'"),
        (("--workers", 0), "--workers: got '0'"),
        (
            ("--scheduler", "tcp://a:1"),
            "--scheduler: is given with --executor threads; give --executor dask",
        ),
        (
            ("--executor", "dask", "--scheduler", "tcp://a:1", "--workers", 2),
            "--workers: is given with mpi or with --scheduler",
        ),
    ],
)
def test_contradicting_arguments_are_refused(refused, tmp_path, words, expected):
    output = ("--output", tmp_path / "t.h5")
    assert expected in refused("generate", config_file(tmp_path), *output, *words)
