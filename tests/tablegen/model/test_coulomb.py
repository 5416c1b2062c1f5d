"""Collisions under Coulomb friction: closed forms, small steps, and the audit."""

import math

import contact_law_samples as samples
import numpy as np
import pytest
from audit import AUDIT_SIZE, NORMAL, TANGENTIAL, audit_collision, state_after_impulse
from motion_fixtures import CONFIG, POPULATION
from one_particle import simulate_alone
from test_collision import mobility_tuple, random_impacts

from sampler.errors import REBOUND_NOT_ENDED, InputError
from tablegen.config.pairs import MaterialPair
from tablegen.model.coulomb import PIECE_ALARM, Ending, coulomb_impulse
from tablegen.model.rebound import COLLISION_ALARM
from tablegen.model.rotation import ORDER
from tablegen.model.sliding import Friction
from tablegen.simulation.direct import model_without_warnings
from tablegen.simulation.simulate import make_condition, simulate_condition

COULOMB_1 = samples.SOURCE | {"law": "coulomb", "static": 1.0, "dynamic": 1.0}

#: A resolution that no contact falls below.
NO_FLOOR = 1e-12

#: Mobility, velocity and friction of rare kinds of collisions, found at random.
RARE = {
    "jams": ([4.4, 0.5, 1.0, 2.4, -1.5, 3.5], [0.2, -1.1, -0.2], 1.6),
    "slips anew": ([3.5, 0.4, -2.6, 1.5, 0.4, 6.3], [-1.0, -1.6, -0.6], 0.2),
    "is compressed again, by less": (
        [5.95, -4.71, -3.57, 5.13, 4.01, 3.76],
        [-1.22, -2.06, -1.65],
        0.903,
    ),
    "is compressed again": ([2.4, -1.9, 0.6, 3.7, -0.7, 2.8], [-1.6, -0.2, 2.7], 4.2),
}


def matrix_of(entries):
    matrix = np.zeros((3, 3))
    matrix[np.triu_indices(3)] = entries
    return matrix + np.triu(matrix, 1).T


def collision(matrix, velocity, friction, e, resolution=NO_FLOOR, static=None):
    """Compute an impulse by the kernel, and the energy that its normal part takes."""
    pair = Friction(friction if static is None else static, friction)
    ending = Ending((1.0 - e) * (1.0 + e), resolution)
    entries, velocity = mobility_tuple(np.asarray(matrix)), tuple(map(float, velocity))
    series = np.full((9, ORDER + 1), np.nan)
    impulse, taken = coulomb_impulse(pair, ending, entries, velocity, series, True)
    return np.array(impulse), taken


def energy_gained(matrix, velocity, impulse):
    return impulse @ np.asarray(velocity) + 0.5 * impulse @ matrix @ impulse


def miss_of_small_steps(matrix, velocity, static, friction, e, resolution):
    """Return the largest difference between the kernel and small steps along the equations."""
    impulse, taken = collision(matrix, velocity, friction, e, resolution, static)
    assert energy_gained(matrix, velocity, impulse) <= 1e-13
    # no more than an elastic collision gives back, although friction would take it; of random
    # collisions, one in ten reaches the resolution only beyond that
    assert taken >= -1e-13
    given = mobility_tuple(matrix), tuple(map(float, velocity)), impulse[1]
    *after, work, least = state_after_impulse(static, friction, *given)
    end_velocity = velocity + matrix @ impulse
    # the collision ends with its share of the work, at the resolution, or elastically
    end = min(abs(work - (1.0 - e * e) * least), abs(end_velocity[1] - resolution), abs(work))
    return max(np.abs(end_velocity - after).max(), abs(work + taken), end)


def test_impulses_are_those_of_small_steps():
    rng = np.random.default_rng(20261122)
    impacts = random_impacts(rng, 90)
    for matrix, velocity in zip(impacts.mobility(), impacts.contact_velocity, strict=True):
        friction, e = float(np.exp(rng.uniform(-5.0, 3.0))), float(rng.choice([0.0, 0.5, 1.0]))
        static = friction * float(rng.choice([1.0, 1.5]))
        miss = miss_of_small_steps(matrix, velocity, static, friction, e, 1e-3)
        assert miss <= 1e-9 * np.linalg.norm(velocity)


@pytest.mark.parametrize("case", RARE)
def test_rare_collisions_are_those_of_small_steps(case):
    entries, velocity, friction = RARE[case]
    matrix, velocity = matrix_of(entries), np.array(velocity)
    assert miss_of_small_steps(matrix, velocity, friction, friction, 0.5, 1e-6) <= 1e-9


#: Mobility and velocity of contacts whose rebounds did not end, or hardly.
CREEPS = (
    (
        *(2.837983603186416, -1.848029441445208, -1.6549393767362575),
        *(5.342501005504098, -0.15334846180559186, 3.8195153913094897),
    ),
    (0.3053817284871628, -0.5802466723623405, 0.0453622081920772),
)
FALLS_AT_LAST = (
    (
        *(2.8887772889168817, -0.8266990594663597, -0.011596226429955836),
        *(1.563621887442887, -0.6164315374817615, 2.9143518945270133),
    ),
    (0.0021247529568432233, -0.0010162544057655265, 0.0006266332894869497),
)


@pytest.mark.parametrize("excess", [0.0, 1e-9, 1e-5, 1e-3])
def test_a_slide_that_nearly_dies_grows_again_in_the_direction_that_it_can_keep(excess):
    # it falls to 2e-13 of the contact speed, and the pull of the wall is larger than friction by
    # up to 1e-3; the case found was 3.9e-4
    matrix, velocity = matrix_of(CREEPS[0]), np.array(CREEPS[1])
    pull = np.linalg.solve(matrix[::2, ::2], matrix[::2, 1])
    friction = float(np.linalg.norm(pull)) / (1.0 + excess)
    assert miss_of_small_steps(matrix, velocity, friction, friction, 0.24, 1e-3) <= 1e-9
    assert miss_of_small_steps(matrix, velocity, 1.0, 1.0, 0.24, 1e-3) <= 1e-9


def test_no_collision_ends_below_the_resolution_unless_it_is_elastic():
    # the velocity falls on the last piece before rest, far below the resolution; it ended there,
    # and the bounces of 2e-6 that followed were a hundred thousand
    matrix, velocity = matrix_of(FALLS_AT_LAST[0]), np.array(FALLS_AT_LAST[1])
    impulse, taken = collision(matrix, velocity, 3.0, 0.0, 1e-3)
    bounce = (velocity + matrix @ impulse)[1]
    assert bounce == pytest.approx(1e-3, rel=1e-12) or abs(taken) < 1e-18
    assert bounce > 1e-4
    assert miss_of_small_steps(matrix, velocity, 3.0, 3.0, 0.0, 1e-3) <= 1e-9 * 2.4e-3


def pair_of(e, static, dynamic):
    resistance = {"law": "coulomb", "static": static, "dynamic": dynamic}
    laws = {
        "restitution": samples.SOURCE | {"law": "constant", "value": e},
        "resistance": samples.SOURCE | resistance,
    }
    return MaterialPair.from_tree({"particle": "any", "wall": "any", **laws})


@pytest.mark.parametrize("spin", [(0.0, 0.0, 0.0), (0.4, -1.0, -0.9), (-2.0, 3.0, 1.0)])
@pytest.mark.parametrize("friction", [0.05, 0.2, 1.0])
def test_spheres_follow_their_closed_form_with_any_spin(friction, spin):
    alpha = math.radians(40.0)
    simulation = simulate_condition(
        pair_of(0.8, 2.0 * friction, friction),
        POPULATION.restricted_to("sphere"),
        make_condition(alpha, 100.0, spin),
        10,
        seed=1,
    )
    # a point a below the centre slides at v + Omega x r, and 7/2 is its mobility along the wall
    slide = np.array([math.cos(alpha) + spin[2], -spin[0]])
    s = 1.8 * math.sin(alpha)
    side = -slide * min(friction * s / np.linalg.norm(slide), 2.0 / 7.0)
    expected = [
        math.cos(alpha) + side[0],
        0.8 * math.sin(alpha),
        side[1],
        spin[0] - 2.5 * side[1],
        spin[1],
        spin[2] + 2.5 * side[0],
    ]
    np.testing.assert_allclose(simulation.state, np.tile(expected, (10, 1)), rtol=0.0, atol=1e-13)


@pytest.mark.parametrize("alpha_deg", [2.0, 45.0, 90.0])
def test_lanes_have_the_bits_of_single_particles_and_pass_the_audit(alpha_deg):
    for friction in (0.1, 2.0):
        given = pair_of(0.6, 1.2 * friction, friction), POPULATION
        condition = make_condition(math.radians(alpha_deg), 100.0)
        values, _, audit = simulate_alone(*given, condition, 40, seed=3)
        lanes = simulate_condition(*given, condition, 40, seed=3)
        np.testing.assert_array_equal(lanes.state, values[:, :6])
        assert audit.max() < 1e-9


@pytest.mark.parametrize(("alpha_deg", "spin"), [(62.0, (0.0, 0.0, 0.0)), (10.0, (0.5, -1.0, 1.0))])
def test_rebounds_end_where_the_pull_of_the_wall_is_near_the_friction(alpha_deg, spin):
    # of the second condition some 6 did not, and particle 11659 of the first
    config = CONFIG.with_changes({"pair": {"resistance": COULOMB_1}})
    keys = {"seed": 5, "index": np.arange(9700, 11700), "hit": 0, "threads": 1}
    rebounds = model_without_warnings(config).sample(
        math.radians(alpha_deg), 200.0, spin=spin, **keys
    )
    assert (rebounds[:, 1] > 0.0).all()


def test_a_path_that_does_not_end_is_an_error_that_names_the_row(monkeypatch):
    usual = MaterialPair.kernel_arguments

    def broken(pair, only_spheres):
        return usual(pair, only_spheres)._replace(factor=math.nan)

    monkeypatch.setattr(MaterialPair, "kernel_arguments", broken)
    config = CONFIG.with_changes({"pair": {"resistance": COULOMB_1}})
    model, given = model_without_warnings(config), ([10.0, -20.0, 0.0], [0.0, 1.0, 0.0], 1e-5)
    with pytest.raises(InputError, match=r"did not leave the wall; .* at row 0 "):
        model.sample(0.5, 100.0, seed=1, index=range(3))
    for roughness in (None, 0.1):
        codes = np.empty(3, np.intc)
        after = model.rebound(*given, seed=1, index=range(3), roughness=roughness, codes=codes)
        assert set(codes) == {REBOUND_NOT_ENDED}
        assert np.isnan(after.velocity).all()
    alarm = f" after {COLLISION_ALARM:,} collisions, or {PIECE_ALARM:,} pieces"
    for simulated, limits in ((simulate_condition, alarm), (simulate_alone, "")):
        with pytest.raises(RuntimeError, match=f"is still in contact{limits}"):
            simulated(config.pair, POPULATION, make_condition(0.5, 100.0), 3, seed=3)


def test_audit_reports_another_friction_and_another_restitution():
    law = pair_of(0.6, 0.3, 0.3).kernel_arguments()
    # a sphere that slides throughout, with an impulse of 0.29 instead of 0.3
    before = np.array([0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.9, -0.1, 0.0, 1.0])
    point, moments = np.array([0.0, -1.0, 0.0]), (0.4, 0.4, 0.4)
    for normal, side, wrong in ((0.16, 0.3, None), (0.16, 0.29, TANGENTIAL), (0.17, 0.3, NORMAL)):
        after, audit = before.copy(), np.zeros(AUDIT_SIZE)
        after[10] += normal
        after[9] -= side * normal
        # axes x, n = y, z = x times n of the body and of the wall agree
        after[2] -= 2.5 * side * normal
        audit_collision(law, 100.0, 1e-3, moments, point, before, after, audit)
        if wrong is None:
            assert audit.max() < 1e-12
        else:
            assert audit[wrong] > 1e-4
