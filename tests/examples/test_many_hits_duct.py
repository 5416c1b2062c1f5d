"""Geometry of the bend, its gas, and steps through it, against formulae."""

import numpy as np
import pytest
from many_hits.duct import Bend, across, along, gap, gas_velocity, onto_wall, outward
from many_hits.motion import Gas, acceleration, hit_share, step

BEND = Bend(0.1, 0.2, 0.1, 0.3)
SPEED = 120.0


def _points(n, seed=1):
    """Points anywhere in the duct."""
    rng = np.random.default_rng(seed)
    r = rng.uniform(BEND.inner, BEND.outer, n)
    s = rng.uniform(-BEND.before, BEND.length - BEND.before, n)
    turn = np.clip(s / BEND.middle, 0.0, 0.5 * np.pi)
    x = r * np.stack((np.sin(turn), np.cos(turn)))
    x[0] += np.minimum(s, 0.0)
    x[1] -= np.maximum(s - 0.5 * np.pi * BEND.middle, 0.0)
    return x, r, s


def test_places_along_and_across_are_those_that_points_were_made_from():
    x, r, s = _points(1000)
    np.testing.assert_allclose(across(x), r)
    np.testing.assert_allclose(along(BEND, x), s, atol=1e-14)
    np.testing.assert_allclose(gap(BEND, x), np.minimum(r - BEND.inner, BEND.outer - r))


def test_points_are_put_onto_the_nearer_wall_with_normals_into_the_gas():
    x, r, _ = _points(1000)
    on, normal = onto_wall(BEND, x)
    outer = r > BEND.middle
    np.testing.assert_allclose(across(on), np.where(outer, BEND.outer, BEND.inner), rtol=1e-11)
    assert (gap(BEND, on) >= 0.0).all()
    np.testing.assert_allclose((normal * normal).sum(axis=0), 1.0)
    assert (gap(BEND, on + 1e-3 * normal) > 0.9e-3).all()


def test_gas_flows_along_the_duct_at_the_same_rate_everywhere():
    n = 20_000
    r = BEND.inner + BEND.width * (np.arange(n) + 0.5) / n
    for turn, where in ((0.0, (-0.05, 0.0)), (0.7, (0.0, 0.0)), (np.pi / 2, (0.0, -0.1))):
        x = r * np.array([[np.sin(turn)], [np.cos(turn)]]) + np.array(where)[:, None]
        velocity, direction = gas_velocity(BEND, SPEED, x), outward(x)
        np.testing.assert_allclose((velocity * direction).sum(axis=0), 0.0, atol=1e-9)
        forward = velocity[0] * direction[1] - velocity[1] * direction[0]
        assert forward.mean() == pytest.approx(SPEED, rel=1e-8)


def test_gas_has_no_vorticity_and_no_sources():
    x, _, s = _points(1000)
    x = x[:, (s > 0.01) & (s < 0.22)]
    h = 1e-6
    gradient = np.array(
        [
            (gas_velocity(BEND, 1.0, x + shift) - gas_velocity(BEND, 1.0, x - shift)) / (2 * h)
            for shift in h * np.eye(2)[:, :, None]
        ]
    )
    assert np.abs(gradient[0, 0] + gradient[1, 1]).max() < 1e-7
    assert np.abs(gradient[0, 1] - gradient[1, 0]).max() < 1e-7
    assert np.abs(gradient[0, 1]).max() > 1.0  # it does turn


def test_drag_is_that_of_schiller_and_naumann():
    gas = Gas(SPEED, 30e-6)
    v = np.array([[20.0], [0.0], [3.0]])
    slip = np.array([100.0, 0.0, -3.0])
    reynolds = 1.16 * 30e-6 * np.linalg.norm(slip) / 1.85e-5
    expected = slip * (1.0 + 0.15 * reynolds**0.687) * 18.0 * 1.85e-5 / (3950.0 * 30e-6**2)
    found = acceleration(BEND, gas, np.array([[-0.05], [0.15]]), v)
    np.testing.assert_allclose(found[:, 0], expected)


def test_steps_are_of_second_order():
    gas, time = Gas(SPEED, 20e-6), 4e-4
    x0, v0 = np.array([[0.05], [0.14]]), np.array([[90.0], [-30.0], [5.0]])

    def after(steps):
        x, v = x0, v0
        for _ in range(steps):
            path = step(BEND, gas, x, v, np.full(1, time / steps))
            x, v = path.end_x, path.end_v
        return np.concatenate((x[:, 0], v[:, 0]))

    exact = after(1024)
    coarse, fine = (np.abs(after(steps) - exact).max() for steps in (8, 16))
    assert 3.0 < coarse / fine < 5.5


def test_hits_are_where_a_straight_path_meets_the_wall():
    heavy = Gas(SPEED, 1.0)
    x, v = np.array([[0.03], [0.17]]), np.array([[100.0], [40.0], [0.0]])
    path = step(BEND, heavy, x, v, np.full(1, 1e-3))
    share = hit_share(BEND, path)
    # |x + v t| = outer
    b, c = (x * v[:2]).sum(), (x * x).sum() - BEND.outer**2
    time = (-b + np.sqrt(b * b - 10_000.0 * 1.16 * c)) / 11_600.0
    assert share[0] * 1e-3 == pytest.approx(time, rel=1e-4)
    assert gap(BEND, path.place(share))[0] == pytest.approx(0.0, abs=1e-9)
