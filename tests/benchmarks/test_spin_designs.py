"""The experiments on spin laws run, and tell a leaf that was fitted well from one that was not."""

import numpy as np
import pytest
import spin_designs

from tablegen.fitting.leaf_sizes import SpinSizes


@pytest.fixture
def few(monkeypatch):
    monkeypatch.setattr(spin_designs, "COUNT", 2000)
    monkeypatch.setattr(spin_designs, "CONDITIONS", spin_designs.CONDITIONS[:1])
    monkeypatch.setattr("tablegen.accuracy.metrics.TREES", 10)


@pytest.mark.usefixtures("few")
def test_leaves(capsys):
    spin_designs.leaves(SpinSizes(2, 1, 2, 4, 4000, 65))
    line = capsys.readouterr().out
    assert float(line.split("KS ")[1].split()[0]) < 0.3
    assert all(word in line for word in ("sliced Wasserstein", "correlation", "AUC"))


@pytest.mark.usefixtures("few")
def test_mirror_images(capsys):
    """Of 2,000 a side, equal laws are 0.09 apart with p = 1e-6; tetrahedra may add 0.03."""
    spin_designs.mirror()
    lines = capsys.readouterr().out.splitlines()
    distance = {line.split()[0]: float(line.split("KS ")[1]) for line in lines}
    assert len(distance) == 4
    assert max(np.fromiter(distance.values(), float)) < 0.12
