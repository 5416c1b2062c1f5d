"""Gas, drag, and flight to the wall, against closed forms and an independent integration."""

import math

import numpy as np
import pytest
from dusty_gas.case import Case
from dusty_gas.gas import BODIES, CYLINDER, SPHERE, Flow, acceleration, gas_velocity
from dusty_gas.motion import advance, climb, gap, step
from dusty_gas.tracker import STEP
from scipy.integrate import solve_ivp

CODES = (CYLINDER, SPHERE)


def _gas(body, place):
    return np.array(gas_velocity(body, *place))


def _places(n, seed=0):
    """Points outside the body, up to three radii away."""
    rng = np.random.default_rng(seed)
    direction = rng.standard_normal((n, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    return direction * rng.uniform(1.5, 3.0, (n, 1))


@pytest.mark.parametrize("body", CODES, ids=BODIES)
def test_gas_has_no_sources_and_no_vortices(body):
    d = 1e-5
    for place in _places(20):
        gradient = np.array(
            [(_gas(body, place + d * e) - _gas(body, place - d * e)) / (2 * d) for e in np.eye(3)]
        )
        assert abs(np.trace(gradient)) < 1e-8
        assert np.abs(gradient - gradient.T).max() < 1e-8


@pytest.mark.parametrize(("body", "fastest"), [(CYLINDER, 2.0), (SPHERE, 1.5)], ids=BODIES)
def test_gas_flows_along_the_body_and_is_the_stream_far_away(body, fastest):
    for angle in np.linspace(0.0, np.pi, 13):
        place = np.array([math.cos(angle), math.sin(angle), 0.0])
        gas = _gas(body, place)
        assert abs(gas @ place) < 1e-14
        assert np.linalg.norm(gas) == pytest.approx(fastest * math.sin(angle), abs=1e-14)
    np.testing.assert_allclose(_gas(body, [1e4, 2e4, 0.0]), [1.0, 0.0, 0.0], atol=1e-7)


def test_drag_of_stokes_and_of_schiller_and_naumann():
    gas = np.array(gas_velocity(CYLINDER, -2.0, 1.0, 0.0))
    slip = gas - np.array([1.2, 0.1, 0.3])
    stokes = acceleration(Flow(CYLINDER, 0.5, 0.0), -2.0, 1.0, 0.0, 1.2, 0.1, 0.3)
    np.testing.assert_allclose(stokes, 0.5 * slip, rtol=1e-14)
    # At Re = 100 the correction is 1 + 0.15 100^0.687 = 4.549; its drag coefficient is 1.092.
    reynolds = 100.0 / np.linalg.norm(slip)
    corrected = acceleration(Flow(CYLINDER, 0.5, reynolds), -2.0, 1.0, 0.0, 1.2, 0.1, 0.3)
    np.testing.assert_allclose(corrected, 0.5 * 4.5488 * slip, rtol=1e-4)


def test_numbers_of_a_case():
    # 18 mu R St = 18 1.85e-5 0.1 10 = 3.33e-4; over 3950 200 = 4.215e-10; root 2.053e-5
    case = Case("sphere", 10.0, 200.0)
    assert case.diameter == pytest.approx(2.053e-5, rel=1e-3)
    assert case.reynolds == pytest.approx(1.16 * 200.0 * 2.053e-5 / 1.85e-5, rel=1e-3)
    assert case.flow().response == 0.1


def _fly(flow, p, total, n):
    """Fly for a time in n steps, reflected like light at the wall; where and how fast at the end.

    The steps before and after a hit are parts of one.
    """
    hits = 0
    for _ in range(n):
        left = total / n
        while left > 0.0:
            hit, passed, p = advance(flow, p, left)
            left -= passed
            if not hit:
                break
            hits += 1
            normal = np.array(p[:3]) * ([1, 1, 0] if flow.body == CYLINDER else [1, 1, 1])
            velocity = np.array(p[3:])
            p = (*p[:3], *(velocity - 2.0 * (velocity @ normal) * normal))
    return np.array(p), hits


@pytest.mark.parametrize("body", CODES, ids=BODIES)
@pytest.mark.parametrize("reynolds", [0.0, 80.0])
def test_fourth_order_also_through_a_hit(body, reynolds):
    flow = Flow(body, 0.3, reynolds)
    start = (-3.0, 0.3, 0.1, 1.0, 0.0, 0.0)
    truth, hits = _fly(flow, start, 6.0, 3200)
    assert hits == 1
    errors = [np.abs(_fly(flow, start, 6.0, n)[0] - truth).max() for n in (100, 200, 400, 800)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders.min() > 3.5
    assert orders.max() < 4.7
    # At the step that the tracker takes nothing is lost that a picture or a test would show.
    assert np.abs(_fly(flow, start, 6.0, round(6.0 / STEP))[0] - truth).max() < 1e-5


@pytest.mark.parametrize("body", CODES, ids=BODIES)
def test_without_drag_particles_fly_straight(body):
    flow = Flow(body, 0.0, 0.0)
    for offset in (0.0, 0.3, -0.9, 0.9999999):
        p = (-1.05, offset, 0.0, 1.0, 0.0, 0.0)
        hit, time, q = advance(flow, p, 5.0)
        x = -math.sqrt(1.0 - offset * offset)
        assert hit
        assert time == pytest.approx(x + 1.05, abs=1e-9)
        np.testing.assert_allclose(q, (x, offset, 0.0, 1.0, 0.0, 0.0), atol=1e-9)
        assert abs(gap(flow, q)) < 1e-15
    assert not advance(flow, (-1.05, 1.0000001, 0.0, 1.0, 0.0, 0.0), 5.0)[0]


def test_no_hit_is_jumped_over():
    """Long steps near the body against two hundred short ones."""
    rng = np.random.default_rng(4)
    grazing = 0
    for k in range(400):
        flow = Flow(CODES[k % 2], 1.0, 50.0)
        # From around the surface, nearly along it, so that many paths graze it.
        angle = rng.uniform(0.0, 2.0 * np.pi)
        normal = np.array([math.cos(angle), math.sin(angle), 0.0])
        along = np.array([-normal[1], normal[0], 0.0])
        place = normal * (1.0 + rng.uniform(0.0, 0.005))
        velocity = along * rng.choice([-1.0, 1.0]) + normal * rng.uniform(-0.06, 0.02)
        p = (*place, *velocity)
        length = 0.1
        hit, time, q = advance(flow, p, length)
        lowest = min(gap(flow, step(flow, p, t)) for t in np.linspace(0.0, length, 201)[1:])
        if abs(lowest) > 1e-7:
            assert hit == (lowest < 0.0)
            grazing += lowest < 0.0 < gap(flow, step(flow, p, length))
        if hit:
            before = [gap(flow, step(flow, p, t)) for t in np.linspace(0.0, time, 101)[:-1]]
            assert min(before) > 0.0
            assert abs(gap(flow, q)) < 1e-15
            assert climb(flow, q) < 0.0
    # The check has something to see: paths that hit, although the step ends outside.
    assert grazing > 10


def test_a_particle_thrown_off_falls_back():
    """Near the stagnation point it swings with angular frequency sqrt(4 k St - 1) / (2 St)."""
    stokes, speed, gradient = 2.0, 1e-4, 2.0
    flow = Flow(CYLINDER, 1.0 / stokes, 0.0)
    passed, q = _first_hit(flow, (-1.0, 0.0, 0.0, -speed, 0.0, 0.0))
    half_period = 2.0 * np.pi * stokes / math.sqrt(4.0 * gradient * stokes - 1.0)
    assert passed == pytest.approx(half_period, rel=1e-3)
    assert q[3] == pytest.approx(speed * math.exp(-0.5 * half_period / stokes), rel=1e-3)


def _reference_end(flow, p, span=12.0):
    """Impact by an independent integrator with an event: None if there is none."""
    sphere = flow.body == SPHERE

    def slope(_, s):
        x, y, u, v = s
        if sphere:
            r = math.hypot(x, y)
            gas = (1.0 + 0.5 / r**3 - 1.5 * x * x / r**5, -1.5 * x * y / r**5)
        else:
            # dW/dz of the complex potential W = z + 1/z
            w = 1.0 - 1.0 / complex(x, y) ** 2
            gas = (w.real, -w.imag)
        du, dv = gas[0] - u, gas[1] - v
        rate = flow.response * (1.0 + 0.15 * (flow.reynolds * math.hypot(du, dv)) ** 0.687)
        return u, v, rate * du, rate * dv

    def surface(_, s):
        return math.hypot(s[0], s[1]) - 1.0

    surface.terminal = True
    made = solve_ivp(
        slope,
        (0.0, span),
        (p[0], p[1], p[3], p[4]),
        "DOP853",
        events=surface,
        rtol=1e-11,
        atol=1e-12,
        max_step=0.05,
    )
    return (made.t_events[0][0], made.y_events[0][0]) if len(made.t_events[0]) else None


def _first_hit(flow, p, span=12.0):
    """Time and state of the first hit by the tracker's steps."""
    passed = 0.0
    while passed < span:
        hit, time, p = advance(flow, p, STEP)
        passed += time
        if hit:
            return passed, p
    return None


@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize("stokes", [1.0, 30.0])
def test_impact_against_an_independent_integration(body, stokes):
    flow = Case(body, stokes).flow()
    start = (-4.0, 0.1, 0.0, 1.0, 0.0, 0.0)
    time, q = _first_hit(flow, start)
    expected_time, expected = _reference_end(flow, start)
    assert time == pytest.approx(expected_time, abs=2e-6)
    np.testing.assert_allclose([q[0], q[1], q[3], q[4]], expected, atol=1e-5)


@pytest.mark.parametrize("body", BODIES)
def test_collection_efficiency_against_an_independent_integration(body):
    """The largest offset in the stream from which a particle still hits."""
    flow = Case(body, 1.0).flow()

    def critical(hits):
        low, high = 0.0, 1.0
        for _ in range(14):
            middle = 0.5 * (low + high)
            if hits(flow, (-4.0, middle, 0.0, 1.0, 0.0, 0.0)) is None:
                high = middle
            else:
                low = middle
        return low

    ours = critical(_first_hit)
    assert ours == pytest.approx(critical(_reference_end), abs=2e-4)
    # Plain Stokes drag would catch many more.
    assert critical(lambda f, p: _first_hit(f._replace(reynolds=0.0), p)) > ours + 0.1


@pytest.mark.parametrize(("body", "least"), [(CYLINDER, 1 / 8), (SPHERE, 1 / 12)], ids=BODIES)
def test_least_stokes_number_that_hits(body, least):
    """On the axis, gas slows down as 2 (cylinder) or 3 (sphere) times the distance to the wall.

    A particle with Stokes drag is an oscillator there, St y'' + y' + k y = 0: it creeps up to the
    wall if 4 k St < 1 and never meets it, and hits it otherwise.
    """
    start = (-4.0, 0.0, 0.0, 1.0, 0.0, 0.0)
    assert _first_hit(Flow(body, 1.0 / (0.9 * least), 0.0), start, span=9.0) is None
    assert _first_hit(Flow(body, 1.0 / (1.6 * least), 0.0), start, span=9.0) is not None
