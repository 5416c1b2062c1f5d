"""The stability study: its cases, what it measures and counts as a failure, and its command."""

import json
from dataclasses import replace

import numpy as np
import pytest
from command_line import DONE, MISSED
from refusals import refused

from sampler.errors import REBOUND_NOT_ENDED, InputError
from tablegen.config.config import load_config
from tablegen.evidence import stability_cases
from tablegen.evidence import stability_chains as chains
from tablegen.evidence import stability_friction as friction
from tablegen.evidence.stability import Study, run_study
from tablegen.evidence.stability_cases import Case, all_cases, run_case
from tablegen.evidence.stability_chains import rolling_arrivals, run_chains
from tablegen.evidence.stability_friction import run_friction
from tablegen.evidence.stability_text import (
    GOOD,
    chain_picture,
    chain_rows,
    failure_lines,
    worst_rows,
)
from tablegen.simulation.direct import DirectModel, model_without_warnings
from tablegen.simulation.simulate import make_condition, simulate_condition

CONFIG = load_config("corundum-steel")
CASE = Case("prism", (0.5, 0.02), 20.0, 200.0, -5.0)
CASES = [
    CASE,
    Case("sphere", (1.0, 1.0), 90.0, 50.0, 0.0),
    Case("ellipsoid", (1.0, 0.02), 90.0, 3000.0, 1.0),
    Case("tetrahedron", (0.02, 1.0), 0.5, 1.0, 5.0),
]

#: Words of a short study of `CASES`.
FEW = ("--count", 3, "--threads", 1, "--quiet", "--grains", 5, "--friction")


def test_full_study_is_the_whole_product_and_the_quick_one_a_part_of_it():
    full, quick = all_cases(), set(all_cases(quick=True))
    assert len(set(full)) == len(full) == 28_280 == (4 * 25 + 1) * 8 * 5 * 7
    assert len(quick) == 2368
    assert quick < set(full)
    assert {case.aspect for case in full if case.shape == "sphere"} == {(1.0, 1.0)}


@pytest.mark.parametrize("case", CASES)
def test_a_case_is_what_three_simulations_of_the_same_particles_say(case):
    def by_hand(resolution=1e-3, tolerance=1e-10):
        angle, spin = np.radians(case.alpha_deg), (0.0, 0.0, case.spin)
        condition = make_condition(angle, case.speed, spin, resolution, tolerance)
        population = CONFIG.population.restricted_to(case.shape).with_aspect(*case.aspect)
        return simulate_condition(CONFIG.pair, population, condition, 10, seed=5, threads=1)

    f, usual = run_case(CONFIG, case, 10, seed=5), by_hand()
    assert f.most_collisions == usual.collisions.max()
    assert f.least_velocity == usual.state[:, 1].min()
    assert f.growth == usual.energy.sum(axis=1).max() - 1.0
    kept_or_taken = usual.energy.sum(axis=1) + usual.work.sum(axis=1)
    assert f.unaccounted == pytest.approx(np.abs(1.0 - kept_or_taken).max(), abs=1e-15)
    for change, halved in ((f.contact, by_hand(5e-4)), (f.flight, by_hand(tolerance=5e-11))):
        assert change == np.abs(halved.state - usual.state).max(axis=1).mean()
    assert (f.contact > 1e-6) == (case == CASES[2])


@pytest.fixture(scope="module")
def study():
    return run_study(CONFIG, CASES, count=6, seed=2**64 - 2, threads=1)


@pytest.mark.parametrize(
    ("changes", "failures"),
    [
        ({"growth": 5e-13}, []),
        ({"growth": 2e-12}, ["growing energy"]),
        ({"least_velocity": 0.0}, ["not leaving"]),
    ],
)
def test_failures(study, changes, failures):
    outcome = replace(study.outcomes[0], **changes)
    assert list(outcome.failures) == failures
    assert outcome.to_dict()["failures"] == list(outcome.failures.values())


def test_cases_keep_their_order_and_repeat_alone_with_their_seeds(study):
    assert [outcome.seed for outcome in study.outcomes] == [2**64 - 2, 2**64 - 1, 0, 1]
    assert study.holds
    assert list(study.outcomes) == [run_case(CONFIG, o.case, 6, o.seed) for o in study.outcomes]
    other = run_study(CONFIG, CASES, count=6, seed=2**64 - 2, threads=3)
    assert other == study


def test_the_worst_case_of_each_quantity_is_named_with_its_seed(study):
    well = study.outcomes[0]
    grows = replace(well, growth=0.25)
    measured = ("growth", "least_velocity", "unaccounted", "most_collisions", "contact", "flight")
    stuck = replace(well, unfinished=3, **dict.fromkeys(measured))
    outcomes = (*study.outcomes, grows, stuck)
    assert [
        "largest gain of energy, over that before",
        "0.25",
        f"{CASE} (seed {grows.seed})",
    ] in worst_rows(outcomes)
    assert len(worst_rows(outcomes)) == 6
    assert worst_rows([stuck]) == []
    data = Study("x", 1.0, 1.0, 1, 6, outcomes).to_dict()
    assert [bool(case["failures"]) for case in data["cases"]] == [False] * 4 + [True] * 2


def test_friction_of_any_strength_is_simulated_and_its_failures_are_named(monkeypatch):
    outcomes = run_friction(CONFIG, 30, seed=5, threads=1)
    assert len({(o.static, o.dynamic, o.restitution) for o in outcomes}) == len(outcomes) == 44
    assert not any(outcome.failures for outcome in outcomes)
    # elastic contacts without much friction lose little, plastic ones much
    assert (
        -1e-2 < next(o.growth for o in outcomes if (o.dynamic, o.restitution) == (0.1, 1.0)) < 0.0
    )
    again = run_friction(CONFIG, 30, seed=5, threads=2)
    assert again == outcomes
    right = friction.simulate_impacts

    def spoiled(field, place, value):
        def simulate(*arguments, **settings):
            run = right(*arguments, **settings)
            getattr(run, field)[place] = value
            return run

        return simulate

    for wrong, kind in (
        (spoiled("codes", 17, REBOUND_NOT_ENDED), "unfinished"),
        (spoiled("variables", (3, 1), 0.0), "not leaving"),
        (spoiled("variables", (4, 6), 1.5), "growing energy"),
    ):
        monkeypatch.setattr(friction, "simulate_impacts", wrong)
        outcomes = run_friction(CONFIG, 30, seed=5, threads=1)
        assert all(kind in outcome.failures for outcome in outcomes)
        study = Study("x", 1.0, 1.0, 5, 6, (), outcomes)
        assert not study.holds
        assert "(seed 5): " + outcomes[0].failures[kind] in failure_lines(study)[0]


def test_chains_are_followed_and_each_hit_is_checked():
    outcomes = run_chains(CONFIG, 20, seed=5)
    assert [one.hits for one in outcomes] == [60] * 10 + [1000] * 2
    assert not any(outcome.failures for outcome in outcomes)
    assert all(len(one.angle_deg) == one.hits for one in outcomes)
    round_disc, other = outcomes[-2:]
    # without a velocity at its contact a round disc loses no more than its bounces, for ever
    assert round_disc.energy == pytest.approx(1.0, abs=1e-6)
    assert round_disc.spin == pytest.approx(1.0, abs=1e-3)
    assert other.energy < 0.999
    assert len(chain_rows(outcomes)) == len(outcomes)
    assert chain_picture(outcomes, "chains.svg").startswith(b"<?xml")


@pytest.mark.parametrize(
    ("spoil", "kind"),
    [
        (lambda after: after.velocity.__setitem__((3, 0), np.nan), "unfinished"),
        (lambda after: after.omega.__imul__(3.0), "growing energy"),
        (
            lambda after: after.velocity.__setitem__((3, slice(None)), (1.0, 0.0, 0.0)),
            "not leaving",
        ),
    ],
)
def test_failures_of_a_chain_are_named(monkeypatch, spoil, kind):
    right = DirectModel.rebound

    def rebound(self, *arguments, **keyword_arguments):
        after = right(self, *arguments, **keyword_arguments)
        if keyword_arguments["hit"] == 0:
            spoil(after)
        return after

    def end(*_, **__):
        raise InputError("", problem="still in contact")

    monkeypatch.setattr(DirectModel, "rebound", rebound)
    model, index = model_without_warnings(CONFIG), np.arange(10, dtype=np.uint64)
    start = rolling_arrivals(index, (1.0, 0.5))._replace(
        inertia=np.zeros(10), omega=np.zeros((10, 3))
    )
    start = start._replace(velocity=start.velocity - [50.0, 50.0, 0.0])
    outcome = chains.outcome_of(model, ("grains", "any"), start, 5, 1)
    assert kind in outcome.failures
    monkeypatch.setattr(DirectModel, "rebound", end)
    outcome = chains.outcome_of(model, ("grains", "any"), start, 5, 1)
    assert outcome.failures == {"unfinished": "1 of 10 did not end"}
    json.dumps(outcome.to_dict(), allow_nan=False)


@pytest.fixture
def few_cases(monkeypatch):
    monkeypatch.setattr(stability_cases, "all_cases", lambda _: CASES)


@pytest.mark.usefixtures("few_cases")
def test_good_model_is_status_0(run, tmp_path):
    record, picture = tmp_path / "s.json", tmp_path / "s.png"
    ended = run("stability", "demo", *FEW, 5, "--json", record, "--picture", picture)
    assert (ended.status, ended.err) == (DONE, "")
    assert "12 particles in 4 cases; failures: none" in ended.out
    data = json.loads(record.read_text())
    assert (data["holds"], data["pair"], len(data["cases"])) == (True, "corundum-steel", 4)
    assert {law["rebounds"] for law in data["friction"]} == {5}
    assert {chain["grains"] for chain in data["chains"]} == {2, 5}
    assert GOOD in ended.out
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.usefixtures("few_cases")
def test_wrong_model_is_status_1_and_is_reported(run, tmp_path, monkeypatch):
    def does_not_finish(*_, **__):
        raise RuntimeError("still in contact")

    monkeypatch.setattr(stability_cases, "simulate_condition", does_not_finish)
    ended = run("stability", *FEW, 0, "--json", tmp_path / "s.json")
    assert (ended.status, ended.err) == (MISSED, "")
    assert "3 of 3 did not end" in ended.out
    assert json.loads((tmp_path / "s.json").read_text())["holds"] is False


def test_a_picture_needs_chains(refuse, tmp_path):
    line = refuse("tablegen", "stability", "--grains", 0, "--picture", tmp_path / "s.png")
    assert line == "--picture: --grains 0 leaves nothing to draw"


def test_a_tolerance_that_cannot_be_halved_is_refused():
    fine = CONFIG.with_changes({"model": {"tolerance": 1e-14}})
    refused("model.tolerance", run_study, fine, CASES)


@pytest.mark.study
def test_quick_study_and_spins_of_50_hold():
    quick = all_cases(quick=True)
    kept = {"alpha_deg": (0.01, 0.5, 70.0, 89.99), "speed": (10.0, 300.0), "spin": (50.0, -50.0)}
    kept["aspect"] = {case.aspect for case in quick}
    fast = [c for c in all_cases() if all(getattr(c, name) in kept[name] for name in kept)]
    assert len(fast) == (4 * 9 + 1) * 4 * 2 * 2
    for cases, count in ((quick, 16), (fast, 8)):
        study = run_study(CONFIG, cases, count=count, seed=3)
        assert study.holds, [str(outcome.case) for outcome in study.failed]


@pytest.mark.study
def test_a_million_rebounds_at_each_coefficient_of_friction_end():
    outcomes = run_friction(CONFIG, 250_000)
    assert not any(outcome.failures for outcome in outcomes), [
        str(o) for o in outcomes if o.failures
    ]
