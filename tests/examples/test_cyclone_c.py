"""Example `cyclone.c`: it follows the grains of `cyclone.py` to the same ends."""

import sys
from pathlib import Path

import cyclone
import numpy as np
import pytest
from tqdm import tqdm

from sampler.files import find_table
from sampler.formats.hdf5 import read_table
from sampler.formats.image import write_binary_table

sys.path.append(str(Path(__file__).resolve().parents[1] / "embedding"))
import toolchain

GRAINS = 60


class EvenNumbers:
    """The numbers between 0 and 1 by which cyclone.c lets grains enter, in place of random ones."""

    def __init__(self, _):
        self.steps = iter((0.8191725134, 0.6710436067, 0.5497004779))

    def random(self, count):
        return next(self.steps) * np.arange(1, count + 1) % 1.0


@pytest.mark.filterwarnings("ignore::sampler.OutsideTableWarning")
def test_grains_end_as_in_python(table, tmp_path, monkeypatch):
    """Both have 39.00 hits a grain, and 41.2 if grains lose their spins.

    The tolerance is for other processors, where rounding may send a grain another way.
    """
    write_binary_table(tmp_path / "t.rbt", read_table(find_table("corundum-steel")))
    source = Path(cyclone.__file__).with_suffix(".c")
    program = toolchain.build("gcc", [source], tmp_path / "cyclone", ["-O1"])
    printed = toolchain.run(program, tmp_path / "t.rbt", GRAINS, 16)
    numbers = dict(line.split(":") for line in printed.splitlines())
    monkeypatch.setattr(np.random, "default_rng", EvenNumbers)
    grains = cyclone.follow(table.rebound, table, GRAINS, 1, tqdm(disable=True))
    collected = np.isin(grains.fate, (cyclone.COLLECTED, cyclone.STAYED)).mean()
    assert float(numbers["collected"]) == pytest.approx(collected, abs=0.02)
    assert float(numbers["hits a grain"]) == pytest.approx(grains.hits.mean(), rel=0.02)
