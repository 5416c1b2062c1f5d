"""Engines: the same bytes from all of them, and one line when one cannot be used."""

import signal
import socket
import subprocess
import sys
import threading
import time
import tomllib
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, suppress

import numpy as np
import pytest
import tomli_w
from command_line import BAD_INPUT, DONE, INTERRUPTED, config_file
from crashing_tasks import die, die_once
from processes import TABLEGEN, command, mpiexec, needs_dask, needs_mpi, our_lines
from tiny_tables import ROUGH

from sampler.errors import InputError
from tablegen.config.config import parse_config
from tablegen.tables.generate import generate
from tablegen.tasks import executors
from tablegen.tasks.executors import open_executor
from tablegen.tasks.mpi_ranks import asks_for_ranks, on_first_rank
from tablegen.tasks.runner import SECONDS, Task, TaskRunner

#: The measurement at the end is none of the workers'.
MEASURED = ("--conditions", 1, "--samples", 1000, "--quiet")


def square(number):
    return {"square": np.array(number**2), SECONDS: np.zeros(3)}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Bytes of the table that one thread makes."""
    path = tmp_path_factory.mktemp("whole") / "t.h5"
    with ThreadPoolExecutor(1) as one:
        generate(chosen_nodes(), path, executor=one, conditions=1, samples=1000)
    return path.read_bytes()


def chosen_nodes():
    """Configuration whose speeds are chosen, so that there are trials as well as nodes."""
    tree = tomllib.loads(ROUGH.text)
    del tree["table"]["speed_nodes"]
    tree["domain"]["speed"] = [60.0, 90.0]
    return parse_config(tomli_w.dumps(tree), "test")


def generating(folder, *words):
    config = config_file(folder, chosen_nodes())
    output = folder / "t.h5"
    return (*TABLEGEN, "generate", config, "--output", output, *MEASURED, *words)


class TestSameBytes:
    def test_two_threads(self, whole, tmp_path):
        ended = command(*generating(tmp_path, "--executor", "threads", "--workers", 2))
        assert (ended.status, ended.err) == (DONE, "")
        assert (tmp_path / "t.h5").read_bytes() == whole

    # the next test has workers of the same kind
    @pytest.mark.study
    @needs_dask
    def test_dask_with_two_worker_processes(self, whole, tmp_path):
        ended = command(*generating(tmp_path, "--executor", "dask", "--workers", 2))
        assert (ended.status, ended.err) == (DONE, "")
        assert (tmp_path / "t.h5").read_bytes() == whole
        assert "worker seconds: simulation " in ended.out

    @needs_dask
    def test_scheduler_that_runs_already(self, whole, tmp_path):
        from distributed import LocalCluster

        with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
            words = ("--executor", "dask", "--scheduler", cluster.scheduler_address)
            ended = command(*generating(tmp_path, *words))
        assert (ended.status, ended.err) == (DONE, "")
        assert (tmp_path / "t.h5").read_bytes() == whole

    @needs_mpi
    # two ranks are one worker: less than three show
    @pytest.mark.parametrize("ranks", [pytest.param(2, marks=pytest.mark.study), 3])
    def test_mpi(self, whole, tmp_path, ranks):
        ended = command(*mpiexec(ranks), *generating(tmp_path, "--executor", "mpi"))
        assert ended.status == DONE
        assert (tmp_path / "t.h5").read_bytes() == whole
        # one rank speaks
        assert ended.out.count("worker seconds: ") == 1
        assert our_lines(ended.err) == []


@pytest.fixture
def service():
    """Open a port that accepts, says some words and no more; returns its address."""
    with ExitStack() as stack:
        accepted, asked = [], threading.Event()

        def accept(port, words):
            with suppress(OSError):  # when the port is closed
                while True:
                    accepted.append(stack.enter_context(port.accept()[0]))
                    accepted[-1].sendall(words)
                    asked.set()

        def opened(words):
            port = stack.enter_context(socket.create_server(("127.0.0.1", 0)))
            threading.Thread(target=accept, args=(port, words), daemon=True).start()
            return f"tcp://127.0.0.1:{port.getsockname()[1]}"

        opened.asked = asked
        yield opened


class TestDask:
    @pytest.fixture
    def two_workers(self):
        with open_executor("dask", workers=2) as pool:
            yield pool

    @needs_dask
    def test_worker_processes_are_other_processes(self, two_workers):
        import os

        pids = {two_workers.submit(os.getpid).result() for _ in range(3)}
        assert os.getpid() not in pids

    @needs_dask
    def test_task_of_a_worker_that_dies_is_done_by_another(self, two_workers, tmp_path):
        marker = tmp_path / "died"
        tasks = {f"{n}": Task(die_once, (n, str(marker))) for n in range(4)}
        found = TaskRunner(executor=two_workers).run("numbers", tasks)
        assert marker.exists()
        assert [int(arrays["number"]) for arrays in found.values()] == [0, 1, 2, 3]

    @needs_dask
    def test_task_that_kills_every_worker_is_one_line(self):
        import dask

        with (
            dask.config.set({"distributed.scheduler.allowed-failures": 0}),
            pytest.raises(InputError) as caught,
            open_executor("dask", workers=1) as pool,
        ):
            TaskRunner(executor=pool).run("deaths", {"0": Task(die, ())})
        assert str(caught.value) == "--executor: 1 workers died at the same piece"

    @needs_dask
    def test_lost_scheduler_is_one_line(self):
        from distributed import LocalCluster

        with LocalCluster(n_workers=0, dashboard_address=None) as cluster:
            notes = []

            def lose(note):
                notes.append(note)
                cluster.close()

            with (
                pytest.raises(InputError, match="the Dask scheduler was lost"),
                open_executor("dask", scheduler=cluster.scheduler_address, say=lose) as pool,
            ):
                TaskRunner(executor=pool).run("squares", {"2": Task(square, (2,))})
        assert len(notes) == 1
        assert "has no workers yet" in notes[0]

    @needs_dask
    @pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "no-such-host.invalid:8786", "?"])
    def test_scheduler_out_of_reach(self, refused, tmp_path, monkeypatch, address):
        monkeypatch.setattr("tablegen.tasks.dask_workers._TIMEOUT", 1)
        words = ("--output", tmp_path / "t.h5", "--executor", "dask", "--scheduler", address)
        line = refused("generate", config_file(tmp_path), *words)
        assert line.startswith(f"--scheduler: got {address}, where none answered within 1 s, ")

    @needs_dask
    def test_port_that_accepts_and_says_nothing_is_given_up(self, service, monkeypatch):
        monkeypatch.setattr("tablegen.tasks.dask_workers._TIMEOUT", 1)
        begun = time.monotonic()
        with (
            pytest.raises(
                InputError, match=r"^--scheduler: got \S+, where none answered within 1 s"
            ),
            open_executor("dask", scheduler=service(b"")),
        ):
            pass
        assert time.monotonic() - begun < 5.0

    @needs_dask
    @pytest.mark.parametrize(
        "words",
        [
            b"HTTP/1.0 400 Bad Request\r\nContent-Length: 0\r\n\r\n",
            b"SSH-2.0-OpenSSH_9.6\r\n",
            (1).to_bytes(8, "little") + (4).to_bytes(8, "little") + b"junk",
        ],
    )
    def test_another_service_is_one_line(self, service, words):
        with (
            pytest.raises(InputError, match=r"^--scheduler: got \S+, where no Dask [^\n]*$"),
            open_executor("dask", scheduler=service(words)),
        ):
            pass

    @needs_dask
    def test_certificates_that_are_missing(self):
        with (
            pytest.raises(InputError, match=r"^--scheduler: got tls://\S+, for which there are no"),
            open_executor("dask", scheduler="tls://127.0.0.1:9"),
        ):
            pass

    @needs_dask
    def test_wait_for_a_silent_port_can_be_interrupted(self, service, tmp_path):
        words = ("--executor", "dask", "--scheduler", service(b""))
        line = [str(word) for word in generating(tmp_path, *words)]
        with subprocess.Popen(line, stderr=subprocess.PIPE, text=True) as run:
            assert service.asked.wait(60)
            begun = time.monotonic()
            run.send_signal(signal.SIGINT)
            _, said = run.communicate(timeout=60)
        assert (run.returncode, said) == (INTERRUPTED, "tablegen: interrupted\n")
        assert time.monotonic() - begun < 5.0
        assert not (tmp_path / "t.h5.parts").exists()

    @needs_dask
    def test_cluster_without_our_package(self, monkeypatch):
        from distributed import LocalCluster

        monkeypatch.setattr("tablegen.tasks.dask_workers._PROBE", "import no_such_package")
        with (
            LocalCluster(n_workers=1, processes=False, dashboard_address=None) as cluster,
            pytest.raises(InputError, match="No module named 'no_such_package', allowed"),
            open_executor("dask", scheduler=cluster.scheduler_address),
        ):
            pass

    def test_not_installed(self, refused, tmp_path, monkeypatch):
        monkeypatch.setitem(sys.modules, "distributed", None)
        words = ("--output", tmp_path / "t.h5", "--executor", "dask")
        line = refused("generate", config_file(tmp_path), *words)
        assert "pip install 'rebound-tables[dask]'" in line


class TestRanks:
    @pytest.mark.parametrize(
        ("words", "asked"),
        [
            ("generate c.toml --executor mpi", True),
            ("generate c.toml --executor=mpi --resume", True),
            ("generate mpi --executor threads", False),
            ("generate --executor dask mpi", False),
            ("", False),
        ],
    )
    def test_asked_for(self, words, asked):
        assert asks_for_ranks(words.split()) is asked

    @needs_mpi
    @pytest.mark.parametrize(
        ("words", "said"),
        [
            (("--conditions", 0), "'--conditions': got '0'"),
            (("--workers", 2), "--workers: got 2 with mpi"),
            (("--fast",), "--fast"),
        ],
    )
    def test_bad_input_ends_all_ranks_with_one_line(self, tmp_path, words, said):
        ended = command(*mpiexec(2), *generating(tmp_path, "--executor", "mpi", *words))
        assert ended.status == BAD_INPUT
        assert ended.out == ""
        (line,) = our_lines(ended.err)
        assert said in line
        assert "Traceback" not in ended.err

    @needs_mpi
    def test_one_rank_is_refused(self, tmp_path):
        """Also what each process sees where mpiexec belongs to another MPI than mpi4py."""
        ended = command(*generating(tmp_path, "--executor", "mpi"))
        assert ended.status == BAD_INPUT
        assert ended.err.count("\n") == 1
        assert "got mpi on one rank, allowed: two or more" in ended.err

    def test_not_installed(self, refused, tmp_path, monkeypatch):
        monkeypatch.setitem(sys.modules, "mpi4py", None)
        words = ("--output", tmp_path / "t.h5", "--executor", "mpi")
        line = refused("generate", config_file(tmp_path), *words)
        assert "pip install 'rebound-tables[mpi]'" in line
        with pytest.raises(InputError, match="not installed"):
            on_first_rank(lambda _: 0)


class TestArguments:
    @pytest.mark.parametrize(
        ("words", "said"),
        [
            (("--executor", "cluster"), "'cluster' is not one of 'threads', 'dask', 'mpi'"),
            (("--workers", 0), "'--workers': got '0'"),
            (("--scheduler", "tcp://a:1"), "--scheduler: got tcp://a:1 with threads"),
            (
                ("--executor", "dask", "--scheduler", "tcp://a:1", "--workers", 2),
                "--workers: got 2 with --scheduler, allowed: one of the two",
            ),
        ],
    )
    def test_that_do_not_go_together(self, refused, tmp_path, words, said):
        output = ("--output", tmp_path / "t.h5")
        assert said in refused("generate", config_file(tmp_path), *output, *words)

    def test_ranks_come_from_outside(self):
        with ThreadPoolExecutor(1) as pool, open_executor("mpi", ranks=pool) as ranks:
            assert ranks is pool
        with pytest.raises(InputError, match="outside MPI"), open_executor("mpi"):
            pass
        with pytest.raises(InputError, match="allowed: threads, dask, mpi"), open_executor("pvm"):
            pass

    def test_default_is_as_many_threads_as_processors_granted(self, monkeypatch):
        monkeypatch.setattr(executors, "processors", lambda: 3)
        with open_executor() as pool:
            assert pool._max_workers == 3


def test_worker_with_other_software_is_refused(monkeypatch):
    """Threads stand for workers here; their software changes after the tasks were submitted."""
    said = iter(["rebound-tables 0.1", "rebound-tables 0.2"])
    monkeypatch.setattr("tablegen.tasks.runner.software", lambda: next(said))
    with pytest.raises(InputError) as caught:
        TaskRunner().run("squares", {"2": Task(square, (2,))})
    assert str(caught.value) == (
        "workers: got one with rebound-tables 0.2, allowed: rebound-tables 0.1"
    )
