"""A calibration: its file, its choice of grains, given forms of the laws, and refusals."""

import json
import tomllib
from dataclasses import replace

import numpy as np
import pytest
from refusals import refused
from synthetic_measurements import SOURCE, measured_from, small_pair, some_rows

from sampler.files import json_text
from tablegen import calibrate, load_config
from tablegen.config.grains import GRAINS
from tablegen.measured import smoothest
from tablegen.measured.fit_text import fit_lines
from tablegen.measured.measurements import Moments
from tablegen.measured.pictures import fit_picture

FREE = ("pair.restitution.value", "pair.resistance.value")
pytestmark = pytest.mark.usefixtures("quick")


def without_spreads(data):
    moments = {name: Moments(m.mean, np.nan * m.std) for name, m in data.moments.items()}
    return replace(data, moments=moments)


def with_mean(data, name, means):
    changed = Moments(np.array(means), data.moments[name].std)
    return replace(data, moments={**data.moments, name: changed})


def test_a_given_form_finds_its_numbers_again_and_says_how_it_was_made(tmp_path, measured):
    path = tmp_path / "my sand.toml"
    calibration = calibrate(measured, path, start=small_pair(), free=FREE)
    assert list(tmp_path.iterdir()) == [path]
    config = load_config(path)
    assert config == calibration.config
    assert (config.name, config.spin) == ("my-sand", True)
    assert (config.domain.speed, config.domain.alpha_deg) == ((100.0, 100.0), (0.05, 90.0))
    tree = tomllib.loads(path.read_text())
    assert tree["pair"]["restitution"]["valid_speed"] == [100.0, 100.0]
    assert "measured rebounds (synthetic: simulated)" in tree["pair"]["resistance"]["source"]
    assert config.spin_targets.chain_spin == 0.2
    assert config.population == small_pair().population
    # 4,000 particles a row were measured, and few are simulated
    np.testing.assert_allclose(calibration.chosen.values, [0.6, 0.3], atol=0.05)
    assert not calibration.missed
    assert 0.0 < calibration.chosen.errors.max() < 0.1
    json.loads(json_text(calibration.to_dict()))
    # laws without knots, and a second speed at which only e_n was measured
    numbers = calibration.chosen.numbers
    faster = tuple(replace(one, speed=200.0) for one in numbers if one.column == "e_n")
    at_two_speeds = replace(calibration.chosen, numbers=(*numbers, *faster))
    picture = fit_picture(replace(calibration, chosen=at_two_speeds), "fit.svg")
    assert b"simulated, 200 m/s" in picture


def test_grains_are_tried_and_the_spreads_choose(tmp_path, measured):
    calibration = calibrate(measured, tmp_path / "a.toml", threads=1)
    assert [fit.grains for fit in calibration.fits] == list(GRAINS)
    assert calibration.chosen.misfit == min(fit.misfit for fit in calibration.fits)
    # what grains far from and close to a sphere declare, as their tables reach
    correlations = [fit.config.accuracy.correlation_error for fit in calibration.fits]
    assert correlations == [0.06, 0.06, 0.06, 0.06, 0.5]
    lines = list(fit_lines(calibration))
    assert " grains give all 7; the worst is " in lines[0]
    assert lines[1].startswith("spreads: ")
    assert lines[-1].startswith("not determined by the means: restitution at 5°")
    assert np.isnan(calibration.chosen.errors[0])
    assert sum("chosen" in line for line in lines) == 1
    again = calibrate(measured, tmp_path / "b" / ".." / "a.toml", threads=2)
    assert again.config.text == calibration.config.text


def test_without_spreads_or_speeds(measured):
    unknown = np.full(4, np.nan)
    data = replace(without_spreads(measured), speed=unknown, count=unknown)
    calibration = calibrate(data, grains="rounded")
    assert calibration.config.pair.restitution.valid_speed is None
    assert calibration.config.domain.extrapolate
    assert [one.tolerance for one in calibration.chosen.means if one.column == "e_n"] == [0.02] * 4
    assert np.isnan(calibration.chosen.spread_distance)


def test_several_speeds_have_a_table_of_restitution(measured):
    twice = some_rows(measured, [0, 1, 2, 3] * 2)
    slower = np.repeat([1.0, 0.8], 4) * twice.moments["e_n"].mean
    data = replace(with_mean(twice, "e_n", slower), speed=np.repeat([50.0, 150.0], 4))
    calibration = calibrate(data, grains="well-rounded")
    assert not calibration.missed
    law = calibration.config.pair.restitution
    assert (law.speed, law.valid_speed) == ((50.0, 150.0), (50.0, 150.0))
    assert calibration.config.domain.speed == (50.0, 150.0)
    values = np.array(law.value)
    assert (values[1:5, 1] < values[1:5, 0]).all()
    assert np.abs(np.diff(values, 2, axis=0)).max() < 0.25


def test_spheres_give_restitution_and_friction():
    """Restitution and friction are those of the rows that slide; others stick and spring back."""
    law = {"law": "coulomb", "static": 0.2, "dynamic": 0.2, "tangential_restitution": [0.4]}
    weights = dict.fromkeys(("ellipsoid", "prism", "truncated-prism", "tetrahedron"), 0.0)
    laws = {"restitution": {"law": "constant", "value": 0.9, **SOURCE}, "resistance": law | SOURCE}
    truth = small_pair(pair=laws, population={"shapes": weights | {"sphere": 1.0}})
    data = without_spreads(measured_from(truth, (10.0, 30.0, 50.0, 70.0, 80.0), 2, seed=1))
    start = truth.with_changes(
        {"pair": {"restitution": {"value": 0.6}, "resistance": {"static": 0.4, "dynamic": 0.3}}}
    )
    calibration = calibrate(data, start=start)
    assert calibration.chosen.labels == (
        "pair.restitution.value",
        "pair.resistance.dynamic",
        "pair.resistance.tangential_restitution[0]",
    )
    np.testing.assert_allclose(calibration.chosen.values, [0.9, 0.2, 0.4], atol=0.03)
    refused("free", calibrate, data, start=start, free=["pair.resistance.static"])


def test_spheres_are_fitted_from_their_measurements_alone():
    calibration = calibrate("kharaz-2001", grains="kharaz-2001")
    assert not calibration.missed
    assert calibration.config.pair.resistance.law == "coulomb"
    assert max(abs(one.residual) for one in calibration.chosen.means if one.column == "e_t") < 0.03
    assert fit_picture(calibration, "fit.png").startswith(b"\x89PNG")


def test_angles_from_the_normal_and_rows_that_no_grains_hold(measured, monkeypatch):
    monkeypatch.setattr(smoothest, "_STEPS", 2)  # no search would hold them
    rows = some_rows(measured, [0, 1, 2])
    risen = with_mean(rows, "e_n", (0.3, 0.45, 0.6))
    turned = calibrate(risen, start=small_pair(), free=FREE)
    assert "if angles are from the normal, give 90 - angle" in turned.advice
    calibration = calibrate(with_mean(rows, "e_t", (0.9, 0.1, 0.9)), grains="subrounded")
    assert calibration.missed
    verdict = "the laws do not give all means: subrounded grains come nearest, but miss"
    assert verdict in "\n".join(fit_lines(calibration))
    assert "35 degrees and 100 m/s" in calibration.advice


@pytest.mark.parametrize(
    ("field", "changes"),
    [
        ("grains", {"grains": "round"}),
        ("free", {"free": ["pair.restitution.value"]}),
        ("free", {"start": small_pair(), "free": ["pair.x"]}),
        ("seed", {"start": load_config("corundum-steel"), "seed": -1}),
    ],
)
def test_refusals(measured, field, changes):
    refused(field, calibrate, measured, **changes)


def test_rows_that_cannot_be_fitted(measured):
    refused("synthetic", calibrate, some_rows(measured, [0] * 401))
    data = replace(measured, speed=np.full(4, np.nan))
    refused("speed", calibrate, data, start=load_config("corundum-steel"))
    nothing = {name: Moments(np.nan * m.mean, m.std) for name, m in measured.moments.items()}
    refused("synthetic", calibrate, replace(measured, moments=nothing))
