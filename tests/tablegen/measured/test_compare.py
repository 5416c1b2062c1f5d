"""Simulated rebounds beside measured ones: deviations, errors, speeds; text, JSON and picture."""

import json
import math

import numpy as np
import pytest
from refusals import refused

from sampler.files import json_text
from tablegen.config.config import load_config
from tablegen.measured.compare import compare, comparison_text, comparison_tree
from tablegen.measured.pictures import comparison_picture
from tablegen.measured.reader import parse_measurements
from tablegen.measured.simulated_rows import SimulatedRows

GRANT, CORUNDUM = load_config("grant-tabakoff-1975"), load_config("corundum-steel")

#: One row has no e_t, another no speed.
MEASURED = parse_measurements(
    "alpha_deg,speed,e_n,e_n_std,e_t,count,source\n"
    "30,100,0.6,0.2,0.6,400,made up\n"
    "60,100,0.3,0.1,,,made up\n"
    "80,,0.2,,0.5,,made up\n",
    "made-up",
    "made-up.csv",
)


@pytest.fixture(scope="module")
def comparison():
    return compare(GRANT, MEASURED, count=200, seed=3)


def test_measured_and_simulated_numbers(comparison):
    speeds = np.full(3, 100.0)
    rows = SimulatedRows(GRANT, MEASURED.alpha_deg, speeds, seed=3)
    ours = rows.moments(200)
    assert list(comparison.means) == list(comparison.spreads) == ["e_n", "e_t"]
    mean, spread = comparison.means["e_n"], comparison.spreads["e_n"]
    np.testing.assert_array_equal(mean.simulated, ours.mean["e_n"])
    np.testing.assert_array_equal(spread.simulated_error, ours.std_error["e_n"])
    np.testing.assert_allclose(mean.deviation, ours.mean["e_n"] - [0.6, 0.3, 0.2])
    # 400 particles of a spread of 0.2
    np.testing.assert_allclose(mean.measured_error, [0.01, np.nan, np.nan])
    np.testing.assert_allclose(spread.measured_error, [0.01 / math.sqrt(2), np.nan, np.nan])
    error = math.hypot(0.01, ours.mean_error["e_n"][0])
    np.testing.assert_allclose(mean.in_errors, [mean.deviation[0] / error, np.nan, np.nan])
    assert np.isnan(comparison.means["e_t"].deviation[1])
    assert np.isnan(comparison.spreads["e_t"].deviation).all()


def test_speeds(comparison):
    np.testing.assert_array_equal(comparison.speed, 100.0)
    given = compare(CORUNDUM, MEASURED, count=10, speed=250.0)
    np.testing.assert_array_equal(given.speed, [100.0, 100.0, 250.0])
    refused("speed", compare, CORUNDUM, MEASURED, count=10)


def test_sliding_spheres_of_kharaz():
    """Nothing fitted: measured rebounds where a sphere slides throughout, by Coulomb's law.

    Twice the friction is refused.
    """
    off = []
    for friction in (0.092, 0.184):
        resistance = {"law": "coulomb", "static": friction, "dynamic": friction, "source": "MFiX"}
        restitution = {"law": "constant", "value": 0.98, "source": "nearly elastic"}
        changes = {"pair": {"restitution": restitution, "resistance": resistance}}
        comparison = compare(GRANT.with_changes(changes), "kharaz-2001", shape="sphere", count=2)
        rows = comparison.measured.alpha_deg < 55.0
        off.append([np.nanmax(abs(m.deviation[rows])) for m in comparison.means.values()])
    # reading the points off the figures may add this
    bounds = (0.01, 1.0, 0.03)
    assert list(comparison.means) == ["e_t", "rebound_angle_deg", "omega_z"]
    assert (np.array(off[0]) < bounds).all()
    assert (np.array(off[1]) > bounds).all()


def test_the_shipped_spheres_are_those_of_kharaz():
    comparison = compare(load_config("kharaz-2001"), "kharaz-2001", count=2)
    for name, allowed in {"e_t": 0.03, "omega_z": 0.03, "rebound_angle_deg": 1.0}.items():
        off = comparison.means[name].deviation
        assert np.isfinite(off).sum() >= 7
        assert np.nanmax(np.abs(off)) < allowed


def test_text_has_every_number(comparison):
    lines, mean = comparison_text(comparison).splitlines(), comparison.means["e_n"]
    start = next(k for k, line in enumerate(lines) if line.startswith("e_n"))
    for k, line in enumerate(lines[start + 2 : start + 5]):
        angle, speed, *numbers = line.split()
        assert (float(angle), float(speed)) == (MEASURED.alpha_deg[k], 100.0)
        assert numbers[:2] == [f"{mean.measured[k]:.3f}", f"{mean.simulated[k]:.3f}"]
        assert numbers[4] == ("-" if k else f"{mean.in_errors[k]:.1f}")


def test_json_has_every_number_and_null_for_none(comparison):
    tree = json.loads(json_text(comparison_tree(comparison)))
    assert [row["speed_stated"] for row in tree["rows"]] == [True, True, False]
    first, last = tree["rows"][0]["e_n"], tree["rows"][2]["e_n"]
    assert first["mean"]["deviation"] == comparison.means["e_n"].deviation[0]
    assert first["mean"]["deviation_over_error"] == comparison.means["e_n"].in_errors[0]
    assert last["mean"]["deviation_over_error"] is last["spread"]["measured"] is None
    summary = tree["summary"]["e_t"]
    assert summary["mean_largest_deviation"] == np.nanmax(abs(comparison.means["e_t"].deviation))
    assert summary["spread_rms_deviation"] is None


@pytest.fixture
def drawn_figures(monkeypatch):
    """Return the figures that are drawn, before they become files."""
    pytest.importorskip("matplotlib")
    figures = []
    monkeypatch.setattr(
        "tablegen.measured.pictures.make_picture", lambda figure, *_: figures.append(figure)
    )
    return figures


def panels_by_label(figure):
    return {axes.get_ylabel().split(" $")[0]: axes for axes in figure.axes}


def test_picture_draws_measured_and_simulated_numbers(comparison, drawn_figures):
    comparison_picture(comparison, "x.svg")
    axes, mean = panels_by_label(drawn_figures[0]), comparison.means["e_n"]
    assert set(axes) == {
        "mean normal restitution",
        "standard deviation of\nnormal restitution",
        "mean tangential restitution",
    }
    axes = axes["mean normal restitution"]
    np.testing.assert_array_equal(axes.lines[0].get_ydata(), mean.simulated)
    (points,) = axes.containers
    np.testing.assert_array_equal(points.lines[0].get_ydata(), mean.measured)
    bars = points.lines[2][0].get_segments()
    np.testing.assert_allclose(bars[0][:, 1], [0.59, 0.61])  # 0.2 over the root of 400
    np.testing.assert_allclose(bars[2][:, 1], 0.2)  # neither a spread nor a count


def test_picture_has_one_look_for_each_speed_and_no_panel_without_data(drawn_figures):
    rows = [f"{a},{v},0.5,0.6,4,50,s" for v in (40, 41, 80) for a in (30, 60)]
    columns = "alpha_deg,speed,e_n,e_t,out_of_plane_deg_std,count,source"
    text = "\n".join([columns, *rows])
    comparison_picture(compare(GRANT, parse_measurements(text, "m", "m.csv"), count=2), "x.svg")
    axes = panels_by_label(drawn_figures[0])
    assert len(axes) == 3
    assert "standard deviation of\nangle out of the impact plane [°]" in axes
    # 40 and 41 m/s are one speed
    words = ["simulated, about 40.5 m/s", "simulated, 80 m/s"]
    for one in axes.values():
        assert [line.get_label() for line in one.lines if "sim" in line.get_label()] == words
        colours = [points.lines[0].get_color() for points in one.containers]
        assert colours == [line.get_color() for line in one.lines if "sim" in line.get_label()]
        assert len(set(colours)) == 2
    (legend,) = drawn_figures[0].legends
    assert len(legend.get_texts()) == 4
