"""Coordinates, features and outcomes of the spin law: those of the draw, within their bounds."""

import numpy as np
import pytest
from sampler.drawing.spin_steps import fill_features, fill_state

from sampler.formats.bounds import N_FEATURES, N_INPUTS
from tablegen.fitting.coordinates import (
    OUTCOME_SIGNS,
    SpeedCoordinate,
    coordinates,
    features,
    folded,
    outcomes,
    used_features,
)
from tablegen.model.jit import kernel
from tablegen.simulation.impact_chains import energy_factor

N = 500
SPEED = SpeedCoordinate(0.1, 0.61)


@pytest.fixture
def conditions():
    rng = np.random.default_rng(1)
    spin = rng.normal(0.0, 2.0, (N, 3))
    return np.column_stack([rng.uniform(0.01, 1.57, N), rng.uniform(1.0, 300.0, N), spin])


class _Inputs:
    """What `fill_features` reads of a law."""

    def __init__(self, inputs):
        self.inputs = inputs


def test_coordinates_are_bounded_whatever_the_spin(conditions):
    conditions[:, 2:] *= np.geomspace(1e-6, 1e6, N)[:, None]
    q = coordinates(conditions, SPEED)
    assert np.isfinite(q).all()
    assert (np.sum(q[:, 2:] ** 2, axis=1) < 1.5 + 1e-9).all()


def test_fold_is_the_reflection_in_the_impact_plane(conditions):
    q = coordinates(conditions, SPEED)
    once, signs = folded(q)
    assert (once[:, 2] >= 0.0).all()
    mirrored = conditions * [1.0, 1.0, -1.0, -1.0, 1.0]
    other, other_signs = folded(coordinates(mirrored, SPEED))
    np.testing.assert_array_equal(once, other)
    np.testing.assert_array_equal(signs * other_signs, np.tile(OUTCOME_SIGNS, (N, 1)))


def test_features_are_those_of_the_draw():
    rng = np.random.default_rng(2)
    centre, scale = rng.normal(size=N_INPUTS), rng.uniform(0.5, 3.0, N_INPUTS)
    inputs = np.concatenate([centre, scale]).astype(np.float32)
    x = rng.normal(size=(20, N_INPUTS))
    drawn = np.zeros((20, N_FEATURES), dtype=np.float32)
    for row, own in zip(x, drawn, strict=True):
        fill_features(_Inputs(inputs), 0, row, 0, row[5], row[6], own, 0)
    t = (x - inputs[:N_INPUTS]) * inputs[N_INPUTS:]
    np.testing.assert_allclose(features(t), drawn, rtol=1e-5, atol=1e-5)


@kernel
def _states(numbers, factor, states):
    for i in range(len(numbers)):
        fill_state(numbers[i], 0, factor[i], 1.0, states[i], 0)


def test_outcomes_are_undone_by_the_draw(conditions):
    rng = np.random.default_rng(3)
    spin = conditions[:, 2:]
    factor = energy_factor(spin)
    velocity = rng.normal(size=(N, 3))
    velocity *= (rng.uniform(0.0, 0.99, N) * factor / np.linalg.norm(velocity, axis=1))[:, None]
    states = np.hstack([velocity, rng.normal(size=(N, 3))])
    again = np.empty_like(states)
    _states(outcomes(states, spin), factor, again)
    np.testing.assert_allclose(again, states, rtol=1e-9, atol=1e-9)


def test_features_of_inputs_that_do_not_vary_are_left_out():
    varies = np.array([True, True, False, False, False, True, False])
    used = used_features(varies)
    t = np.where(varies, np.random.default_rng(4).normal(size=(N, N_INPUTS)), 0.0)
    spread = features(t).std(axis=0) > 0.0
    spread[0] = True
    np.testing.assert_array_equal(used, spread)
