"""From measurements to a table that its own validation accepts, by defaults."""

import resource
import subprocess
import sys
from pathlib import Path
from time import process_time

import numpy as np
import pytest

from tablegen import calibrate

QUARTZ = Path(__file__).parents[2] / "data" / "quartz.csv"


SETS = ["forder-1998", "wakeman-tabakoff-1981", "grant-tabakoff-1975", QUARTZ]


def cost():
    """CPU seconds of the commands that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


@pytest.mark.study  # 1 minute each
@pytest.mark.parametrize("measured", SETS, ids=str)
def test_means_are_held_by_smooth_laws(measured):
    begun = process_time()
    made = calibrate(measured, threads=1)
    assert process_time() - begun < 180.0
    assert not made.missed
    for one in made.chosen.means:
        assert abs(one.residual) <= {"e_n": 0.02, "e_t": 0.03}[one.column]
    for fit in made.fits:
        values = np.array(fit.config.pair.restitution.value)
        assert np.abs(np.diff(values, 2, axis=0)).max() <= 0.25


@pytest.mark.study  # 12 minutes of CPU each
@pytest.mark.parametrize("measured", SETS, ids=str)
def test_one_sitting(measured, tmp_path):
    pair, table, begun = tmp_path / "pair.toml", tmp_path / "table.h5", cost()
    for words in (
        ("calibrate", measured, "--output", pair),
        ("generate", pair, "--output", table, "--workers", 1),
        ("validate", table),
    ):
        command = [sys.executable, "-m", "tablegen", *map(str, words)]
        ended = subprocess.run(command, capture_output=True, text=True, check=False)
        print(words[0], ended.returncode, round(cost() - begun), "s", ended.stdout[-2000:])
        assert ended.returncode == 0, ended.stdout[-2000:] + ended.stderr[-2000:]
    assert cost() - begun < 17 * 60
