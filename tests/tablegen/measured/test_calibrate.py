"""A calibration: its file, held-out rows, repetition, resuming, and refusals."""

import json
import re
import tomllib
from dataclasses import replace

import numpy as np
import pytest
from synthetic_measurements import small_pair

from sampler.errors import InputError
from sampler.files import json_text
from tablegen import calibrate, load_config
from tablegen.measured.measurements import Moments
from tablegen.measured.pair_file import fit_lines
from tablegen.measured.trials import Evaluations

FREE = ("pair.restitution.value", "pair.resistance.value")
pytestmark = pytest.mark.usefixtures("quick")


def fit(measured, start=None, *output, **changes):
    return calibrate(
        measured, start or small_pair(), *output, **{"free": FREE, "count": 200} | changes
    )


def test_the_file_is_a_pair_that_says_how_it_was_made(tmp_path, measured):
    path = tmp_path / "my sand.toml"
    made = fit(measured, None, path, hold_out=[35.0])
    assert list(tmp_path.iterdir()) == [path]
    config = load_config(path)
    assert config == made.config
    assert config.name == "my-sand"
    assert config.spin
    assert config.accuracy == config.accuracy.model_validate({"preset": "compact"})
    assert config.domain.speed == (100.0, 100.0)
    assert config.domain.alpha_deg == (0.5, 90.0)
    text = path.read_text()
    tree = tomllib.loads(text)
    assert tree["pair"]["restitution"]["valid_speed"] == [100.0, 100.0]
    assert "measured rebounds (synthetic: simulated)" in tree["pair"]["resistance"]["source"]
    assert tree["pair"]["restitution"]["value"] == pytest.approx(made.values[0], rel=1e-6)
    for words in ("seed 1, 200 particles", "standard error", "Rows held out, predicted", "e_n_std"):
        assert words in text
    # all else is as before
    assert config.population == small_pair().population
    assert config.model == small_pair().model
    held = [number for number in made.numbers if number.held_out]
    assert {(number.row, number.alpha_deg) for number in held} == {(1, 35.0)}
    # 400 particles a row were measured, at a spread of at most 0.4
    for number in held:
        assert abs(number.residual) < 4.0 * np.hypot(number.predicted, number.accuracy)
    assert made.largest(held_out=True)["e_n"].row == 1
    json.loads(json_text(made.to_dict()))


def test_an_interrupted_run_goes_on_to_the_same_bytes_on_any_number_of_threads(
    tmp_path, measured, monkeypatch
):
    whole, cut = tmp_path / "a" / "same.toml", tmp_path / "b" / "same.toml"
    for path in (whole, cut):
        path.parent.mkdir()
    fit(measured, None, whole, threads=1)
    made, make = [], Evaluations._made

    def interrupted(self, key, x, count):
        if len(made) == 6:
            raise KeyboardInterrupt
        made.append(key)
        return make(self, key, x, count)

    with monkeypatch.context() as patch:
        patch.setattr(Evaluations, "_made", interrupted)
        with pytest.raises(KeyboardInterrupt):
            fit(measured, None, cut)
    assert not cut.exists()
    with pytest.raises(InputError, match="allowed: --resume"):
        fit(measured, None, cut)
    with pytest.raises(InputError, match="made from another configuration"):
        fit(measured, None, cut, count=201, resume=True)
    fit(measured, None, cut, threads=3, resume=True)
    assert cut.read_bytes() == whole.read_bytes()
    assert list(cut.parent.iterdir()) == [cut]
    fit(measured, None, cut, seed=2)
    assert cut.read_bytes() != whole.read_bytes()


def test_rows_without_speed_or_count(measured):
    unknown = np.full(4, np.nan)
    made = fit(replace(measured, speed=unknown, count=unknown))
    assert made.config.pair.restitution.valid_speed is None
    assert made.config.domain.extrapolate
    # assumed for means and for spreads
    assert {number.accuracy for number in made.numbers} == {0.01, 0.015, 0.025, 0.0375}
    assert np.isfinite(made.errors).all()


def test_a_fixed_law_keeps_its_source_and_roughness_is_found(measured, tmp_path):
    path = tmp_path / "rough.toml"
    free, row = ("wall_tilt_deg",), measured.rows([2])
    made = fit(row, small_pair(0.6, 0.3), path, free=free, wall_tilt_deg=4.0)
    assert made.config.pair.restitution == small_pair(0.6).pair.restitution
    # the data are of a smooth wall
    assert made.wall_tilt_deg < 3.0
    assert made.labels == ("wall_tilt_deg",)
    assert ("draw with roughness" in path.read_text()) == (made.wall_tilt_deg > 0.0)


def test_spreads(measured):
    def fitted(part, spreads):
        moments = {n: Moments(m.mean, part * m.std) for n, m in measured.moments.items()}
        made = fit(replace(measured, moments=moments), spreads=spreads)
        return made, max([one.excess for one in made.fitted(spreads=True)], default=0.0)

    (above, excess), (ignored, none) = fitted(2.0, "upper-bound"), fitted(2.0, "ignore")
    # an upper bound above what is simulated spoils no mean
    assert not above.missed
    assert excess <= 1.0
    assert none == 0.0
    np.testing.assert_allclose(above.values, ignored.values, atol=0.03)
    assert above.of_means[1] < 0.5 * above.of_means[0]
    assert "worse in the means than its start" not in "".join(fit_lines(above))
    assert "worse in the means" in "".join(fit_lines(replace(above, of_means=(1.0, 2.0))))
    angular = replace(above, config=load_config("start-tabulated"))
    far = replace(angular, numbers=tuple(replace(one, simulated=9.0) for one in above.numbers))
    freed = replace(far, labels=("population.shapes.ellipsoid", *far.labels[1:]))
    hint, made = "free population.shapes.ellipsoid", (angular, far, freed)
    assert [hint in "".join(fit_lines(one)) for one in made] == [False, True, False]
    assert fitted(2.0, "fit")[1] > 1.0
    assert fitted(0.5, "upper-bound")[1] > 1.0


def test_a_cost_is_said_before(measured, capsys):
    fit(measured, progress=True)
    first = capsys.readouterr().err.splitlines()[0]
    assert re.fullmatch(r"tablegen: [0-9]+ to [0-9]+ s of CPU time", first)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"hold_out": [36.0]}, r"^hold_out: got 36 degrees, allowed: 15, 35, 60, 90$"),
        ({"hold_out": [15.0, 35.0, 60.0, 90.0]}, r"^hold_out: got all 4 rows, allowed: fewer"),
        ({"count": 50}, r"^count: got 50, allowed: 200 or more$"),
        ({"wall_tilt_deg": 40.0}, r"^wall_tilt_deg: got 40"),
    ],
)
def test_refusals(measured, changes, said):
    with pytest.raises(InputError, match=said):
        fit(measured, **changes)


def test_measurements_and_pairs_that_do_not_go_together(measured):
    few = measured.rows([0])
    moments = {name: Moments(m.mean, np.nan * m.std) for name, m in few.moments.items()}
    moments["e_t"] = Moments(np.array([np.nan]), np.array([np.nan]))
    with pytest.raises(InputError, match=r"^free: got 2 free numbers for 1 measured means and"):
        fit(replace(few, moments=moments))
    weights = dict.fromkeys(("ellipsoid", "prism", "truncated-prism", "tetrahedron"), 0.0)
    spheres = small_pair(population={"shapes": weights | {"sphere": 1.0}})
    with pytest.raises(InputError, match=r"^e_n_std: got spreads, which spheres on a smooth wall"):
        fit(measured, spheres)
    with pytest.raises(InputError, match=r"^synthetic: got 401 rows to fit, allowed: up to 400"):
        fit(measured.rows([0] * 401))
    data = replace(measured, speed=np.full(4, np.nan))
    with pytest.raises(InputError, match=r"^speed: missing for 4 of 4 rows"):
        calibrate(data, load_config("corundum-steel"), count=200)
