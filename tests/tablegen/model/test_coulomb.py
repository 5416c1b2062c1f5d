"""Collisions under Coulomb friction: closed forms, small steps by scipy, and what must hold."""

import math

import contact_law_samples as samples
import coulomb_reference as reference
import numpy as np
import pytest
from motion_fixtures import PAIR, POPULATION
from test_collision import mobility_tuple, random_impacts

from tablegen.config.pairs import MaterialPair
from tablegen.model.audit import AUDIT_SIZE, NORMAL, TANGENTIAL, audit_collision
from tablegen.model.coulomb import Ending, coulomb_impulse
from tablegen.model.coulomb_rates import Friction, slip_direction
from tablegen.model.rotation import ORDER
from tablegen.simulation.simulate import make_condition, simulate_condition

#: A resolution that no contact falls below.
NO_FLOOR = 1e-12

#: Mobility, velocity and friction of collisions that do what is rare, found at random.
RARE = {
    "jams": ([4.4, 0.5, 1.0, 2.4, -1.5, 3.5], [0.2, -1.1, -0.2], 1.6),
    "slips anew": ([3.5, 0.4, -2.6, 1.5, 0.4, 6.3], [-1.0, -1.6, -0.6], 0.2),
    "is compressed again": ([2.4, -1.9, 0.6, 3.7, -0.7, 2.8], [-1.6, -0.2, 2.7], 4.2),
}


def matrix_of(entries):
    """Symmetric matrix of A_xx, A_xy, A_xz, A_yy, A_yz, A_zz."""
    matrix = np.zeros((3, 3))
    matrix[np.triu_indices(3)] = entries
    return matrix + np.triu(matrix, 1).T


def collision(matrix, velocity, friction, e, resolution=NO_FLOOR, static=None):
    """Impulse by the kernel, and the energy that its normal part takes."""
    pair = Friction(friction if static is None else static, friction)
    ending = Ending((1.0 - e) * (1.0 + e), resolution)
    entries, velocity = mobility_tuple(np.asarray(matrix)), tuple(map(float, velocity))
    series = np.full((9, ORDER + 1), np.nan)
    made, taken = coulomb_impulse(pair, ending, entries, velocity, series, True)
    return np.array(made), taken


def impulse(*arguments, **options):
    """Impulse by the kernel."""
    return collision(*arguments, **options)[0]


def energy_gained(matrix, velocity, made):
    """Change of the kinetic energy by an impulse."""
    return made @ np.asarray(velocity) + 0.5 * made @ matrix @ made


def test_impulses_are_those_of_small_steps():
    rng = np.random.default_rng(20261122)
    impacts = random_impacts(rng, 90)
    seen = set()
    rows = zip(impacts.mobility(), impacts.contact_velocity, strict=True)
    for matrix, velocity in rows:
        friction, e = float(np.exp(rng.uniform(-5.0, 3.0))), float(rng.choice([0.0, 0.5, 1.0]))
        truth = reference.collide(matrix, velocity, friction, friction, e, 1e-3)
        made = impulse(matrix, velocity, friction, e, 1e-3)
        # the reference takes a slide of 1e-10 for rest
        np.testing.assert_allclose(made, truth.impulse, atol=1e-9 * np.linalg.norm(velocity))
        assert energy_gained(matrix, velocity, made) <= 1e-13
        seen |= truth.seen
    assert {"slides", "sticks", "jams"} <= seen
    # Refused: another friction.
    assert np.abs(impulse(matrix, velocity, 1.001 * friction, e) - truth.impulse).max() > 1e-6


@pytest.mark.parametrize("what", RARE)
def test_rare_collisions_are_those_of_small_steps(what):
    entries, velocity, friction = RARE[what]
    matrix = matrix_of(entries)
    truth = reference.collide(matrix, velocity, friction, friction, 0.5, 1e-6)
    assert what in truth.seen
    made = impulse(matrix, velocity, friction, 0.5, 1e-6)
    np.testing.assert_allclose(made, truth.impulse, atol=1e-9)


def rod(angle):
    """Mobility of the end of a uniform thin rod of half-length one at an angle to the wall."""
    sin, cos = math.sin(angle), math.cos(angle)
    matrix = np.eye(3)
    matrix[:2, :2] += 3.0 * np.array([[sin * sin, sin * cos], [sin * cos, cos * cos]])
    matrix[2, 2] += 3.0
    return matrix


def planar_phases(matrix, u, friction, static):
    """Rates (du/ds, dv/ds) and lengths of a plane collision: a slide, then stick or another."""
    xx, xy, yy = matrix[0, 0], matrix[0, 1], matrix[1, 1]
    way = math.copysign(1.0, u)
    first = xy - friction * way * xx, yy - friction * way * xy
    length = -u / first[0] if first[0] * u < 0.0 else math.inf
    if abs(xy / xx) <= static:
        second = 0.0, yy - xy * xy / xx
    else:
        way = math.copysign(1.0, xy)
        second = xy - friction * way * xx, yy - friction * way * xy
    return [(first, length), (second, math.inf)]


def planar(matrix, u, v, friction, e, static=None):
    """Change of u, last v, normal impulse and its work, piece by piece in closed form."""
    phases = planar_phases(matrix, u, friction, friction if static is None else static)
    s = work = least = 0.0
    start = u
    for (rate_u, rate_v), length in phases:
        if v < 0.0 < rate_v and -v / rate_v <= length:
            step = -v / rate_v
            work += 0.5 * v * step
            least, v, u, s, length = work, 0.0, u + rate_u * step, s + step, length - step
        if v >= 0.0:
            left = work - (1.0 - e * e) * least
            step = (-v + math.sqrt(v * v - 2.0 * rate_v * left)) / rate_v
            if step <= length:
                return u + rate_u * step - start, v + rate_v * step, s + step, work - left
        work += v * length + 0.5 * rate_v * length**2
        u, v, s = u + rate_u * length, v + rate_v * length, s + length
    raise AssertionError("no end")


@pytest.mark.parametrize("angle_deg", [20.0, 50.0, 80.0, 110.0, 150.0])
@pytest.mark.parametrize("friction", [0.05, 0.3, 0.9])
@pytest.mark.parametrize("u", [-1.0, -0.2, 0.3, 1.0])
def test_rods_follow_the_pieces_of_their_plane_motion(angle_deg, friction, u):
    matrix = rod(math.radians(angle_deg))
    for e, static in ((0.0, friction), (0.6, 1.5 * friction), (1.0, friction)):
        change, v, s, work = planar(matrix, u, -0.5, friction, e, static)
        made, taken = collision(matrix, [u, -0.5, 0.0], friction, e, NO_FLOOR, static)
        after = np.array([u, -0.5, 0.0]) + matrix @ made
        np.testing.assert_allclose(after[:2], [u + change, v], atol=1e-11)
        assert made[1] == pytest.approx(s, rel=1e-11)
        assert made[2] == after[2] == 0.0
        assert taken == pytest.approx(-work, abs=1e-12)


def test_work_of_a_slide_that_stops_is_not_that_at_the_mean_velocity():
    matrix, start = rod(math.radians(60.0)), [-0.3, -0.8, 0.0]
    _, v, s, work = planar(matrix, start[0], start[1], 0.25, 0.5)
    made, taken = collision(matrix, start, 0.25, 0.5)
    assert taken == pytest.approx(-work, rel=1e-12)
    assert 0.0 < taken < -energy_gained(matrix, start, made)
    assert abs(taken + 0.5 * s * (start[1] + v)) > 1e-2 * taken


def test_static_friction_holds_a_rod_whose_slide_has_come_to_rest():
    matrix, start = rod(math.radians(60.0)), [-0.3, -0.8, 0.0]
    hold = matrix[0, 1] / matrix[0, 0]
    for static, slides in ((1.001 * hold, False), (0.999 * hold, True)):
        made = impulse(matrix, start, 0.25, 0.5, static=static)
        after = start + matrix @ made
        assert bool(abs(after[0]) > 1e-3) is slides


def newton_gain(matrix, u, v, friction, e):
    """Energy gained if a plane collision ended at Newton's ratio of normal velocities instead."""
    side = s = 0.0
    start = np.array([u, v])
    now = start.copy()
    for (rate_u, rate_v), length in planar_phases(matrix, u, friction, friction):
        step = min(length, (-e * v - now[1]) / rate_v)
        now = now + np.array([rate_u, rate_v]) * step
        s += step
        if step < length:
            break
    side = (now[0] - start[0] - matrix[0, 1] * s) / matrix[0, 0]
    made = np.array([side, s])
    return made @ start + 0.5 * made @ matrix[:2, :2] @ made


def test_newtons_restitution_can_gain_energy_and_the_energetic_one_cannot():
    gains, kept = [], []
    for angle in np.radians(np.arange(5.0, 176.0, 10.0)):
        for u in (-1.0, -0.5, 0.5, 1.0):
            matrix = rod(angle)
            gains.append(newton_gain(matrix, u, -1.0, 0.5, 0.9))
            made = impulse(matrix, [u, -1.0, 0.0], 0.5, 0.9)
            kept.append(energy_gained(matrix, [u, -1.0, 0.0], made))
    # a rod that hits at 0.75 V^2 / 2 or so gains some per cent of it
    assert max(gains) > 0.02
    assert max(kept) < 0.0


def test_without_friction_only_the_normal_velocity_changes():
    for entries, velocity, _ in RARE.values():
        matrix = matrix_of(entries)
        made = impulse(matrix, velocity, 0.0, 0.7)
        expected = [0.0, -1.7 * velocity[1] / matrix[1, 1], 0.0]
        np.testing.assert_allclose(made, expected, atol=1e-12)


def test_endless_friction_sticks_at_once():
    entries, velocity, _ = RARE["jams"]
    matrix, velocity = matrix_of(entries), np.array(velocity)
    # the tangential velocity is stopped under no normal impulse, which changes the normal velocity
    hold = np.linalg.solve(matrix[np.ix_([0, 2], [0, 2])], matrix[[0, 2], 1])
    schur = matrix[1, 1] - matrix[[0, 2], 1] @ hold
    pressed = velocity[1] - hold @ velocity[[0, 2]]
    assert pressed < 0.0
    after = np.array([0.0, -0.7 * pressed, 0.0])
    misses = []
    for friction in (1e2, 1e4):
        made = impulse(matrix, velocity, friction, 0.7)
        assert made[1] == pytest.approx(-1.7 * pressed / schur, rel=3.0 / friction)
        misses.append(np.abs(velocity + matrix @ made - after).max())
    assert misses[1] < 0.02 * misses[0] < 0.02


def test_slip_from_rest_keeps_its_direction():
    rng = np.random.default_rng(5)
    found = 0
    while found < 50:
        matrix = random_impacts(rng, 4).mobility()[0]
        block, pull = matrix[np.ix_([0, 2], [0, 2])], matrix[[0, 2], 1]
        friction = np.linalg.norm(np.linalg.solve(block, pull)) * rng.uniform(0.0, 0.99)
        if friction == 0.0:
            continue
        e = np.array(slip_direction(friction, mobility_tuple(matrix), True))
        rate = pull - friction * block @ e
        assert rate @ e > 0.0
        assert abs(rate[0] * e[1] - rate[1] * e[0]) <= 1e-12 * np.linalg.norm(pull)
        found += 1


def pair_of(e, static, dynamic):
    """A pair with constant restitution and Coulomb friction."""
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
    made = simulate_condition(
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
    np.testing.assert_allclose(made.state, np.tile(expected, (10, 1)), rtol=0.0, atol=1e-13)


@pytest.mark.parametrize("alpha_deg", [2.0, 45.0, 90.0])
def test_lanes_have_the_bits_of_single_particles_and_pass_the_audit(alpha_deg):
    for friction in (0.1, 2.0):
        given = pair_of(0.6, 1.2 * friction, friction), POPULATION
        condition = make_condition(math.radians(alpha_deg), 100.0)
        single = simulate_condition(*given, condition, 40, seed=3, audited=True)
        lanes = simulate_condition(*given, condition, 40, seed=3)
        np.testing.assert_array_equal(lanes.state, single.state)
        assert single.audit.max() < 1e-9


def test_no_friction_is_no_resistance():
    none = PAIR.model_copy(
        update={
            "restitution": pair_of(0.6, 0.0, 0.0).restitution,
            "resistance": MaterialPair.from_tree(
                {
                    "particle": "any",
                    "wall": "any",
                    "restitution": samples.SOURCE | samples.RESTITUTION["constant"],
                    "resistance": samples.SOURCE | {"law": "constant", "value": 0.0},
                }
            ).resistance,
        }
    )
    condition = make_condition(math.radians(45.0), 100.0)
    free, coulomb = (
        simulate_condition(pair, POPULATION, condition, 300, seed=4)
        for pair in (none, pair_of(0.6, 0.0, 0.0))
    )
    np.testing.assert_array_equal(coulomb.collisions, free.collisions)
    np.testing.assert_allclose(coulomb.state, free.state, rtol=0.0, atol=1e-8)


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
