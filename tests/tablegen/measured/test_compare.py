"""Simulated rebounds beside measured ones: deviations, errors, speeds; text, JSON and picture."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from sampler.errors import InputError
from tablegen.config.config import load_config
from tablegen.measured.compare import compare
from tablegen.measured.comparison_picture import comparison_picture
from tablegen.measured.comparison_text import comparison_json, comparison_text
from tablegen.measured.reader import parse_measurements, read_measurements
from tablegen.measured.simulated_moments import SimulatedRows

GRANT, CORUNDUM = load_config("grant-tabakoff-1975"), load_config("corundum-steel")

#: Three rows, of which one has no e_t and one no speed.
MEASURED = parse_measurements(
    "alpha_deg,speed,e_n,e_n_std,e_t,count,source\n"
    "30,100,0.6,0.2,0.6,400,made up\n"
    "60,100,0.3,0.1,,,made up\n"
    "80,,0.2,,0.5,,made up\n",
    "made-up",
    "made-up.csv",
)
COUNT = 500
FOUND = compare(GRANT, MEASURED, count=COUNT, seed=3)


def test_what_is_put_side_by_side():
    rows = SimulatedRows(GRANT.pair, GRANT.population, [30, 60, 80], 100.0, seed=3)
    ours = rows.moments(COUNT)
    assert list(FOUND.means) == list(FOUND.spreads) == ["e_n", "e_t"]
    mean, spread = FOUND.means["e_n"], FOUND.spreads["e_n"]
    np.testing.assert_array_equal(mean.simulated, ours.mean["e_n"])
    np.testing.assert_array_equal(spread.simulated_error, ours.std_error["e_n"])
    np.testing.assert_array_equal(mean.measured, [0.6, 0.3, 0.2])
    np.testing.assert_allclose(mean.deviation, ours.mean["e_n"] - [0.6, 0.3, 0.2])
    # 400 particles of a spread of 0.2
    np.testing.assert_allclose(mean.measured_error, [0.01, np.nan, np.nan])
    np.testing.assert_allclose(spread.measured_error, [0.01 / math.sqrt(2), np.nan, np.nan])
    error = math.hypot(0.01, ours.mean_error["e_n"][0])
    np.testing.assert_allclose(mean.in_errors, [mean.deviation[0] / error, np.nan, np.nan])
    assert np.isnan(FOUND.means["e_t"].deviation[1])
    assert np.isnan(FOUND.spreads["e_t"].deviation).all()


def test_speeds():
    assert FOUND.speed_independent
    np.testing.assert_array_equal(FOUND.speed, 100.0)
    given = compare(CORUNDUM, MEASURED, count=10, speed=250.0)
    np.testing.assert_array_equal(given.speed, [100.0, 100.0, 250.0])
    with pytest.raises(InputError, match=r"^speed: missing for 1 of 3 rows of made-up, allowed: "):
        compare(CORUNDUM, MEASURED, count=10)


def test_shapes_tilt_and_names():
    prisms = compare(GRANT, "grant-tabakoff-1975", count=50, shape="prism", wall_tilt_deg=5.0)
    only = GRANT.population.restricted_to("prism")
    rows = SimulatedRows(GRANT.pair, only, range(10, 91, 10), 100.0, seed=1, wall_tilt_deg=5.0)
    ours = rows.moments(50)
    np.testing.assert_array_equal(prisms.means["e_n"].simulated, ours.mean["e_n"])
    assert prisms.measured.name == "grant-tabakoff-1975"
    with pytest.raises(InputError, match=r"^shape: got 'cube'"):
        compare(GRANT, MEASURED, shape="cube")


def test_sliding_spheres_of_kharaz():
    """Nothing fitted: measured rebounds where a sphere slides throughout, by Coulomb's law.

    Twice the friction is refused.
    """
    off = []
    for friction in (0.092, 0.184):
        resistance = {"law": "coulomb", "static": friction, "dynamic": friction, "source": "MFiX"}
        restitution = {"law": "constant", "value": 0.98, "source": "nearly elastic"}
        changes = {"pair": {"restitution": restitution, "resistance": resistance}}
        found = compare(GRANT.with_changes(changes), "kharaz-2001", shape="sphere", count=2)
        rows = found.measured.alpha_deg < 55.0
        off.append([np.nanmax(abs(m.deviation[rows])) for m in found.means.values()])
    # what reading the points off the figures may add
    bounds = (0.01, 1.0, 0.03)
    assert list(found.means) == ["e_t", "rebound_angle_deg", "omega_z"]
    assert (np.array(off[0]) < bounds).all()
    assert (np.array(off[1]) > bounds).all()


def test_text_has_every_number():
    text = comparison_text(FOUND)
    lines = text.splitlines()
    assert "grant-tabakoff-1975 (all shapes; wall smooth) beside made-up" in lines[0]
    assert max(map(len, lines)) <= 120
    start = next(k for k, line in enumerate(lines) if line.startswith("e_n"))
    rows = [line.split() for line in lines[start + 2 : start + 5]]
    assert [row[:3] for row in rows] == [
        ["30", "100", "0.600"],
        ["60", "100", "0.300"],
        ["80", "any", "0.200"],
    ]
    mean = FOUND.means["e_n"]
    assert rows[0][3] == f"{mean.simulated[0]:.3f}"
    assert rows[0][6] == f"{mean.in_errors[0]:.1f}"
    assert rows[2][6] == "-"
    off = FOUND.spreads["e_n"].deviation
    rms = math.sqrt(np.nanmean(off**2))
    assert f"  spread: rms deviation {rms:.3f}, largest {np.nanmax(abs(off)):.3f}" in lines
    # no column for what nobody knows
    section = text[text.index("e_t,") :]
    assert "in errors" not in section.partition("+-:")[0]
    assert "spread" not in section


def test_json_has_every_number_and_null_for_none():
    found = json.loads(comparison_json(FOUND))
    assert [row["alpha_deg"] for row in found["rows"]] == [30.0, 60.0, 80.0]
    assert [row["speed_stated"] for row in found["rows"]] == [True, True, False]
    first, last = found["rows"][0], found["rows"][2]
    mean = FOUND.means["e_n"]
    assert first["e_n"]["mean"]["deviation"] == mean.deviation[0]
    assert first["e_n"]["mean"]["deviation_over_error"] == mean.in_errors[0]
    assert first["source"] == "made up"
    assert last["e_n"]["mean"]["deviation_over_error"] is None
    assert last["e_n"]["spread"]["measured"] is None
    assert last["e_n"]["spread"]["simulated"] == FOUND.spreads["e_n"].simulated[2]
    assert found["rows"][1]["e_t"]["mean"]["measured"] is None
    summary = found["summary"]["e_t"]
    assert summary["mean_largest_deviation"] == np.nanmax(abs(FOUND.means["e_t"].deviation))
    assert summary["spread_rms_deviation"] is None


def test_pictures_are_files_of_their_kind_and_the_same_each_time():
    pytest.importorskip("matplotlib")
    assert comparison_picture(FOUND, "picture.png").data.startswith(b"\x89PNG")
    picture = comparison_picture(FOUND, "picture.pdf")
    assert picture.data.startswith(b"%PDF")
    assert picture.media_type == "application/pdf"
    assert comparison_picture(FOUND, "picture.pdf").data == picture.data


def test_picture_draws_what_was_measured_and_what_was_simulated(monkeypatch):
    pytest.importorskip("matplotlib")
    drawn = []

    def keep(figure, *words):
        drawn.append(figure)

    monkeypatch.setattr("tablegen.measured.comparison_picture.written", keep)
    comparison_picture(replace(FOUND, speed=np.array([100.0, 100.0, 50.0])), "x.svg")
    first, second = drawn[0].axes
    assert "normal" in first.get_ylabel()
    assert "tangential" in second.get_ylabel()
    label, mean, spread = "simulated, grant-tabakoff-1975", FOUND.means["e_n"], FOUND.spreads["e_n"]
    labels = {line.get_label(): line for line in first.lines}
    np.testing.assert_array_equal(
        labels[f"{label}, 100 m/s"].get_xydata(),
        [[30, mean.simulated[0]], [60, mean.simulated[1]]],
    )
    (points,) = first.containers
    np.testing.assert_array_equal(points.lines[0].get_ydata(), mean.measured)
    bars = points.lines[2][0].get_segments()
    np.testing.assert_allclose(bars[0][:, 1], [0.4, 0.8])
    np.testing.assert_allclose(bars[2][:, 1], 0.2)  # no spread was measured
    bands = {band.get_label(): band.get_paths()[0].vertices for band in first.collections}
    ys = bands[f"{label}, 100 m/s, ± 1 standard deviation"][:, 1]
    np.testing.assert_allclose(ys.max(), (mean.simulated + spread.simulated)[:2].max())


def test_measurements_without_any_spread_have_no_bars():
    pytest.importorskip("matplotlib")
    forder = compare(GRANT, read_measurements("forder-1998"), count=20)
    assert comparison_picture(forder, "x.png").data
    assert "spread" not in comparison_text(forder)
