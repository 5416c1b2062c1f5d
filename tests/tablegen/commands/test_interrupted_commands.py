"""Ctrl-C and SIGTERM in the middle of the kernels of a command: a line, a status, and no file."""

import signal
import subprocess
import time

import pytest
from command_line import SIMULATE, flags
from processes import TABLEGEN

#: A run of a minute, whose memory is hardly touched before it is interrupted.
MANY = flags(SIMULATE, {"--alpha": 90, "--count": 30_000_000})
COMMANDS = {
    "simulate": [*TABLEGEN, "simulate", *MANY, "--output", "a.npz", "--quiet"],
    "statistics": [*TABLEGEN, "simulate", *MANY, "--statistics", "a.json", "--quiet"],
    "stability": [*TABLEGEN, "stability", "--count", "1000", "--json", "a.json", "--quiet"],
}


@pytest.mark.parametrize(
    ("name", "number", "status", "said"),
    [
        ("simulate", signal.SIGINT, 130, "tablegen: interrupted\n"),
        ("statistics", signal.SIGTERM, 143, "tablegen: terminated\n"),
        ("stability", signal.SIGINT, 130, "tablegen: interrupted\n"),
    ],
)
def test_a_long_command_ends_at_once(tmp_path, name, number, status, said):
    words = [str(word) for word in COMMANDS[name]]
    with subprocess.Popen(words, cwd=tmp_path, stderr=subprocess.PIPE, text=True) as process:
        time.sleep(2.5)  # in the kernels, or still compiling them
        assert process.poll() is None
        process.send_signal(number)
        try:
            # a second or two; more on a loaded machine, and far less than what is left to do
            _, err = process.communicate(timeout=20)
        finally:
            process.kill()
    assert process.returncode == status
    lines = [line for line in err.splitlines(keepends=True) if not line.startswith("compiling ")]
    assert lines == [said]
    assert list(tmp_path.iterdir()) == []
