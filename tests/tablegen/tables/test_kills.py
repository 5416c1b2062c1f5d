"""Tables whose generation is ended again and again, at any time, come out as if nothing had been.

A study, for the time: fifty runs that are ended. `test_resume.py` has one of each kind.
"""

import random
import signal
import subprocess
import time

import pytest
from command_line import DONE, config_file
from processes import TABLEGEN
from tiny_tables import ROUGH

pytestmark = pytest.mark.study

KILLS = 50
SIGNALS = {signal.SIGKILL: -signal.SIGKILL, signal.SIGTERM: 143, signal.SIGINT: 130}

#: Twelve nodes that take a tenth of a second or two each.
NODES = {
    "samples_per_node": 30_000,
    "alpha_nodes_deg": [35.0, 38.0, 41.0, 45.0],
    "speed_nodes": [60.0, 120.0, 300.0],
}


def words(folder, *more):
    settings = ("--conditions", "1", "--samples", "1000", "--workers", "2", "--quiet")
    config = config_file(folder, ROUGH, table=NODES)
    return [*TABLEGEN, "generate", str(config), "--output", str(folder / "t.h5"), *settings, *more]


def ended_after(run, seconds, number):
    """Give a run a signal unless it has ended before; its standard error."""
    try:
        return run.communicate(timeout=seconds)[1]
    except subprocess.TimeoutExpired:
        run.send_signal(number)
        return run.communicate(timeout=30)[1]


def check_end(status, said, number):
    """A run ends by the signal, or is done: the signal may come when nothing is left to do."""
    if status in (DONE, -number):  # ended, or killed, or so late that Python itself is at work
        return
    assert status == SIGNALS[number]
    assert said.count("\n") == 1
    assert said.startswith("tablegen: ")


def test_fifty_kills_change_no_byte(tmp_path):
    undisturbed = tmp_path / "undisturbed"
    undisturbed.mkdir()
    for _ in range(2):  # the first compiles
        (undisturbed / "t.h5").unlink(missing_ok=True)
        start = time.monotonic()
        subprocess.run(words(undisturbed), check=True, capture_output=True)
        takes = time.monotonic() - start
    whole = (undisturbed / "t.h5").read_bytes()

    folder = tmp_path / "killed"
    folder.mkdir()
    table, choice = folder / "t.h5", random.Random(1)
    kills = tables = 0
    while kills < KILLS or not table.exists():
        if table.exists():
            assert table.read_bytes() == whole
            table.unlink()
            tables += 1
        number = choice.choice([*SIGNALS])
        seconds = choice.uniform(0.5, takes) if kills < KILLS else 120.0
        streams = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE}
        run = subprocess.Popen(words(folder, "--resume"), text=True, **streams)
        said = ended_after(run, seconds, number)
        check_end(run.returncode, said, number)
        kills += run.returncode != DONE
    assert table.read_bytes() == whole
    assert tables > 3  # whole tables came out on the way
    # what a SIGKILL leaves in the middle of writing is hidden, and in nobody's way
    left = {path.name for path in folder.iterdir() if not path.name.startswith(".t.h5.")}
    assert left == {"my.toml", "t.h5"}
