"""The stability study against simulations made by hand."""

import time
from dataclasses import replace

import numpy as np
import pytest
from fake_outcomes import CASE
from tablegen.evidence.cases import Case
from tablegen.evidence.stability_study import extrapolates, run_case, run_study

from sampler.errors import InputError
from tablegen.config.config import load_config
from tablegen.evidence import stability_study as module
from tablegen.simulation.simulate import make_condition, simulate_condition

CONFIG = load_config("corundum-steel")
CASES = [
    CASE,
    Case("sphere", (1.0, 1.0), 90.0, 50.0, 0.0),
    Case("ellipsoid", (1.0, 0.02), 90.0, 3000.0, 1.0),
    Case("tetrahedron", (0.02, 1.0), 0.5, 1.0, 5.0),
]


def by_hand(case, count, seed, resolution=1e-3, tolerance=1e-10, audited=False):
    condition = make_condition(
        np.radians(case.alpha_deg), case.speed, (0.0, 0.0, case.spin), resolution, tolerance
    )
    population = CONFIG.population.restricted_to(case.shape).with_aspect(*case.aspect)
    return simulate_condition(
        CONFIG.pair, population, condition, count, seed=seed, threads=1, audited=audited
    )


@pytest.mark.parametrize("case", CASES)
def test_a_case_is_what_three_simulations_of_the_same_particles_say(case):
    made = run_case(CONFIG, case, 10, seed=5)
    usual = by_hand(case, 10, 5, audited=True)
    f = made.figures
    assert f.most_collisions == usual.collisions.max()
    assert f.least_velocity == usual.state[:, 1].min()
    assert f.residual == usual.audit[[1, 2, 3]].max()
    assert f.growth == max(usual.audit[0], usual.energy.sum(axis=1).max() - 1.0)
    for change, halved in (
        (f.contact, by_hand(case, 10, 5, resolution=5e-4)),
        (f.flight, by_hand(case, 10, 5, tolerance=5e-11)),
    ):
        moved = np.abs(halved.state - usual.state).max(axis=1)
        assert (change.mean, change.largest) == (moved.mean(), moved.max())
    assert made.cost is None


def test_the_sample_holds_cases_that_the_tolerances_change():
    contact, flight = (
        [getattr(run_case(CONFIG, case, 10, seed=5).figures, name).largest for case in CASES]
        for name in ("contact", "flight")
    )
    assert max(contact) > 1e-5
    assert max(flight) > 1e-12
    # a sphere does not turn before its collision
    assert (contact[1], flight[1]) == (0.0, 0.0)


@pytest.fixture(scope="module")
def made():
    return run_study(CONFIG, CASES, count=6, seed=2**64 - 2, threads=1)


def test_cases_keep_their_order_and_have_seeds_of_their_own(made):
    assert [outcome.case for outcome in made.outcomes] == CASES
    assert [outcome.seed for outcome in made.outcomes] == [2**64 - 2, 2**64 - 1, 0, 1]
    assert (made.pair, made.count, made.seed) == ("corundum-steel", 6, 2**64 - 2)
    assert (made.contact_resolution, made.tolerance) == (1e-3, 1e-10)
    assert made.holds


def test_a_case_repeats_alone_with_its_seed(made):
    for outcome in made.outcomes:
        assert run_case(CONFIG, outcome.case, 6, outcome.seed) == replace(outcome, cost=None)


def test_threads_change_the_cost_only(made):
    other = run_study(CONFIG, CASES, count=6, seed=2**64 - 2, threads=3)
    for one, two in zip(made.outcomes, other.outcomes, strict=True):
        assert replace(one, cost=None) == replace(two, cost=None)


def test_cost_is_that_of_a_rebound_and_not_of_the_call(made):
    # Chains of some hundred bounces cost a hundred times more than the one bounce of a sphere, of
    # which many are followed, since it costs far less than the half millisecond of a call.
    many = run_study(CONFIG, CASES[1:2], count=5_000, seed=1, threads=1).outcomes[0].cost
    assert 0.0 < 5.0 * many < made.outcomes[2].cost


def test_a_configuration_decides_pair_and_numerics():
    config = CONFIG.with_changes({"model": {"contact_resolution": 0.01, "tolerance": 1e-8}})
    made = run_case(config, CASES[2], 10, seed=5)
    assert made.figures.most_collisions < run_case(CONFIG, CASES[2], 10, 5).figures.most_collisions
    study = run_study(config, CASES[:1], count=2, threads=1)
    assert (study.contact_resolution, study.tolerance) == (0.01, 1e-8)


@pytest.mark.parametrize(
    ("speed", "spin", "outside"),
    [
        (50.0, 0.0, False),
        (300.0, 0.0, False),
        (10.0, 0.0, True),
        (301.0, 0.0, True),
        # the spin adds to the speed of the contact point
        (50.0, 5.0, False),
        (50.0, -5.0, False),
        (50.0, 5.1, True),
        (300.0, -1.0, True),
        (10.0, 10.0, True),
    ],
)
def test_cases_outside_the_range_of_the_law_are_marked(speed, spin, outside):
    case = replace(CASE, speed=speed, spin=spin)
    assert extrapolates(CONFIG.pair, case) is outside
    assert run_case(CONFIG, case, 1, 1).extrapolated is outside


def test_a_law_without_a_range_extrapolates_everywhere():
    assert extrapolates(load_config("forder-1998").pair, replace(CASE, speed=100.0, spin=0.0))


def test_a_particle_that_does_not_finish_is_an_outcome(monkeypatch):
    def stuck(*arguments, **options):
        if arguments[2].resolution < 1e-3:
            raise RuntimeError("still in contact")
        return simulate_condition(*arguments, **options)

    monkeypatch.setattr(module, "simulate_condition", stuck)
    study = run_study(CONFIG, CASES[:2], count=3, threads=2)
    assert not study.holds
    assert [outcome.unfinished for outcome in study.outcomes] == [1, 1]
    assert [outcome.figures.contact for outcome in study.outcomes] == [None, None]
    # timing it would wait for the alarm again
    assert [outcome.cost for outcome in study.outcomes] == [None, None]


def test_an_interruption_ends_the_study(monkeypatch):
    begun = []

    def interrupted(config, case, count, seed):
        begun.append(seed)
        time.sleep(0.01)  # leaves the study time to hear of it
        raise KeyboardInterrupt

    monkeypatch.setattr(module, "run_case", interrupted)
    with pytest.raises(KeyboardInterrupt):
        run_study(CONFIG, CASES * 100, count=1, threads=1)
    assert len(begun) < 100


def test_refusals():
    with pytest.raises(InputError, match="cases: got none"):
        run_study(CONFIG, [])
    fine = CONFIG.with_changes({"model": {"tolerance": 1e-14}})
    with pytest.raises(InputError, match=r"model\.tolerance: got 1e-14, allowed in"):
        run_study(fine, CASES)
    assert run_study(
        CONFIG.with_changes({"model": {"tolerance": 2e-14}}), CASES[:1], count=1, threads=1
    ).holds
