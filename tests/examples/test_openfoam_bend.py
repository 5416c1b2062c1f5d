"""Impacts as OpenFOAM writes them down, of made-up parcels; OpenFOAM itself: tests/openfoam."""

import numpy as np
import pytest
from openfoam_bend.walls import CENTRE, OUTER, TURN, WALLS, outward, places, read_records

HEADER = "# Time currentProc (Px Py Pz) origId (Ux Uy Uz)\n"


def _line(time, position, parcel, velocity):
    triples = (" ".join(map(str, triple)) for triple in (position, velocity))
    return "{} 0 ({}) {} ({})\n".format(time, *[next(triples), parcel, next(triples)])


@pytest.fixture
def case(tmp_path):
    """Three parcels on three walls, in two files of one of them."""
    rows = {
        ("0.001", "outer"): [
            # where the duct turns by 45 degrees less half a face, along x
            (0.001, (OUTER * 0.66913, CENTRE - OUTER * 0.74314, 0.02), 7, (100.0, 0.0, 0.0)),
            # it leaves the wall
            (0.001, (-0.1, 0.0, 0.02), 7, (100.0, 50.0, 0.0)),
        ],
        ("0.002", "outer"): [(0.002, (0.2, 0.3, 0.02), 7, (30.0, 40.0, 0.0))],
        ("0.002", "inner"): [(0.0015, (-0.1, 0.1, 0.05), 8, (0.0, 10.0, 0.0))],
        ("0.002", "sides"): [(0.0018, (-0.1, 0.05, 0.1), 8, (0.0, 30.0, 40.0))],
    }
    for (time, wall), impacts in rows.items():
        folder = tmp_path / "postProcessing/lagrangian/kinematicCloud/impacts" / time
        folder.mkdir(parents=True, exist_ok=True)
        text = HEADER + "".join(_line(*impact) for impact in impacts)
        (folder / f"{wall}.post").write_text(text, encoding="ascii")
    return tmp_path


def test_places_run_along_the_middle_line():
    x = np.array([-0.3, 0.0, OUTER * np.sqrt(0.5), OUTER, OUTER])
    y = np.array([0.0, 0.0, CENTRE - OUTER * np.sqrt(0.5), CENTRE, 0.7])
    np.testing.assert_allclose(places(x, y), [-0.3, 0.0, 0.5 * TURN, TURN, TURN + 0.5])


def test_normals_point_out_of_the_gas():
    place = np.array([-0.1, 0.475 * TURN, TURN + 0.1])
    depth = np.array([0.01, 0.02, 0.09])
    slanted = np.sin(np.radians(42.75)), -np.cos(np.radians(42.75))
    expected = np.array([[0.0, -1.0, 0.0], [*slanted, 0.0], [1.0, 0.0, 0.0]])
    np.testing.assert_allclose(outward("outer", place, depth), expected, atol=1e-12)
    np.testing.assert_allclose(outward("inner", place, depth), -expected, atol=1e-12)
    np.testing.assert_allclose(outward("sides", place, depth)[:, 2], [-1.0, -1.0, 1.0])


def test_impacts_are_read_in_the_order_of_time(case):
    records = read_records(case)
    assert [WALLS[wall] for wall in records.wall] == ["outer", "inner", "sides", "outer"]
    np.testing.assert_array_equal(records.parcel, [7, 8, 8, 7])
    np.testing.assert_array_equal(records.hit, [0, 0, 1, 1])
    np.testing.assert_allclose(records.speed, [100.0, 10.0, 50.0, 50.0])
    angles = [42.75, 90.0, np.degrees(np.arcsin(0.8)), np.degrees(np.arcsin(0.6))]
    np.testing.assert_allclose(records.angle, angles)
    np.testing.assert_allclose(records.place, [42.0 / 90.0 * TURN, -0.1, -0.1, TURN + 0.1], 1e-4)
