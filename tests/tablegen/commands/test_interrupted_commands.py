"""Ctrl-C during a long command gives one line, status 130, and no file."""

import signal
import subprocess
import time

from command_line import INTERRUPTED, SIMULATE, flags
from processes import TABLEGEN


def test_a_long_command_ends_soon(tmp_path):
    # a run of a minute, whose memory is hardly touched before it is interrupted
    words = flags(SIMULATE, {"--alpha": 90, "--count": 30_000_000, "--output": "a.npz"})
    command = [*TABLEGEN, "simulate", *map(str, words), "--quiet"]
    with subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE, text=True) as process:
        time.sleep(2.5)  # in the kernels, or still compiling them
        assert process.poll() is None
        process.send_signal(signal.SIGINT)
        try:
            # a second or two; more on a loaded machine, and far less than what is left to do
            _, err = process.communicate(timeout=30)
        finally:
            process.kill()
    assert process.returncode == INTERRUPTED
    assert err.splitlines()[-1] == "tablegen: interrupted"
    assert list(tmp_path.iterdir()) == []
