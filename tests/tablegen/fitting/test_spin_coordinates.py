"""Coordinates, features and outcomes of the spin law, within their bounds."""

import math

import numpy as np
import pytest

from tablegen.fitting.spin_coordinates import (
    CONDITION_SIGNS,
    OUTCOME_SIGNS,
    SpeedCoordinate,
    coordinates,
    features,
    folded,
    outcomes,
    used_features,
)

N = 500
SPEED = SpeedCoordinate(0.1, 0.61)


@pytest.fixture
def conditions():
    rng = np.random.default_rng(1)
    spin = rng.normal(0.0, 2.0, (N, 3))
    return np.column_stack([rng.uniform(0.01, 1.57, N), rng.uniform(1.0, 300.0, N), spin])


def test_coordinates_are_bounded_for_any_spin(conditions):
    conditions[:, 2:] *= np.geomspace(1e-6, 1e6, N)[:, None]
    q = coordinates(conditions, SPEED)
    assert np.isfinite(q).all()
    # |tau|^2 = |s|^2 / (1 + |s|^2)^(1/2) of the largest spin that a law covers
    assert (np.sum(q[:, 2:] ** 2, axis=1) < 100.0 / math.sqrt(101.0) + 1e-9).all()


def test_fold_is_the_reflection_in_the_impact_plane(conditions):
    q, image = (coordinates(c, SPEED) for c in (conditions, conditions * CONDITION_SIGNS))
    once, signs = folded(q, q[:, 2] < 0.0)
    assert (once[:, 2] >= 0.0).all()
    other, other_signs = folded(image, image[:, 2] < 0.0)
    np.testing.assert_array_equal(once, other)
    np.testing.assert_array_equal(signs * other_signs, np.tile(OUTCOME_SIGNS, (N, 1)))


def test_outcomes_can_be_turned_back_into_states(conditions):
    rng = np.random.default_rng(3)
    energy = 1.0 + 0.4 * np.sum(conditions[:, 2:] ** 2, axis=1)
    factor = np.sqrt(energy)[:, None]
    velocity = rng.normal(size=(N, 3))
    size = rng.uniform(0.0, 0.99, (N, 1)) * factor
    velocity *= size / np.linalg.norm(velocity, axis=1, keepdims=True)
    states = np.hstack([velocity, rng.normal(size=(N, 3))])
    x = outcomes(states, energy)
    back = x[:, :3] / np.sqrt(1.0 + np.sum(x[:, :3] ** 2, axis=1))[:, None]
    again = factor * np.hstack([back, x[:, 3:]])
    np.testing.assert_allclose(again, states, rtol=1e-9, atol=1e-9)


def test_features_are_the_inputs_and_the_products_of_conditions():
    t = np.array([[2.0, -1.0, 0.5, 3.0, 0.0, 7.0, 11.0]])
    products = [t[0, i] * t[0, j] - 0.5 * (i == j) for i in range(5) for j in range(i, 5)]
    np.testing.assert_array_equal(features(t), [[1.0, *t[0], *products]])
    varies = np.array([True, True, False, False, False, True, False])
    # 1, three inputs, and the three products of the first two
    assert np.flatnonzero(used_features(varies)).tolist() == [0, 1, 2, 6, 8, 9, 13]
