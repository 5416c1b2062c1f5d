"""Study `wear`, the wear of the bend: laws of erosion at known points, and the command."""

import numpy as np
import pytest
import wear


def test_laws_of_erosion():
    assert wear.oka(wear.FAST, 0.5 * np.pi, wear.LARGE) == pytest.approx(wear.E90)
    border = np.arctan(wear.K / 6.0) + np.array([-1e-9, 1e-9])
    np.testing.assert_allclose(*wear.finnie(100.0, border), rtol=1e-6)


def test_command(tmp_path, capsys):
    figure = tmp_path / "wear.png"
    wear.main(["--count", "20", "--figure", str(figure)])
    rows = [line.split(" | ") for line in capsys.readouterr().out.splitlines()]
    assert rows[2][0] == "| normal work, kJ/kg"
    faces = [float(row[1].split()[0]) for row in rows if " to " in row[0]]
    assert sum(faces) == pytest.approx(float(rows[2][1]), rel=0.01)
    assert figure.read_bytes().startswith(b"\x89PNG")
