"""``tablegen stability``: what it prints and writes, how it ends, what it refuses."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from command_line import DONE, MISSED
from tablegen.evidence.cases import QUICK, Grid
from tablegen.evidence.stability_study import run_study

from tablegen.config.config import load_config
from tablegen.evidence import stability_study as module

CONFIG = load_config("corundum-steel")

#: A few cases: flat and slender particles, grazing and normal impact, with and without spin.
FEW = (
    *("--shape", "prism", "--shape", "ellipsoid"),
    *("--aspect", 1, 0.02, "--aspect", 0.02, 0.5, "--alpha", 0.5, "--alpha", 90),
    *("--speed", 50, "--spin", 0, "--spin", -5),
    *("--count", 3, "--threads", 1, "--quiet"),
)


def test_good_model_is_status_0(run, tmp_path):
    record, page = tmp_path / "s.json", tmp_path / "s.html"
    ended = run("stability", *FEW, "--json", record, "--html", page)
    assert (ended.status, ended.err) == (DONE, "")
    assert ended.out.endswith("The model holds in every case.\n")
    assert "48 particles in 16 cases: 0 non-finite, 0 cases unfinished" in ended.out
    data = json.loads(record.read_text())
    assert data["holds"] is True
    assert len(data["cases"]) == 16
    assert {case["spin"] for case in data["cases"]} == {0.0, -5.0}
    for case in data["cases"]:
        assert case["figures"]["growth"] <= 1e-12
        assert case["figures"]["least_velocity"] > 0.0
        assert case["extrapolated"] is False
    assert "The model holds in every case." in page.read_text()


def test_a_file_may_take_the_place_of_the_shipped_pair(run, tmp_path):
    record = tmp_path / "s.json"
    words = ("stability", "demo", *FEW, "--json", record)
    assert run(*words).status == DONE
    assert json.loads(record.read_text())["pair"] == "corundum-steel"


def spoiled(change):
    """Simulation of which ``change`` spoils the result."""
    right = module.simulate_condition

    def wrong(*arguments, **options):
        return change(right(*arguments, **options))

    return wrong


def gains_energy(made):
    """What a law of restitution above one would do: the audit sees a collision gain energy."""
    audit = made.audit.copy()
    audit[:1] = 1e-9
    return replace(made, audit=audit)


def is_left_in_contact(made):
    """What a cap on the number of collisions would do: long chains end falling."""
    state = made.state.copy()
    state[made.collisions > 3, 1] *= -1.0
    return replace(made, state=state)


def is_no_number(made):
    state = made.state.copy()
    state[0, 4] = math.nan
    return replace(made, state=state)


def does_not_finish(made):
    raise RuntimeError("still in contact")


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        (gains_energy, "energy grows by 1e-09, allowed: 1e-12"),
        (is_left_in_contact, "a particle leaves with v+ = -"),
        (is_no_number, "1 of 3 particles are not finite"),
        (does_not_finish, "a particle is unfinished"),
    ],
)
def test_wrong_model_is_status_1_and_is_reported(run, tmp_path, monkeypatch, change, complaint):
    monkeypatch.setattr(module, "simulate_condition", spoiled(change))
    record, page = tmp_path / "s.json", tmp_path / "s.html"
    ended = run("stability", *FEW, "--json", record, "--html", page)
    assert (ended.status, ended.err) == (MISSED, "")
    assert complaint in ended.out
    assert "The model holds in every case." not in ended.out
    data = json.loads(record.read_text())
    assert data["holds"] is False
    assert any(case["failures"] for case in data["cases"])
    assert "The model fails in some cases:" in page.read_text()


def test_the_seed_that_is_reported_repeats_the_case_by_simulation(run, tmp_path):
    record, output = tmp_path / "s.json", tmp_path / "r.npz"
    run("stability", *FEW, "--seed", 40, "--json", record)
    case = json.loads(record.read_text())["cases"][-1]
    words = ("--alpha", case["alpha_deg"], "--speed", case["speed"], "--seed", case["seed"])
    words += ("--aspect", *case["aspect"], "--spin", 0, 0, case["spin"], "--count", 3)
    given = ("--pair", "corundum-steel", "--shape", case["shape"], *words)
    assert run("simulate", *given, "--output", output, "--quiet").status == DONE
    with np.load(output) as file:
        assert file["state"][:, 1].min() == case["figures"]["least_velocity"]
        assert file["collisions"].max() == case["figures"]["most_collisions"]


@pytest.mark.parametrize(
    ("words", "parts"),
    [
        (("corundum-cheese",), ("corundum-cheese",)),
        (("none/there.toml",), ("none/there.toml",)),
        (("--shape", "cube"), ("--shape", "cube")),
        (("--shape", "mixture"), ("--shape", "mixture")),
        (("--aspect", 0, 1), ("--aspect", "got '0'")),
        (("--aspect", 1, "nan"), ("--aspect", "got 'nan'")),
        (("--shape", "sphere", "--aspect", 0.5, 1), ("aspect: got [0.5, 1]", "spheres")),
        (("--alpha", 0), ("--alpha", "got '0'")),
        (("--speed", -1), ("--speed", "got '-1'")),
        (("--spin", "inf"), ("--spin", "got 'inf'")),
        (("--count", 0), ("--count", "got '0'")),
        (("--seed", -1), ("--seed", "got '-1'")),
        (("--threads", 0), ("--threads", "got '0'")),
        (("--json", "none/there.json"), ("--json", "a folder that exists")),
        (("--html", "none/there.html"), ("--html", "a folder that exists")),
    ],
)
def test_refusals_name_flag_and_value(refused, monkeypatch, words, parts):
    monkeypatch.setattr("tablegen.evidence.stability_study.run_study", None)
    line = refused("stability", *words)
    assert all(part in line for part in parts)


def test_help_tells_the_size_of_the_studies(run):
    text = " ".join(run("stability", "--help").out.split())
    assert "28,280 cases" in text
    assert "2,368 cases" in text


@pytest.mark.study
def test_quick_study_holds():
    study = run_study(CONFIG, list(QUICK.cases()), seed=3)
    assert study.holds, [str(outcome.case) for outcome in study.failed]


@pytest.mark.study
def test_spins_of_50_hold():
    # what the quick study leaves out: a part of it at grazing and at normal impact
    grid = QUICK.narrowed(Grid((), (), (0.01, 0.5, 70.0, 89.99), (10.0, 300.0), (50.0, -50.0)))
    study = run_study(CONFIG, list(grid.cases()), count=8, seed=4)
    assert study.holds, [str(outcome.case) for outcome in study.failed]
