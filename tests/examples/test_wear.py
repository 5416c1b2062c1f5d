"""Wear of the bend: laws of erosion at known points, and works beside the impacts that took them."""

from pathlib import Path

import bend
import numpy as np
import pytest
import wear

import sampler

TABLE = Path(__file__).resolve().parents[1] / "vectors" / "spin-works.h5"


def test_laws_of_erosion():
    assert wear.oka(wear.FAST, 0.5 * np.pi, wear.LARGE) == pytest.approx(wear.E90)
    border = np.arctan(wear.K / 6.0) + np.array([-1e-9, 1e-9])
    np.testing.assert_allclose(*wear.finnie(100.0, border), rtol=1e-6)


@pytest.mark.filterwarnings("ignore::sampler.OutsideTableWarning")
def test_works_are_those_of_the_impacts():
    taken = []
    rebound = wear.with_works(sampler.load(TABLE), 1e-5, taken)
    impacts = bend.follow(rebound, (150.0, 60e-6), 50, seed=1)
    lost = np.concatenate(taken).sum(axis=1) / (0.5 * impacts.speed**2)
    assert len(lost) == len(impacts.hit) > 50
    assert (lost[impacts.hit == 0] <= 1.0).all()
    assert lost.min() > 0.0


def test_command(tmp_path, capsys):
    figure = tmp_path / "wear.png"
    wear.main(["--table", str(TABLE), "--count", "40", "--figure", str(figure)])
    assert "| works (Bitter), mm³/kg | " in capsys.readouterr().out
    assert figure.read_bytes().startswith(b"\x89PNG")
    with pytest.raises(SystemExit, match="2"):
        wear.main(["--table", "corundum-steel"])
