"""Ctrl-C and SIGTERM end a program soon, whatever it does, in one line and with its status.

The programs are made up: each has one way of not hearing of a signal.
"""

import os
import signal
import subprocess
import sys
import textwrap
import time
from types import SimpleNamespace

import pytest
from documents import ROOT

#: Ends the process some time after the first signal.
GRACE = 0.8

#: A call into C that Python's threads do not wait for, and that no signal ends.
DEAF = "import hashlib; hashlib.pbkdf2_hmac('sha256', b'', b'', 2**31 - 1)"

#: What stands for the command of a program; `ready` says that the signal may come.
BODIES = {
    "waits": "ready(); time.sleep(60)",
    "is in a kernel": f"ready(); {DEAF}",
    "has a thread in a kernel": f"""
        threading.Thread(target=lambda: exec({DEAF!r})).start()
        ready()
        time.sleep(60)
    """,
    "hears nothing": """
        ready()
        while True:
            try:
                time.sleep(60)
            except BaseException:
                pass
    """,
    "fails in another way": """
        try:
            ready()
            time.sleep(60)
        except BaseException:
            raise ImportError("numpy.core failed to import")
    """,
    "is in a destructor": """
        class Odd:
            def __del__(self):
                ready()
                time.sleep(60)
        Odd()
        time.sleep(60)
    """,
    "is importing": "",
}
TEMPLATE = """
import sys, threading, time
import click
from sampler.options import Program, run_program

def ready():
    open("ready", "w").close()

@click.command()
def work():
{body}

def main():
    return run_program(Program("prog", commands=[work]), ["work"])
"""


def made_up(folder, what):
    """Package of a program."""
    commands = folder / "prog" / "commands"
    commands.mkdir(parents=True)
    text = TEMPLATE.format(body=textwrap.indent(textwrap.dedent(BODIES[what]).strip(), "    "))
    if what == "is importing":
        text = "import time\nopen('ready', 'w').close()\ntime.sleep(60)\n"
    (commands / "main.py").write_text(text)
    text = "from sampler.commands.process import run_process\nrun_process('prog')\n"
    (folder / "prog" / "__main__.py").write_text(text)


@pytest.fixture
def ended_by(tmp_path):
    """What becomes of a made-up program that gets a signal in the middle of its work."""

    def run(what, *numbers, before=None):
        made_up(tmp_path, what)
        paths = os.pathsep.join([str(tmp_path), str(ROOT), os.environ.get("PYTHONPATH", "")])
        process = subprocess.Popen(
            [sys.executable, "-m", "prog"],
            cwd=tmp_path,
            env=os.environ | {"PYTHONPATH": paths},
            stderr=subprocess.PIPE,
            text=True,
            preexec_fn=before,
        )
        deadline = time.monotonic() + 30.0
        while not (tmp_path / "ready").exists() and time.monotonic() < deadline:
            time.sleep(0.01)
        time.sleep(0.1)
        start = time.monotonic()
        for number in numbers:
            process.send_signal(number)
            time.sleep(0.1)
        try:
            _, said = process.communicate(timeout=20.0)
        finally:
            process.kill()
        took = time.monotonic() - start
        return SimpleNamespace(status=process.returncode, err=said, took=took)

    return run


@pytest.mark.parametrize("what", BODIES)
def test_ctrl_c_ends_it_in_one_line(ended_by, what):
    ended = ended_by(what, signal.SIGINT)
    assert (ended.status, ended.err) == (130, "prog: interrupted\n")
    assert ended.took < 2.0


@pytest.mark.parametrize("what", ["waits", "is in a kernel"])
@pytest.mark.parametrize(("number", "status"), [(signal.SIGTERM, 143), (signal.SIGHUP, 129)])
def test_so_do_other_signals_that_ask_for_the_end(ended_by, what, number, status):
    ended = ended_by(what, number)
    assert (ended.status, ended.err) == (status, "prog: terminated\n")
    assert ended.took < 2.0


def test_a_second_ctrl_c_does_not_wait(ended_by):
    ended = ended_by("hears nothing", signal.SIGINT, signal.SIGINT)
    assert (ended.status, ended.err) == (130, "prog: interrupted\n")
    assert ended.took < GRACE


def test_what_the_parent_ignores_is_ignored(ended_by):
    def ignore():
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # as a shell does for jobs in the background

    ended = ended_by("waits", signal.SIGINT, signal.SIGTERM, before=ignore)
    assert ended.status == 143


#: Python remembers a plain KeyboardInterrupt that has passed through `exec`, and ends by SIGINT.
GENERATED = """
import os, signal, sys, time
from sampler.commands.signals import ended_by_signals
with ended_by_signals("prog"):
    try:
        exec("os.kill(os.getpid(), signal.SIGTERM); time.sleep(60)")
    except KeyboardInterrupt:
        pass
sys.exit(143)
"""


def test_status_is_kept_where_source_is_generated(tmp_path):
    (tmp_path / "generated.py").write_text(GENERATED)
    paths = os.pathsep.join([str(tmp_path), str(ROOT), os.environ.get("PYTHONPATH", "")])
    ended = subprocess.run(
        [sys.executable, "-m", "generated"], env=os.environ | {"PYTHONPATH": paths}, timeout=60
    )
    assert ended.returncode == 143
