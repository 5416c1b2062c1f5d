"""Moments of shapes and of their mixtures, against hand-made states and plain sums."""

import math

import numpy as np
import pytest

from tablegen.measured.records import QUANTITIES
from tablegen.measured.strata import (
    N_VARIABLES,
    CentralMoments,
    Strata,
    central_moments,
    merged,
    variables_of,
)

#: Two shapes of four states each: u, v, w, omega_x, omega_y, omega_z.
FIRST = np.array(
    [
        [0.5, 0.2, 0.0, 0.0, 0.0, -0.4],
        [0.7, 0.2, 0.3, 9.0, 9.0, -0.2],
        [-0.1, 0.4, -0.3, 9.0, 9.0, 0.2],
        [0.5, 0.4, 0.0, 0.0, 9.0, -0.4],
    ]
)
SECOND = np.array(
    [
        [0.1, 0.8, 0.1, 0.0, 0.0, 0.1],
        [0.3, 0.6, 0.1, 0.0, 0.0, 0.3],
        [0.2, 0.3, -0.2, 0.0, 0.0, 0.2],
        [0.2, 0.1, 0.0, 0.0, 0.0, -0.6],
    ]
)


def strata_of(*samples, alpha_deg=30.0, shares=None):
    """Strata of one row from the states of each shape, all of one number."""
    parts = [central_moments(variables_of(states)) for states in samples]
    names = ("mean", "second", "third", "fourth", "covariance")
    moments = CentralMoments(
        len(samples[0]), *(np.array([[getattr(part, n) for part in parts]]) for n in names)
    )
    equal = np.full(len(samples), 1.0 / len(samples))
    return Strata(np.array([alpha_deg]), equal if shares is None else np.array(shares), moments)


def test_quantities_of_hand_made_states():
    found = strata_of(FIRST).mixed()
    s, c = 0.5, math.sqrt(0.75)
    assert set(found.mean) == set(QUANTITIES) == set(found.std)
    assert found.mean["e_n"][0] == pytest.approx(0.3 / s)
    assert found.std["e_n"][0] == pytest.approx(0.1 / s)
    assert found.mean["e_t"][0] == pytest.approx(0.4 / c)
    assert found.std["e_t"][0] == pytest.approx(0.3 / c)
    # the angle of the mean velocity; the spread of the particles' own angles, one beyond 90
    assert found.mean["rebound_angle_deg"][0] == pytest.approx(math.degrees(math.atan2(0.3, 0.4)))
    angles = np.degrees([math.atan2(v, u) for u, v in FIRST[:, :2]])
    assert angles.max() > 90.0
    assert found.std["rebound_angle_deg"][0] == pytest.approx(angles.std())
    out = [math.degrees(math.asin(s[2] / np.linalg.norm(s[:3]))) for s in FIRST]
    assert found.mean["out_of_plane_deg"][0] == pytest.approx(np.mean(out))
    assert found.std["out_of_plane_deg"][0] == pytest.approx(np.std(out))
    assert found.mean["omega_z"][0] == pytest.approx(-0.2)
    assert found.std["omega_z"][0] == pytest.approx(math.sqrt(0.06))


def test_turned_states_have_turned_angles():
    """About the wall's normal: out of the plane by the turn, and nothing else at normal impact."""
    turned = np.array([[0.3, 0.4, 0.0, 0.0, 0.0, 0.0]] * 2)
    turn = math.radians(25.0)
    turned[:, 0], turned[:, 2] = 0.3 * math.cos(turn), 0.3 * math.sin(turn)
    out = math.degrees(math.asin(0.3 * math.sin(turn) / 0.5))
    assert strata_of(turned).mixed().mean["out_of_plane_deg"][0] == pytest.approx(out)
    mirrored = turned * [1.0, 1.0, -1.0, -1.0, -1.0, 1.0]
    assert strata_of(mirrored).mixed().mean["out_of_plane_deg"][0] == pytest.approx(-out)


def test_tangential_restitution_has_no_meaning_at_normal_impact():
    found = strata_of(FIRST, alpha_deg=90.0).mixed()
    for moments in (found.mean, found.std, found.mean_error, found.std_error):
        assert np.isnan(moments["e_t"]).all()
        assert all(np.isfinite(moments[name]).all() for name in QUANTITIES if name != "e_t")


def test_parts_together_are_the_whole():
    rng = np.random.default_rng(1)
    x = rng.gamma(2.0, 1.0, (1000, N_VARIABLES))
    whole = central_moments(x)
    parts = merged(
        merged(central_moments(x[:300]), central_moments(x[300:500])), central_moments(x[500:])
    )
    assert parts.count == whole.count
    for name in ("mean", "second", "third", "fourth", "covariance"):
        np.testing.assert_allclose(getattr(parts, name), getattr(whole, name), rtol=1e-12)


def test_a_mixture_is_its_particles_put_together():
    """Shares 3/4 and 1/4 are three copies of the states of one shape and one of the other's."""
    mixed = strata_of(FIRST, SECOND).mixed([0.75, 0.25])
    together = strata_of(np.vstack([FIRST] * 3 + [SECOND])).mixed()
    for name in QUANTITIES:
        np.testing.assert_allclose(mixed.mean[name], together.mean[name], rtol=1e-13)
        np.testing.assert_allclose(mixed.std[name], together.std[name], rtol=1e-13)


def test_raw_moments_are_linear_in_the_shares():
    strata = strata_of(FIRST, SECOND)
    ends = [strata.mixed(shares) for shares in ([1.0, 0.0], [0.0, 1.0])]

    def raw(found, name):
        return np.array([found.mean[name][0], found.mean[name][0] ** 2 + found.std[name][0] ** 2])

    for share in (0.0, 0.2, 0.5, 0.9):
        mixed = strata.mixed([1.0 - share, share])
        for name in ("e_n", "e_t", "out_of_plane_deg", "omega_z"):
            line = (1.0 - share) * raw(ends[0], name) + share * raw(ends[1], name)
            np.testing.assert_allclose(raw(mixed, name), line, rtol=1e-13)


def test_equal_states_have_no_spread_and_no_error():
    found = strata_of(np.repeat(FIRST[:1], 5, axis=0)).mixed()
    for name in QUANTITIES:
        assert found.std[name][0] < 1e-14
        assert found.mean_error[name][0] < 1e-14
        assert np.isfinite(found.std_error[name][0])


def test_chance_errors_are_the_scatter_of_repetitions():
    """600 repetitions of two strata: a standard deviation of them is within 15 %, five errors."""
    rng, repetitions, n = np.random.default_rng(2), 600, 200
    shares = np.array([0.3, 0.7])

    def states():
        some = rng.gamma((4.0, 2.0, 3.0, 1.0, 1.0, 2.0), 0.1, (n, 6))
        others = rng.uniform((-0.4, 0.1, -0.3, 0, 0, -1), (0.2, 0.3, 0.3, 1, 1, 0), (n, 6))
        return some, others

    runs = [strata_of(*states()).mixed(shares) for _ in range(repetitions)]
    for name in QUANTITIES:
        for value, error in (("mean", "mean_error"), ("std", "std_error")):
            scatter = np.std([getattr(run, value)[name][0] for run in runs])
            told = np.mean([getattr(run, error)[name][0] for run in runs])
            assert told == pytest.approx(scatter, rel=0.15), (name, value)
