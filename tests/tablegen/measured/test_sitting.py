"""From measurements to a table that its own validation accepts: defaults, 15 minutes of CPU."""

import resource
import subprocess
import sys
from pathlib import Path

import pytest

QUARTZ = Path(__file__).parents[2] / "data" / "quartz.csv"


def cost():
    """CPU seconds of the commands that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


LAWS = "--free", "pair.restitution.value", "pair.resistance.value", "population.aspect.mean"
ROUNDED = (*LAWS, "population.aspect.standard_deviation", "population.shapes.ellipsoid")


@pytest.mark.study  # 12 minutes of CPU each
@pytest.mark.parametrize(
    ("measured", "start", "free"),
    [
        ("forder-1998", "start-tabulated", ()),
        ("wakeman-tabakoff-1981", "start-tabulated", (*LAWS, "population.shapes.prism")),
        ("grant-tabakoff-1975", "start-tabulated", ROUNDED),
        (QUARTZ, "start-tabulated", ROUNDED),
        ("kharaz-2001", "kharaz-2001", ()),
    ],
    ids=["forder", "wakeman", "grant", "quartz", "kharaz"],
)
def test_one_sitting(measured, start, free, tmp_path):
    pair, table, begun = tmp_path / "pair.toml", tmp_path / "table.h5", cost()
    for words in (
        ("calibrate", measured, "--pair", start, "--output", pair, *free),
        ("generate", pair, "--output", table, "--workers", 1),
        ("validate", table),
    ):
        command = [sys.executable, "-m", "tablegen", *map(str, words)]
        ended = subprocess.run(command, capture_output=True, text=True, check=False)
        print(words[0], ended.returncode, round(cost() - begun), "s", ended.stdout[-2000:])
        assert ended.returncode == 0, ended.stdout[-2000:] + ended.stderr[-2000:]
    assert cost() - begun < 15 * 60
