"""Material pairs in files: every law is read, turned into kernel arguments and a table."""

import json
import math
import re
from typing import get_args

import numpy as np
import pytest
from contact_law_samples import RESISTANCE, RESTITUTION, SOURCE
from pydantic import TypeAdapter
from refusals import refused

from sampler.files import data_directory
from sampler.formats.bounds import RESISTANCE_LAWS, RESTITUTION_LAWS
from tablegen.config.config import load_config, parse_config
from tablegen.config.pairs import ResistanceLaw, RestitutionLaw, kernel_entries
from tablegen.measured.compare import compare
from tablegen.model.contact_laws import restitution
from tablegen.model.jit import kernel
from tablegen.simulation.simulate import simulate
from tablegen.tables.axes import make_axes

# called from Python here
restitution = kernel(restitution)

#: Pairs fitted to published mean laws of unknown speeds, and how many means of e_t these have.
FITTED = {"forder-1998": 8, "grant-tabakoff-1975": 8, "wakeman-tabakoff-1981": 5}


def with_laws(restitution=None, resistance=None, **changes):
    """Return the shipped pair with other laws in the same range of speeds."""
    pair = {}
    if restitution is not None:
        pair["restitution"] = {"valid_speed": [50.0, 300.0]} | SOURCE | restitution
    if resistance is not None:
        pair["resistance"] = SOURCE | resistance
    return load_config("corundum-steel").with_changes({"pair": pair, **changes})


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
def test_a_law_in_a_file_is_the_law_in_the_kernel(law, expected):
    arguments = with_laws(RESTITUTION[law]).pair.kernel_arguments()
    sine = math.sin(math.radians(30.0))
    assert restitution(arguments, 100.0, sine) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize(
    ("kind", "records", "names", "samples"),
    [
        ("restitution", RestitutionLaw, RESTITUTION_LAWS, RESTITUTION),
        ("resistance", ResistanceLaw, RESISTANCE_LAWS, RESISTANCE),
    ],
)
def test_every_law_has_a_record_a_sample_and_a_row_on_the_page(kind, records, names, samples):
    laws = [
        TypeAdapter(records).validate_json(json.dumps(law | SOURCE)) for law in samples.values()
    ]
    assert {type(law) for law in laws} == set(get_args(records))
    assert {law.law for law in laws} == set(names)
    assert all(kernel_entries(law) for law in laws)
    page = (data_directory() / "LAWS.md").read_text(encoding="utf-8")
    section = page.partition(f"## `[pair.{kind}]`")[2].partition("\n## ")[0]
    rows = dict(re.findall(r'^\| `"([^"]+)"` \|(.*)$', section, re.M))
    assert rows.keys() == {law["law"] for law in samples.values()}
    for law in samples.values():
        assert all(f"`{name}`" in rows[law["law"]] for name in law if name != "law"), law


def test_law_without_a_range_must_be_extrapolated():
    changes = {"pair": {"restitution": RESTITUTION["constant"] | SOURCE}}
    pair, no = load_config("corundum-steel"), {"domain": {"extrapolate": False}}
    refused("corundum-steel, changed: domain.extrapolate", pair.with_changes, changes | no)
    config = pair.with_changes(changes | {"domain": {"extrapolate": True}})
    assert config.pair.restitution.valid_speed is None
    assert "states no range" in config.pair.extrapolation(100.0)
    assert "50 to 300 m/s" in pair.pair.extrapolation(20.0)
    assert pair.pair.extrapolation(100.0) is None
    assert parse_config(config.text, "stored") == config


def tabulated(*rows):
    table = {"angle_deg": [10.0, 90.0], "speed": [50.0, 200.0][: len(rows[0])], "value": list(rows)}
    return {"law": "tabulated", **table}


@pytest.mark.usefixtures("short_paths")
class TestSpeed:
    @pytest.mark.parametrize(
        ("law", "depends"),
        [
            (RESTITUTION["polynomial"], False),
            (RESTITUTION["constant"], False),
            (tabulated([0.9], [0.5]), False),
            (tabulated([0.9, 0.9], [0.5, 0.5]), False),
            (tabulated([0.9, 0.9], [0.5, 0.4]), True),
            (RESTITUTION["exponential"], True),
            (RESTITUTION["power"], True),
        ],
    )
    def test_laws_say_whether_it_matters_and_the_model_agrees(self, law, depends):
        config = with_laws(law)
        assert config.pair.restitution.depends_on_speed is depends
        slow, fast = (simulate(config, 0.7, speed, 50, seed=1).state for speed in (60.0, 300.0))
        assert np.allclose(slow, fast, rtol=1e-6, atol=1e-9) is not depends
        abscissa = config.pair.restitution.coordinate(np.geomspace(1.0, 1e4, 2000))
        assert (np.diff(abscissa) < 0.0).all()
        axes = make_axes(config)
        assert (axes.speed[0], axes.speed[-1]) == (5.0 if depends else 300.0, 300.0)
        assert (len(axes.speed) == 1) is not depends
        assert (np.diff(axes.speed_coordinate) > 0.0).all() == depends

    def test_speeds_of_a_tabulated_law_are_nodes_between_which_it_is_linear(self):
        law = {**tabulated([0.9, 0.7], [0.5, 0.4]), "speed": [20.0, 75.0, 400.0]}
        law["value"] = [[0.9, 0.7, 0.3], [0.5, 0.4, 0.35]]
        config = with_laws(law).with_changes({"domain": {"extrapolate": True}})
        axes = make_axes(config)
        assert {20.0, 75.0} <= set(axes.speed)
        speeds = np.linspace(axes.speed[0], axes.speed[-1], len(axes.speed_coordinate))
        of_law = np.interp(speeds, law["speed"], law["value"][0])
        at_nodes = np.interp(axes.speed, law["speed"], law["value"][0])
        drawn = np.interp(axes.speed_coordinate, np.arange(len(axes.speed)), at_nodes)
        np.testing.assert_allclose(drawn, of_law, rtol=0.0, atol=1e-3)
        # Refused: the same nodes in another abscissa.
        index = np.interp(-1.0 / speeds, -1.0 / axes.speed, np.arange(len(axes.speed)))
        other = np.interp(index, np.arange(len(axes.speed)), at_nodes)
        assert np.abs(other - of_law).max() > 0.01

    @pytest.mark.parametrize("law", ["exponential", "power"])
    def test_abscissa_is_the_restitution_at_normal_impact(self, law):
        speed = np.array([50.0, 120.0, 300.0])
        config = with_laws(RESTITUTION[law])
        arguments = config.pair.kernel_arguments()
        truth = np.array([restitution(arguments, v, 1.0) for v in speed])
        abscissa = config.pair.restitution.coordinate(speed)
        np.testing.assert_allclose(abscissa / abscissa[0], truth / truth[0], rtol=1e-14)


class TestShippedPairs:
    NAMES = sorted(path.stem for path in data_directory().glob("*.toml"))

    @pytest.mark.parametrize("name", NAMES)
    def test_restitution_is_physical_at_all_angles_and_speeds(self, name):
        law = load_config(name).pair.kernel_arguments()
        for speed in [0.0, *np.geomspace(1e-3, 1e5, 20)]:
            for sine in np.sin(np.linspace(0.0, np.pi / 2, 61)):
                assert 0.0 <= restitution(law, speed, sine) <= 1.0

    @pytest.mark.parametrize("name", FITTED)
    def test_fitted_pairs_follow_their_measurements(self, name):
        """Calibration left errors of at most 0.023; chance adds up to 0.010 here."""
        comparison = compare(load_config(name), name, count=2000, seed=3)
        for quantity in ("e_n", "e_t"):
            mean = comparison.means[quantity]
            known = np.isfinite(mean.measured)
            assert known.sum() >= (8 if quantity == "e_n" else FITTED[name])
            assert np.abs(mean.deviation[known]).max() < 0.05
            assert mean.simulated_error[known].max() < 0.01
        # a constant resistance is refused
        angle = {"law": "constant", "value": 0.5, "source": "test"}
        other = load_config(name).with_changes({"pair": {"resistance": angle}})
        worst = np.nanmax(np.abs(compare(other, name, count=1000).means["e_t"].deviation))
        assert worst > 0.07
