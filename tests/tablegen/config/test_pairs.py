"""Material pairs in files: every law is read, checked, turned into kernel arguments and a table."""

import hashlib
import json
import math
import re
import tomllib
from typing import get_args

import numpy as np
import pytest
from command_line import SIMULATE, flags
from contact_law_samples import RESISTANCE, RESTITUTION, SOURCE
from pydantic import TypeAdapter
from tiny_tables import ROUGH

import sampler
from sampler.compilation.jit import kernel
from sampler.errors import InputError
from sampler.files.locate import data_directory, find_measurements
from sampler.formats.channels import STATE
from tablegen.commands.main import main
from tablegen.config.config import load_config, parse_config
from tablegen.config.pairs import ResistanceLaw, RestitutionLaw
from tablegen.measured.compare import compare
from tablegen.model.contact_laws import restitution
from tablegen.tables.axes import make_axes
from tablegen.tables.generate import generate

# called from Python here
restitution = kernel(restitution)

SPEEDLESS = {
    "polynomial": RESTITUTION["polynomial"],
    "constant": RESTITUTION["constant"],
    "one speed": RESTITUTION["tabulated"] | {"speed": [50.0], "value": [[0.9], [0.6], [0.4]]},
}
#: Pairs fitted to published mean laws, whose measured range of speeds is not known.
FITTED = ("forder-1998", "grant-tabakoff-1975")


def with_laws(restitution=None, resistance=None, **changes):
    """The shipped pair with other laws, valid where it is."""
    pair = {}
    if restitution is not None:
        pair["restitution"] = {"valid_speed": [50.0, 300.0]} | SOURCE | restitution
    if resistance is not None:
        pair["resistance"] = SOURCE | resistance
    return load_config("corundum-steel").with_changes({"pair": pair, **changes})


class TestReading:
    @pytest.mark.parametrize("law", RESTITUTION.values(), ids=RESTITUTION)
    def test_text_stands_alone(self, law):
        config = with_laws(law, {"law": "constant", "value": 0.5})
        assert parse_config(config.text, "stored") == config
        stored = tomllib.loads(config.text)["pair"]["restitution"]
        assert stored == {"valid_speed": [50.0, 300.0]} | SOURCE | law

    def test_exponential_arguments(self):
        law = with_laws(RESTITUTION["exponential"]).pair.kernel_arguments()
        assert (law.coefficient, law.exponent, law.strength, law.factor) == (0.2, 0.5, 1.0, 1.0)

    @pytest.mark.parametrize(
        ("law", "expected"),
        [
            # a_nc at 30 degrees and 100 m/s, by hand
            ("exponential", 1.0 - (1.0 - math.exp(-2.0)) * 0.5),
            ("polynomial", 0.993 - 1.76 * 0.5235988 + 1.56 * 0.2741557 - 0.49 * 0.1435476),
            ("constant", 0.6),
            ("power", 0.5 * 2.0**0.25),
            # angle 4/7 of the way from 10 to 45 degrees, speed 1/3 of the way from 50 to 200 m/s
            ("tabulated", (3.0 * (2 * 0.9 + 0.8) + 4.0 * (2 * 0.6 + 0.5)) / 21.0),
        ],
    )
    def test_a_law_in_a_file_is_the_law_in_the_kernel(self, law, expected):
        arguments = with_laws(RESTITUTION[law]).pair.kernel_arguments()
        sine = math.sin(math.radians(30.0))
        assert restitution(arguments, 100.0, sine) == pytest.approx(expected, rel=1e-6)

    def test_resistance_laws(self):
        same = with_laws(resistance={"law": "exponential-orientation", "strength": 0.5})
        assert (same.pair.resistance.strength, same.pair.resistance.factor) == (0.5, 1.0)
        free = with_laws(resistance={"law": "constant", "value": 0.0})
        assert free.pair.kernel_arguments().factor == 0.0


class TestRegistry:
    """A law is complete: record, kernel, sample for these tests, and row of the page."""

    PAGE = (data_directory() / "LAWS.md").read_text(encoding="utf-8")
    KINDS = (
        ("restitution", RestitutionLaw, RESTITUTION),
        ("resistance", ResistanceLaw, RESISTANCE),
    )

    @pytest.mark.parametrize(("kind", "records", "samples"), KINDS)
    def test_every_law_has_a_kernel_and_a_sample(self, kind, records, samples):
        laws = [
            TypeAdapter(records).validate_json(json.dumps(law | SOURCE)) for law in samples.values()
        ]
        assert {type(law) for law in laws} == set(get_args(records))
        codes = [law.kernel_entries()[f"{kind}_law"] for law in laws]
        assert sorted(codes) == list(range(len(codes)))

    @pytest.mark.parametrize(("kind", "records", "samples"), KINDS)
    def test_every_law_has_a_row_with_its_fields_on_the_page(self, kind, records, samples):
        section = self.PAGE.partition(f"## `[pair.{kind}]`")[2].partition("\n## ")[0]
        rows = dict(re.findall(r'^\| `"([^"]+)"` \|(.*)$', section, re.M))
        fields = {law["law"]: law.keys() - {"law"} for law in samples.values()}
        assert rows.keys() == fields.keys()
        for law, names in fields.items():
            assert all(f"`{name}`" in rows[law] for name in names), law


def test_law_without_a_source_is_refused():
    law = {"restitution": RESTITUTION["constant"]}
    with pytest.raises(InputError, match=r"pair\.restitution\.source: missing, allowed: "):
        load_config("corundum-steel").with_changes({"pair": law})


def test_range_to_the_last_bit_is_not_refused():
    # zero at normal impact, where rounding leaves -1e-16
    with_laws({"law": "polynomial", "coefficients": [1.0, -2.0 / math.pi]})


class TestValidity:
    def test_law_without_a_range_must_be_extrapolated(self):
        law = {"restitution": RESTITUTION["constant"] | SOURCE}
        with pytest.raises(InputError) as caught:
            load_config("corundum-steel").with_changes(
                {"pair": law, "domain": {"extrapolate": False}}
            )
        assert str(caught.value) == (
            "corundum-steel, changed: domain.extrapolate: got false, allowed: true, because the "
            "restitution law states no validity range (valid_speed)"
        )
        asked = {"pair": law, "domain": {"extrapolate": True}}
        config = load_config("corundum-steel").with_changes(asked)
        assert config.pair.restitution.valid_speed is None
        assert parse_config(config.text, "stored") == config

    def test_extrapolation_is_said(self):
        pair = load_config("corundum-steel").pair
        assert pair.extrapolation(50.0) is None
        assert pair.extrapolation(300.0) is None
        assert pair.extrapolation(301.0) == (
            "the restitution law was measured at 50 to 300 m/s; 301 m/s extrapolates it"
        )
        assert "states no range" in load_config(FITTED[0]).pair.extrapolation(100.0)

    def test_simulating_a_law_without_a_range_says_so(self, tmp_path, capsys):
        output = tmp_path / "out.npz"
        changes = {"--pair": "forder-1998", "--shape": "sphere", "--output": str(output)}
        assert main(["simulate", *map(str, flags(SIMULATE, changes)), "--quiet"]) == 0
        assert "note: the restitution law states no range of speeds" in capsys.readouterr().err
        # by the table at 45 degrees: the sphere's normal velocity is its contact's
        law = load_config("forder-1998").pair.restitution
        bounce = np.interp(45.0, law.angle_deg, [row[0] for row in law.value])
        with np.load(output) as made:
            np.testing.assert_allclose(made["state"][:, 1], bounce * math.sqrt(0.5), rtol=1e-12)


class TestSpeedAbscissa:
    SPEED = np.geomspace(1.0, 1e4, 2000)

    @pytest.mark.parametrize("law", [*RESTITUTION.values(), *SPEEDLESS.values()])
    def test_is_positive_and_falls(self, law):
        abscissa = with_laws(law).speed_coordinate(self.SPEED)
        assert abscissa.shape == self.SPEED.shape
        assert (abscissa > 0.0).all()
        assert (np.diff(abscissa) < 0.0).all()

    def test_is_the_restitution_at_normal_impact(self):
        speed = np.array([50.0, 120.0, 300.0])
        for law in ("exponential", "power"):
            config = with_laws(RESTITUTION[law])
            arguments = config.pair.kernel_arguments()
            truth = np.array([restitution(arguments, v, 1.0) for v in speed])
            abscissa = config.speed_coordinate(speed)
            np.testing.assert_allclose(abscissa / abscissa[0], truth / truth[0], rtol=1e-14)

    @pytest.mark.parametrize("law", SPEEDLESS.values(), ids=SPEEDLESS)
    @pytest.mark.parametrize("speed", [[50.0, 300.0], [1e-6, 1e5], [100.0, 100.0001]])
    def test_laws_without_speed_need_the_ends_only(self, law, speed):
        config = with_laws(law, domain={"speed": speed, "extrapolate": True})
        axes = make_axes(config)
        np.testing.assert_array_equal(axes.speed, speed)
        assert (axes.speed_coordinate[0], axes.speed_coordinate[-1]) == (0.0, 1.0)
        assert (np.diff(axes.speed_coordinate) > 0.0).all()

    def test_first_nodes_in_speed_follow_the_law(self):
        config = with_laws(RESTITUTION["tabulated"])
        speed = make_axes(config).speed
        assert (speed[0], speed[-1]) == (5.0, 300.0)
        change = np.log(config.speed_coordinate(speed[0]) / config.speed_coordinate(speed[-1]))
        assert len(speed) - 1 == np.ceil(change / 0.75) > 1


class TestShippedPairs:
    NAMES = sorted(path.stem for path in data_directory().glob("*.toml"))

    @pytest.mark.parametrize("name", NAMES)
    def test_restitution_is_physical_at_all_angles_and_speeds(self, name):
        law = load_config(name).pair.kernel_arguments()
        for speed in [0.0, *np.geomspace(1e-3, 1e5, 40)]:
            for sine in np.sin(np.linspace(0.0, np.pi / 2, 181)):
                assert 0.0 <= restitution(law, speed, sine) <= 1.0

    # one to start a calibration from has numbers of no meaning, and says so
    @pytest.mark.parametrize("name", sorted({*NAMES} - {"start-tabulated"}))
    def test_every_law_has_a_source_with_a_year(self, name):
        pair = load_config(name).pair
        for source in (pair.restitution.source, pair.resistance.source):
            assert any(
                word.strip(",;").isdigit() and len(word.strip(",;")) == 4 for word in source.split()
            )

    @pytest.mark.parametrize("name", FITTED)
    def test_fitted_pairs_say_what_they_are(self, name):
        config = load_config(name)
        assert config.pair.restitution.valid_speed is None
        assert config.domain.extrapolate
        assert "fitted to measured rebounds" in config.pair.restitution.source
        # what could not be verified is said where the user looks, and travels with the table
        said = " ".join(config.text.replace("#", "").split())
        assert "Made by tablegen calibrate" in said
        assert "largest residual of e_t" in said
        data = find_measurements(name).read_bytes()
        assert hashlib.sha256(data).hexdigest() in said

    @pytest.mark.parametrize("name", FITTED)
    def test_fitted_pairs_follow_their_measurements(self, name):
        """With 8,000 particles means were off by 0.030 at most; here chance adds up to 0.007."""
        found = compare(load_config(name), name, count=3000, seed=3)
        for quantity in ("e_n", "e_t"):
            mean = found.means[quantity]
            known = np.isfinite(mean.measured)
            assert known.sum() >= 8
            assert np.abs(mean.deviation[known]).max() < 0.05
            assert mean.simulated_error[known].max() < 0.007
        # a constant resistance is refused
        angle = {"law": "constant", "value": 0.5, "source": "test"}
        other = load_config(name).with_changes({"pair": {"resistance": angle}})
        worst = np.nanmax(np.abs(compare(other, name, count=1500).means["e_t"].deviation))
        assert worst > 0.07


@pytest.mark.usefixtures("quick_measurement")
@pytest.mark.parametrize("law", RESTITUTION.values(), ids=RESTITUTION)
def test_a_table_can_be_made_of_every_law(law, tmp_path):
    resistance = SOURCE | {"law": "constant", "value": 0.4}
    changes = {
        "restitution": {"valid_speed": [50.0, 300.0]} | SOURCE | law,
        "resistance": resistance,
    }
    path = tmp_path / "law.h5"
    generate(ROUGH.with_changes({"pair": changes}), path, conditions=1)
    table = sampler.load(path)
    assert tomllib.loads(table.config)["pair"]["restitution"]["law"] == law["law"]
    state = table.sample(np.radians(40.0), 150.0, seed=1, index=np.arange(1000))
    assert state.shape == (1000, len(STATE))
    assert np.isfinite(state).all()
    assert state[:, 1].min() > 0.0
