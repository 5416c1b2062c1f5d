"""The channels: their inverse, and those that variables need."""

import numpy as np
import pytest

from sampler import InputError
from sampler.formats.channels import CHANNELS, STATE, WORKS, channels_for, to_channels


def test_round_trip():
    """States by the formulae of the specification; test_draw has those of all variables."""
    rng = np.random.default_rng(3)
    low, high = [0.0, -1.0, -3.0, -1.0, -3.0, -3.0], [1.0, 1.0, 3.0, 1.0, 3.0, 3.0]
    channels = rng.uniform(low, high, (2000, 6))
    v, u_hat, omega_z, w_hat, omega_x, omega_y = channels.T
    u = u_hat * np.sqrt(1.0 - v**2)
    w = w_hat * np.sqrt((1.0 - v**2) * (1.0 - u_hat**2))
    states = np.column_stack((u, v, w, omega_x, omega_y, omega_z))
    np.testing.assert_allclose(to_channels(states), channels, rtol=1e-9, atol=1e-9)


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
        *([0.1, v, 0.1, 0, 0, 0] for v in (0.0, -0.2)),
        [0.6, 0.8, 0.1, 0, 0, 0],
        [np.nan, 0.5, 0, 0, 0, 0],
    ],
)
def test_states_without_channels_are_refused(state):
    good = [0.1, 0.5, 0.1, 0.0, 0.0, 0.0]
    with pytest.raises(InputError, match="at index 1, allowed: v > 0"):
        to_channels(np.array([good, state]))
    with pytest.raises(InputError, match=r"got shape \(6,\), allowed: \(n, 6\)"):
        to_channels(np.ones(6))
