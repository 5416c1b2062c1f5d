"""Study `openfoam_bend`: the impacts that OpenFOAM wrote."""

import numpy as np
import openfoam_bend


def write_impacts(case, rows):
    for (time, wall), impacts in rows.items():
        folder = case / "postProcessing/lagrangian/kinematicCloud/impacts" / time
        folder.mkdir(parents=True, exist_ok=True)
        text = "# Time currentProc (Px Py Pz) origId (Ux Uy Uz)\n"
        for when, place, parcel, velocity in impacts:
            triples = [" ".join(map(str, triple)) for triple in (place, velocity)]
            text += f"{when} 0 ({triples[0]}) {parcel} ({triples[1]})\n"
        (folder / f"{wall}.post").write_text(text, encoding="ascii")


def test_openfoam_impacts_are_read_in_the_order_of_time(tmp_path):
    outer, centre, turn = openfoam_bend.OUTER, openfoam_bend.CENTRE, openfoam_bend.TURN
    rows = {
        ("0.001", "outer"): [
            # 42 degrees into the bend, on the face around 42.75 degrees
            (0.009, (outer * 0.66913, centre - outer * 0.74314, 0.02), 7, (100.0, 0.0, 0.0)),
            (0.009, (-0.1, 0.0, 0.02), 7, (100.0, 50.0, 0.0)),  # leaves the wall already
        ],
        ("0.002", "outer"): [(0.013, (0.2, 0.3, 0.02), 7, (30.0, 40.0, 0.0))],
        ("0.002", "inner"): [(0.010, (-0.1, 0.1, 0.05), 8, (0.0, 10.0, 0.0))],
        ("0.002", "sides"): [(0.011, (-0.1, 0.05, 0.1), 8, (0.0, 30.0, 40.0))],
    }
    write_impacts(tmp_path, rows)
    impacts, _, _, wall = openfoam_bend.read_impacts(tmp_path)
    assert [openfoam_bend.WALLS[k] for k in wall] == ["outer", "inner", "sides", "outer"]
    np.testing.assert_array_equal(impacts.group, [7, 8, 8, 7])
    np.testing.assert_array_equal(impacts.hit, [0, 0, 1, 1])
    np.testing.assert_allclose(impacts.speed, [100.0, 10.0, 50.0, 50.0])
    angles = [42.75, 90.0, np.degrees(np.arcsin(0.8)), np.degrees(np.arcsin(0.6))]
    np.testing.assert_allclose(np.degrees(impacts.angle), angles)
    np.testing.assert_allclose(impacts.place, [42 / 90 * turn, -0.1, -0.1, turn + 0.1], 1e-4)
