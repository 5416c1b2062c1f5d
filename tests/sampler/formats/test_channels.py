"""The channels: their inverse, and the energy that they cannot exceed."""

import numpy as np
import pytest

from sampler import InputError
from sampler.formats.channels import CHANNELS, STATE, WORKS, channels_for, to_channels


def _states(channels):
    """States (n, 10) of channels (n, 6), (n, 8) or (n, 9), by the formulae of the specification."""
    whole = np.zeros((len(channels), 9))
    whole[:, : np.shape(channels)[1]] = channels
    v, u_hat, omega_z, w_hat, omega_x, omega_y, energy_hat, collisions, normal_hat = whole.T
    normal = normal_hat**6 * (1.0 - v**2)
    u = u_hat * np.sqrt((1.0 - v**2) * (1.0 - normal_hat**6))
    left = (1.0 - v**2) * (1.0 - normal_hat**6) * (1.0 - u_hat**2)
    w, left = w_hat * np.sqrt(left), left * (1.0 - w_hat**2)
    energy, shear = energy_hat * left, (1.0 - energy_hat) * left * (normal_hat > 0.0)
    parts = (u, v, w, omega_x, omega_y, omega_z, energy, np.floor(collisions), normal, shear)
    return np.column_stack(parts)


def _random_channels(n):
    rng = np.random.default_rng(3)
    low, high = [0.0, -1.0, -3.0, -1.0, -3.0, -3.0], [1.0, 1.0, 3.0, 1.0, 3.0, 3.0]
    return rng.uniform(low, high, (n, 6))


def test_round_trip():
    channels = _random_channels(2000)
    np.testing.assert_allclose(
        to_channels(_states(channels)[:, :6]), channels, rtol=1e-9, atol=1e-9
    )


def test_order_of_components():
    channels = np.array([[0.6, 0.0, 30.0, 0.0, 10.0, 20.0]])
    state = dict(zip(STATE, _states(channels)[0], strict=False))
    assert state == {"u": 0, "v": 0.6, "w": 0, "omega_x": 10, "omega_y": 20, "omega_z": 30}
    assert CHANNELS[0] == "v"
    assert CHANNELS[2] == "omega_z"


def test_energy_identity():
    channels = _random_channels(2000)
    u, v, w = _states(channels)[:, :3].T
    v_c, u_hat, w_hat = channels[:, [0, 1, 3]].T
    left = 1.0 - (u**2 + v**2 + w**2)
    np.testing.assert_allclose(left, (1 - v_c**2) * (1 - u_hat**2) * (1 - w_hat**2), atol=1e-14)


def test_further_channels():
    """The rotational energy is a share of what translation left; collisions are whole."""
    channels = np.column_stack([_random_channels(500), np.linspace(0.001, 0.999, 500)])
    channels = np.column_stack([channels, np.linspace(1.001, 40.999, 500)])
    states = _states(channels)
    moving = (states[:, :3] ** 2).sum(axis=1)
    np.testing.assert_allclose(states[:, 6], channels[:, 6] * (1.0 - moving), atol=1e-14)
    assert (moving + states[:, 6] < 1.0).all()
    np.testing.assert_array_equal(states[:, 7], np.floor(channels[:, 7]))


def test_works_and_energies_are_all_there_is():
    rng = np.random.default_rng(4)
    shares = rng.uniform([0.0, 1.0, 0.0], [1.0, 9.0, 1.0], (2000, 3))
    channels = np.column_stack([_random_channels(2000), shares])
    states = _states(channels)
    total = (states[:, :3] ** 2).sum(axis=1) + states[:, 6] + states[:, 8:].sum(axis=1)
    np.testing.assert_allclose(total, 1.0, rtol=0.0, atol=1e-14)
    first = shares[:, 2] ** 6 * (1.0 - channels[:, 0] ** 2)
    np.testing.assert_allclose(states[:, 8], first, rtol=1e-14, atol=1e-16)
    assert states[:, 8:].min() >= 0.0
    np.testing.assert_array_equal(_states(channels[:, :8])[:, 8:], 0.0)


def test_channels_that_components_need():
    assert channels_for(STATE) == CHANNELS[:6]
    assert channels_for(("u", "v", "omega_z")) == ("v", "u_hat", "omega_z")
    assert channels_for(("w",)) == ("v", "u_hat", "w_hat")
    assert channels_for(("collisions",)) == ("collisions",)
    energy = ("v", "u_hat", "w_hat", "energy_hat")
    assert channels_for(("rotational_energy", "v")) == energy
    assert channels_for(WORKS[:1]) == ("v", "normal_hat")
    assert channels_for(WORKS) == (*energy, "normal_hat")
    assert len(channels_for((*STATE, *WORKS))) == len((*STATE, *WORKS)) == 8


@pytest.mark.parametrize(
    "state",
    [
        [0.1, 0.0, 0.1, 0, 0, 0],
        [0.1, -0.2, 0.1, 0, 0, 0],
        [0.6, 0.8, 0.1, 0, 0, 0],
        [np.nan, 0.5, 0, 0, 0, 0],
    ],
)
def test_states_without_channels_are_refused(state):
    good = [0.1, 0.5, 0.1, 0.0, 0.0, 0.0]
    with pytest.raises(InputError, match="at index 1, allowed: v > 0"):
        to_channels(np.array([good, state]))


def test_wrong_shape_is_refused():
    with pytest.raises(InputError, match=r"got shape \(6,\), allowed: \(n, 6\)"):
        to_channels(np.ones(6))
