"""Wear of the bend: laws of erosion at known points, and the command."""

from pathlib import Path

import numpy as np
import pytest
import wear

TABLE = Path(__file__).resolve().parents[1] / "vectors" / "spin-works.h5"


def test_laws_of_erosion():
    assert wear.oka(wear.FAST, 0.5 * np.pi, wear.LARGE) == pytest.approx(wear.E90)
    border = np.arctan(wear.K / 6.0) + np.array([-1e-9, 1e-9])
    np.testing.assert_allclose(*wear.finnie(100.0, border), rtol=1e-6)


def test_command(tmp_path, capsys):
    figure = tmp_path / "wear.png"
    wear.main(["--table", str(TABLE), "--count", "20", "--figure", str(figure)])
    assert "| works (Bitter), mm³/kg | " in capsys.readouterr().out
    assert figure.read_bytes().startswith(b"\x89PNG")
    with pytest.raises(SystemExit, match="2"):
        wear.main(["--table", "corundum-steel"])
