"""From measurements to a table that its own validation accepts, by defaults."""

import resource
import subprocess
import sys
from itertools import product
from pathlib import Path
from time import process_time

import numpy as np
import pytest
from numpy.polynomial.polynomial import polyval

from sampler.files import data_directory
from tablegen import calibrate
from tablegen.measured.reader import parse_measurements

QUARTZ = Path(__file__).parents[2] / "data" / "quartz.csv"


def made_up(name, e_n, e_t, speeds=(90.0,)):
    """Measurements of cubics in the angle [rad]; faster impacts keep less of e_n."""
    lines = ["alpha_deg,speed,e_n,e_n_std,e_t,e_t_std,count,source"]
    for speed, angle in product(speeds, range(15, 90, 10)):
        b = np.radians(angle)
        normal = polyval(b, e_n) * (90.0 / speed) ** 0.25
        spread = 0.12 + 0.05 * b
        lines.append(f"{angle},{speed},{normal},{spread},{polyval(b, e_t)},0.1,400,made up")
    return parse_measurements("\n".join(lines), name, name)


SETS = ["forder-1998", "wakeman-tabakoff-1981", "grant-tabakoff-1975", QUARTZ]
CUBICS = made_up("cubics", (0.95, -1.5, 1.4, -0.45), (0.95, -1.2, 1.5, -0.5))
TWO_SPEEDS = made_up("speeds", (0.95, -1.3, 1.0, -0.28), (0.93, -1.0, 1.2, -0.37), (60.0, 180.0))


def cost():
    """CPU seconds of the commands that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


@pytest.mark.study  # 1 minute each
@pytest.mark.parametrize(
    "measured", [*SETS, CUBICS, TWO_SPEEDS], ids=lambda one: getattr(one, "name", str(one))
)
def test_means_are_held_by_smooth_laws(measured, tmp_path):
    begun = process_time()
    path = tmp_path / f"{Path(getattr(measured, 'name', str(measured))).stem}.toml"
    calibration = calibrate(measured, path, threads=1)
    assert process_time() - begun < 180.0
    assert not calibration.missed
    for one in calibration.chosen.means:
        assert abs(one.residual) <= {"e_n": 0.02, "e_t": 0.03}[one.column]
    for fit in calibration.fits:
        values = np.array(fit.config.pair.restitution.value)
        assert np.abs(np.diff(values, 2, axis=0)).max() <= 0.25
    if (shipped := data_directory() / path.name).exists():
        # the file of a fitted pair is what the command writes, with limits that its table reached
        head, _, _ = shipped.read_text().partition("\n# What was reached")
        assert path.read_text() == head


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
        # the spin law of well-rounded grains misses the declared accuracy, and the reason is named
        missed = measured == QUARTZ and words[0] != "calibrate"
        assert ended.returncode == missed, ended.stdout[-2000:] + ended.stderr[-2000:]
        assert ("Nearly round grains" in ended.stdout) == missed
    assert cost() - begun < 17 * 60
