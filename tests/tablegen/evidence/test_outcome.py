"""What is measured in a case of the stability study, and what counts as a failure."""

import json

import numpy as np
import pytest
from fake_outcomes import CASE, figures, outcome, simulation
from tablegen.evidence.outcome import Change, outcome_of

from tablegen.model.audit import (
    ANGULAR,
    AUDIT_SIZE,
    ENERGY,
    FLIGHT_ENERGY,
    FLIGHT_MOMENTUM,
    NORMAL,
    PENETRATION,
    TANGENTIAL,
)


def measure(usual, contact=None, flight=None):
    """Outcome of the case with these runs; the same particles where one is left out."""
    plain = simulation(audited=False)
    runs = (usual, contact or plain, flight or plain)
    return outcome_of(CASE, 7, False, 4, runs)


def audit(entry, value):
    entries = np.zeros(AUDIT_SIZE)
    entries[entry] = value
    return entries


def changed(rows, column, value):
    state = simulation().state
    state[rows, column] = value
    return state


def test_a_good_case_has_no_failures():
    made = measure(simulation())
    assert made.failures == []
    assert (made.particles, made.non_finite, made.unfinished) == (4, 0, 0)
    f = made.figures
    assert (f.most_collisions, f.mean_collisions, f.least_velocity) == (4, 2.5, 0.3)
    assert (f.growth, f.residual, f.drift, f.depth) == (0.0, 0.0, 0.0, 0.0)
    assert f.contact == f.flight == Change(0.0, 0.0)


@pytest.mark.parametrize(
    ("entry", "name"),
    [
        (ENERGY, "growth"),
        (ANGULAR, "residual"),
        (NORMAL, "residual"),
        (TANGENTIAL, "residual"),
        (FLIGHT_ENERGY, "drift"),
        (FLIGHT_MOMENTUM, "drift"),
        (PENETRATION, "depth"),
    ],
)
def test_every_entry_of_the_audit_is_shown(entry, name):
    shown = measure(simulation(audit=audit(entry, 3e-7))).figures
    assert getattr(shown, name) == 3e-7
    others = {"growth", "residual", "drift", "depth"} - {name}
    assert all(getattr(shown, other) == 0.0 for other in others)


@pytest.mark.parametrize(("gain", "fails"), [(0.0, False), (5e-13, False), (2e-12, True)])
def test_growth_in_a_collision_fails(gain, fails):
    made = measure(simulation(audit=audit(ENERGY, gain)))
    assert made.grows is fails
    assert bool(made.failures) is fails
    assert not fails or "energy grows by 2e-12, allowed: 1e-12" in made.failures


def test_growth_over_the_whole_rebound_fails():
    # as from a flight that drifts, which no single collision would show
    energy = np.tile([0.5, 0.2], (4, 1))
    energy[2] = [0.7, 0.3 + 1e-9]
    made = measure(simulation(energy=energy))
    assert made.figures.growth == pytest.approx(1e-9, rel=1e-6)
    assert made.grows


@pytest.mark.parametrize("velocity", [0.0, -0.2])
def test_a_particle_that_does_not_rise_fails(velocity):
    made = measure(simulation(state=changed(1, 1, velocity)))
    assert not made.separated
    assert f"a particle leaves with v+ = {velocity:.3g} V, allowed: above 0" in made.failures


def test_a_particle_inside_the_wall_fails():
    assert measure(simulation(audit=audit(PENETRATION, 1e-10))).separated
    made = measure(simulation(audit=audit(PENETRATION, 2e-9)))
    assert not made.separated
    assert "a contact is 2e-09 a deep, allowed: 1e-09" in made.failures


@pytest.mark.parametrize("value", [np.nan, np.inf])
@pytest.mark.parametrize("run", ["usual", "contact", "flight"])
def test_a_state_that_is_no_number_fails_in_any_run(run, value):
    broken = simulation(state=changed([0, 3], 4, value), audited=run == "usual")
    runs = {"usual": simulation(), run: broken}
    made = measure(**runs)
    assert made.non_finite == 2
    assert "2 of 4 particles are not finite" in made.failures
    # what is left is still measured, and its numbers are numbers
    assert made.figures.most_collisions == 3
    json.dumps(made.to_dict(), allow_nan=False)


def test_an_energy_that_is_no_number_fails():
    energy = np.tile([0.5, np.nan], (4, 1))
    made = measure(simulation(energy=energy))
    assert (made.non_finite, made.figures) == (4, None)
    assert made.failures == ["4 of 4 particles are not finite"]


def test_an_audit_that_is_no_number_fails():
    made = measure(simulation(audit=audit(NORMAL, np.nan)))
    assert (made.non_finite, made.figures) == (4, None)
    assert made.failures


@pytest.mark.parametrize(("run", "missing"), [(0, None), (1, "contact"), (2, "flight")])
def test_a_run_that_does_not_finish_fails(run, missing):
    runs = [simulation(), simulation(audited=False), simulation(audited=False)]
    runs[run] = None
    made = outcome_of(CASE, 7, False, 4, tuple(runs))
    assert made.unfinished == 1
    assert made.failures == ["a particle is unfinished"]
    if missing is None:
        assert made.figures is None
    else:
        assert getattr(made.figures, missing) is None


def test_change_is_the_largest_component_of_each_particle():
    # one particle moves by 0.2 in v and by 0.5 in omega_z, another by 0.1
    state = simulation().state
    state[0, 1] += 0.2
    state[0, 5] -= 0.5
    state[2, 0] += 0.1
    made = measure(simulation(), contact=simulation(state=state, audited=False))
    assert made.figures.contact.mean == pytest.approx(0.6 / 4)
    assert made.figures.contact.largest == pytest.approx(0.5)
    assert made.figures.flight == Change(0.0, 0.0)


def test_json_names_the_case_and_what_failed():
    data = outcome(measured=figures(growth=0.5)).to_dict()
    assert (data["shape"], data["aspect"], data["spin"]) == ("prism", (0.5, 0.02), -5.0)
    assert (data["alpha_deg"], data["speed"], data["seed"]) == (20.0, 200.0, 7)
    assert data["figures"]["contact"] == {"mean": 1e-6, "largest": 1e-5}
    assert data["failures"] == ["energy grows by 0.5, allowed: 1e-12"]
