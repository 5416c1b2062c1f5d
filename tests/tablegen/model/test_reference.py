"""Agreement with an independent direct simulation at fifteen conditions."""

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from motion_fixtures import LAW, PAIR, POPULATION, motion_of

from sampler.compilation.jit import kernel
from tablegen.model.contact import contact_point
from tablegen.model.random_particles import draw_particle
from tablegen.model.rebound import (
    HEIGHT,
    U,
    V,
    approach,
    collide,
    next_contact,
    wall_spin,
    workspace,
)
from tablegen.model.shapes import MAX_VERTICES, make_body
from tablegen.simulate import make_condition, simulate_condition

# called from Python here
wall_spin = kernel(wall_spin)
workspace = kernel(workspace)

_FILE = Path(__file__).parents[2] / "data" / "direct.json"
REFERENCE = json.loads(_FILE.read_text(encoding="utf-8"))
COLUMNS = REFERENCE["columns"]
POINTS = {
    f"{point['shape']}-{point['alpha_deg']}-{point['speed']}": point
    for point in REFERENCE["points"]
}

#: One condition of each kind: correlations that depend most on when the state is taken, longest
#: chains, flat faces at grazing impact, most collisions at one angle, all shapes together.
ORDINARY = (
    "ellipsoid-20-200",
    "ellipsoid-90-200",
    "prism-20-200",
    "tetrahedron-20-200",
    "mixture-45-200",
)
ORDINARY_COUNT = 400_000

#: As many particles as the reference has.
STUDY_COUNT = 600_000


def collision_shares(collisions):
    """Percentages of particles with 1, 2, 3, 4, 5 and more collisions."""
    counts = np.bincount(np.minimum(collisions, 6), minlength=7)[1:]
    return 100.0 * counts / len(collisions)


def disagreements(made, point):
    """What differs from a reference point by more than is allowed, one line each.

    Means may differ by four standard errors of the difference plus 5e-4, shares of collisions by
    0.5 percentage points, correlations by 0.01: at 400,000 particles each is four standard errors
    of the difference or more, so with 27 numbers the false-alarm rate is below 2e-3 a condition.
    """
    lines = []
    means = np.array([point["mean"][name] for name in COLUMNS])
    deviations = np.array([point["std"][name] for name in COLUMNS])
    error = np.hypot(
        deviations / np.sqrt(point["count"]), made.state.std(axis=0) / np.sqrt(len(made.state))
    )
    miss = np.abs(made.state.mean(axis=0) - means) - (4.0 * error + 5e-4)
    lines += [f"mean {name}: {x:.5f} over" for name, x in zip(COLUMNS, miss, strict=True) if x > 0]
    expected = np.array(list(point["collisions_percent"].values()))
    miss = np.abs(collision_shares(made.collisions) - expected) - 0.5
    lines += [f"share {i + 1}: {x:.3f} over" for i, x in enumerate(miss) if x > 0]
    miss = np.abs(np.corrcoef(made.state.T) - point["correlation"]) - 0.01
    lines += [
        f"correlation {COLUMNS[i]}, {COLUMNS[j]}: {miss[i, j]:.4f} over"
        for i, j in zip(*np.triu_indices(6, 1), strict=True)
        if miss[i, j] > 0
    ]
    return lines


def simulate_point(point, count, seed, pair=PAIR, population=POPULATION, **numerics):
    condition = make_condition(np.radians(point["alpha_deg"]), point["speed"], **numerics)
    return simulate_condition(
        pair, population.restricted_to(point["shape"]), condition, count, seed=seed
    )


@pytest.mark.parametrize("name", ORDINARY)
def test_agrees_with_the_reference(name):
    made = simulate_point(POINTS[name], ORDINARY_COUNT, seed=81)
    assert disagreements(made, POINTS[name]) == []


@pytest.fixture(scope="module", params=POINTS)
def studied(request):
    """A reference point and the model's particles there."""
    point = POINTS[request.param]
    return point, simulate_point(point, STUDY_COUNT, seed=82)


@pytest.mark.study
def test_agrees_with_the_reference_everywhere(studied):
    point, made = studied
    assert disagreements(made, point) == []


@pytest.mark.study
def test_quantiles_and_energies_agree_with_the_reference_everywhere(studied):
    point, made = studied
    translational, rotational = made.energy.mean(axis=0)
    assert translational == pytest.approx(point["energy_translational"], abs=2e-3)
    assert rotational == pytest.approx(point["energy_rotational"], abs=2e-3)
    for column, values in zip(COLUMNS, made.state.T, strict=True):
        levels = [np.mean(values <= q) for q in point["quantiles"][column]]
        # besides the noise, the quantiles are rounded to 1e-4
        np.testing.assert_allclose(levels, REFERENCE["quantile_levels"], atol=5e-3)


def test_reference_has_the_documented_conditions():
    assert len(POINTS) == 15
    assert set(ORDINARY) <= set(POINTS)
    assert all(point["count"] == 600_000 for point in POINTS.values())
    assert COLUMNS == ["u", "v", "w", "omega_x", "omega_y", "omega_z"]


def changed_pair(**change):
    resistance = PAIR.resistance.model_copy(update=change)
    return PAIR.model_copy(update={"resistance": resistance})


def test_a_weaker_resistance_disagrees():
    point = POINTS["mixture-45-200"]
    made = simulate_point(point, 100_000, seed=83, pair=changed_pair(strength=0.9))
    assert any(line.startswith("mean u") for line in disagreements(made, point))


def test_a_weaker_restitution_disagrees():
    point = POINTS["mixture-45-200"]
    restitution = PAIR.restitution.model_copy(update={"coefficient": 0.11})
    pair = PAIR.model_copy(update={"restitution": restitution})
    made = simulate_point(point, 100_000, seed=83, pair=pair)
    assert any(line.startswith("mean v") for line in disagreements(made, point))


def test_another_shape_disagrees():
    point = POINTS["truncated-prism-60-200"]
    population = POPULATION.model_copy(update={"truncation": 0.55})
    assert disagreements(simulate_point(point, 100_000, seed=84, population=population), point)
    assert not disagreements(simulate_point(point, 200_000, seed=84), point)


def test_a_coarse_contact_resolution_disagrees():
    point = POINTS["ellipsoid-90-200"]
    made = simulate_point(point, 100_000, seed=85, resolution=0.1)
    assert any(line.startswith("share") for line in disagreements(made, point))


def simulate_by_hand(point, count, seed, tumbles):
    """State and collisions of a point, particle by particle; bodies may be kept from tumbling.

    With equal moments of inertia in flight the angular velocity stays constant between collisions.
    """
    population_args = POPULATION.restricted_to(point["shape"]).kernel_arguments()
    condition = make_condition(np.radians(point["alpha_deg"]), point["speed"])
    state, collisions = np.empty((count, 6)), np.zeros(count, dtype=np.int64)
    motion, vertices = motion_of(np.eye(3)), np.empty((MAX_VERTICES, 3))
    series, contact, _ = workspace()
    for i in range(count):
        shape, ba, cb = draw_particle(population_args, np.uint64(seed), np.uint32(0), i, motion)
        body = make_body(shape, ba, ba * cb, population_args.truncation, vertices)
        flying = body if tumbles else body._replace(moments=(1.0, 1.0, 1.0))
        # without spin the particle starts at its contact
        approach(condition, body, motion)
        touches = True
        while touches:
            gap = contact_point(body, motion, motion[HEIGHT], motion[V], contact)
            motion[HEIGHT] -= min(gap, 0.0)
            collide(LAW, condition.speed, condition.resolution, body.moments, contact, motion)
            collisions[i] += 1
            touches = next_contact(flying, condition.tolerance, motion, series)
        state[i] = [*motion[U:HEIGHT], *wall_spin(motion)]
    return SimpleNamespace(state=state, collisions=collisions)


def test_a_spin_that_stays_constant_in_flight_disagrees():
    point = POINTS["ellipsoid-20-200"]
    right, wrong = (simulate_by_hand(point, 5_000, 86, tumbles) for tumbles in (True, False))
    # the same loop with tumbling is the direct model itself
    np.testing.assert_array_equal(right.state, simulate_point(point, 5_000, seed=86).state)
    # corr(omega_x, omega_y) moves from 0.36 to about -0.08; its standard error is 0.014
    assert any(
        line.startswith("correlation omega_x, omega_y: 0.4") for line in disagreements(wrong, point)
    )
    assert not any("omega_x, omega_y: 0.4" in line for line in disagreements(right, point))
