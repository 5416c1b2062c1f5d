"""A calibration: its file, what it holds out, that it repeats itself, and what it refuses."""

import json
import tomllib
from dataclasses import replace

import numpy as np
import pytest
from small_pairs import small_pair

from sampler.errors import InputError
from sampler.files import json_text
from tablegen import calibrate, load_config
from tablegen.measured.evaluations import Evaluations
from tablegen.measured.records import Moments
from tablegen.measured.rows import chosen_rows

FREE = ("pair.restitution.value", "pair.resistance.value")
pytestmark = pytest.mark.usefixtures("quick")


def without(measured, **changes):
    """Measurements with other fields; the moments are copies."""
    moments = {n: Moments(m.mean.copy(), m.std.copy()) for n, m in measured.moments.items()}
    return replace(measured, **({"moments": moments} | changes))


def test_the_file_is_a_pair_that_says_how_it_was_made(tmp_path, measured):
    path = tmp_path / "my sand.toml"
    made = calibrate(measured, small_pair(), path, free=FREE, count=200, hold_out=[35.0])
    assert list(tmp_path.iterdir()) == [path]
    config = load_config(path)
    assert config == made.config
    assert config.name == "my-sand"
    text = path.read_text()
    tree = tomllib.loads(text)
    assert tree["pair"]["restitution"]["valid_speed"] == [100.0, 100.0]
    assert "measured rebounds (synthetic: simulated)" in tree["pair"]["resistance"]["source"]
    assert tree["pair"]["restitution"]["value"] == pytest.approx(made.values[0], rel=1e-6)
    for words in ("seed 1, 200 particles", "standard error", "Rows held out, predicted", "e_n_std"):
        assert words in text
    # nothing else has changed
    assert config.population == small_pair().population
    assert config.model == small_pair().model


def test_rows_that_are_held_out_are_predicted(measured):
    made = calibrate(measured, small_pair(), free=FREE, count=200, hold_out=[35.0])
    held = [number for number in made.numbers if number.held_out]
    assert {number.alpha_deg for number in held} == {35.0}
    assert {number.row for number in held} == {1}
    # 400 particles a row were measured, at a spread of at most 0.4
    for number in held:
        assert abs(number.residual) < 4.0 * np.hypot(number.predicted, number.accuracy)
    assert made.largest(held_out=True)["e_n"].row == 1
    json.loads(json_text(made.to_dict()))


def test_the_same_seed_gives_the_same_bytes_on_any_number_of_threads(tmp_path, measured):
    texts = []
    for threads in (1, 3):
        path = tmp_path / "same.toml"
        calibrate(measured, small_pair(), path, free=FREE, count=200, threads=threads)
        texts.append(path.read_bytes())
    assert texts[0] == texts[1]
    calibrate(measured, small_pair(), path, free=FREE, count=200, seed=2)
    assert path.read_bytes() != texts[0]


def test_an_interrupted_run_goes_on_to_the_same_result(tmp_path, measured, monkeypatch):
    whole, cut = tmp_path / "a" / "same.toml", tmp_path / "b" / "same.toml"
    for path in (whole, cut):
        path.parent.mkdir()
    calibrate(measured, small_pair(), whole, free=FREE, count=200)
    made, make = [], Evaluations._made

    def interrupted(self, key, x, count):
        if len(made) == 6:
            raise KeyboardInterrupt
        made.append(key)
        return make(self, key, x, count)

    with monkeypatch.context() as patch:
        patch.setattr(Evaluations, "_made", interrupted)
        with pytest.raises(KeyboardInterrupt):
            calibrate(measured, small_pair(), cut, free=FREE, count=200)
    assert not cut.exists()
    with pytest.raises(InputError, match="allowed: --resume"):
        calibrate(measured, small_pair(), cut, free=FREE, count=200)
    with pytest.raises(InputError, match="made from another configuration"):
        calibrate(measured, small_pair(), cut, free=FREE, count=201, resume=True)
    calibrate(measured, small_pair(), cut, free=FREE, count=200, resume=True)
    assert cut.read_bytes() == whole.read_bytes()
    assert list(cut.parent.iterdir()) == [cut]


def test_rows_without_speed_give_no_range_of_speeds(measured):
    data = without(measured, speed=np.full(4, np.nan))
    made = calibrate(data, small_pair(), free=FREE, count=200)
    assert made.config.pair.restitution.valid_speed is None
    assert made.config.domain.extrapolate


def test_rows_without_count_weigh_the_same(measured):
    made = calibrate(
        without(measured, count=np.full(4, np.nan)), small_pair(), free=FREE, count=200
    )
    # of means, and of spreads
    assert {number.accuracy for number in made.numbers} == {0.02, 0.05}
    assert np.isfinite(made.errors).all()


def test_a_fixed_law_keeps_its_source(measured):
    made = calibrate(measured, small_pair(0.6), free=FREE[1:], count=200)
    assert made.config.pair.restitution == small_pair(0.6).pair.restitution


def test_roughness_is_found_and_told(measured, tmp_path):
    path = tmp_path / "rough.toml"
    row = chosen_rows(measured, [2])
    how = {"free": ("wall_tilt_deg",), "count": 200, "wall_tilt_deg": 4.0}
    made = calibrate(row, small_pair(0.6, 0.3), path, **how)
    # the data are of a smooth wall
    assert made.wall_tilt_deg < 3.0
    assert made.labels == ("wall_tilt_deg",)
    assert ("draw with roughness" in path.read_text()) == (made.wall_tilt_deg > 0.0)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"hold_out": [36.0]}, "hold_out: got 36 degrees, allowed: 15, 35, 60, 90"),
        ({"hold_out": [15.0, 35.0, 60.0, 90.0]}, "hold_out: got all 4 rows, allowed: fewer"),
        ({"count": 50}, "count: got 50, allowed: 200 or more"),
        ({"free": ["pair.restitution.coefficient"]}, "free: got 'pair.restitution.coefficient'"),
        ({"wall_tilt_deg": 40.0}, "wall_tilt_deg: got 40"),
    ],
)
def test_refusals(measured, changes, said):
    with pytest.raises(InputError) as error:
        calibrate(measured, small_pair(), **({"free": FREE, "count": 200} | changes))
    assert said in str(error.value)
    assert "\n" not in str(error.value)


def test_too_few_rows(measured):
    data = without(measured)
    for one in data.moments.values():
        one.std[:] = np.nan
    data.moments["e_t"].mean[:] = np.nan
    with pytest.raises(InputError, match=r"^free: got 2 free numbers for 1 measured means and"):
        calibrate(data, small_pair(), free=FREE, count=200, hold_out=[15.0, 35.0, 60.0])


def test_spheres_have_no_spread(measured):
    weights = dict.fromkeys(("ellipsoid", "prism", "truncated-prism", "tetrahedron"), 0.0)
    spheres = small_pair(population={"shapes": weights | {"sphere": 1.0}})
    with pytest.raises(InputError, match=r"^e_n_std: got spreads, which spheres on a smooth wall"):
        calibrate(measured, spheres, free=FREE, count=200)


def test_a_law_of_the_speed_needs_one(measured):
    data = without(measured, speed=np.full(4, np.nan))
    with pytest.raises(InputError, match=r"^speed: missing for 4 of 4 rows"):
        calibrate(data, load_config("corundum-steel"), count=200)
