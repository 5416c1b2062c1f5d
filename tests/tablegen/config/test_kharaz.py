"""Spheres under Coulomb friction beside those that Kharaz, Gorham & Salman measured."""

import numpy as np
import pytest

from tablegen.config.config import load_config
from tablegen.measured.reader import read_measurements
from tablegen.simulation.simulate import simulate

#: Quantities: from angle and state, and the largest deviation.
QUANTITIES = {
    "e_t": (lambda alpha_deg, state: state[:, 0] / np.cos(np.radians(alpha_deg)), 0.03),
    "omega_z": (lambda _, state: state[:, 5], 0.03),
    "rebound_angle_deg": (lambda _, state: np.degrees(np.arctan2(state[:, 1], state[:, 0])), 1.0),
}


@pytest.mark.parametrize("name", QUANTITIES)
def test_measured_means_are_met(name):
    of_state, allowed = QUANTITIES[name]
    measured = read_measurements("kharaz-2001")
    mean = measured.moments[name].mean
    rows = np.isfinite(mean)
    alpha_deg, config = measured.alpha_deg[rows], load_config("kharaz-2001")
    states = [simulate(config, np.radians(a), 3.9, 1, seed=1).state[0] for a in alpha_deg]
    miss = np.abs(of_state(alpha_deg, np.array(states)) - mean[rows])
    assert len(miss) >= 7
    assert miss.max() < allowed
