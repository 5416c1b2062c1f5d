"""Variables and channels of simulated states, against closed forms and their own inverse."""

import numpy as np
import pytest
from scipy.stats import kstest

from sampler.formats.channels import CHANNELS, RANGES, STATE, VARIABLES, WORKS, channels_for
from tablegen.config.config import load_config
from tablegen.simulation.scene_variables import simulated_channels, simulated_variables
from tablegen.simulation.simulate import simulate

CONFIG = load_config("corundum-steel")
COUNT = 20_000


def simulated(shape, alpha_deg=35.0, count=COUNT):
    particles = CONFIG.population.restricted_to(shape)
    return simulate(CONFIG, np.radians(alpha_deg), 150.0, count, seed=2, population=particles)


@pytest.fixture(scope="module")
def mixture():
    return simulated("mixture")


def channels_of(simulation, names, seed=1):
    columns = simulated_channels(simulation, names, np.random.default_rng(seed)).T
    return dict(zip(names, columns, strict=True))


def assert_within_ranges(channels):
    """Channels lie strictly within their ranges in single precision."""
    for name, (low, high) in RANGES.items():
        stored = channels[name].astype(np.float32)
        assert low < stored.min() <= stored.max() < high, name


def test_variables_come_in_the_requested_order(mixture):
    variables = simulated_variables(mixture, ("collisions", "omega_y", "rotational_energy"))
    expected = mixture.collisions, mixture.state[:, 4], mixture.energy[:, 1]
    np.testing.assert_array_equal(variables, np.column_stack(expected))
    np.testing.assert_array_equal(simulated_variables(mixture, STATE), mixture.state)


def test_rotational_energy_of_a_sphere():
    """With the moment of inertia 2/5 m a^2, and the energy before the impact m V^2 / 2."""
    variables = simulated_variables(simulated("sphere", count=3), VARIABLES)
    spin = np.square(variables[:, 3:6]).sum(axis=1)
    assert spin.min() > 0.01
    np.testing.assert_allclose(variables[:, 6], 0.4 * spin, rtol=1e-12)
    np.testing.assert_array_equal(variables[:, 7], 1.0)


class TestChannels:
    def test_give_back_the_variables(self, mixture):
        c = channels_of(mixture, CHANNELS[:8])
        variables = dict(zip(VARIABLES, simulated_variables(mixture, VARIABLES).T, strict=True))
        for name in ("v", "omega_x", "omega_y", "omega_z"):
            np.testing.assert_array_equal(c[name], variables[name])
        u = c["u_hat"] * np.sqrt(1.0 - c["v"] ** 2)
        w = c["w_hat"] * np.sqrt(1.0 - c["v"] ** 2 - u**2)
        left = 1.0 - c["v"] ** 2 - u**2 - w**2
        np.testing.assert_allclose(u, variables["u"], rtol=0.0, atol=1e-14)
        np.testing.assert_allclose(w, variables["w"], rtol=0.0, atol=1e-14)
        energy = c["energy_hat"] * left
        np.testing.assert_allclose(energy, variables["rotational_energy"], rtol=0.0, atol=2e-6)
        np.testing.assert_array_equal(np.floor(c["collisions"]), variables["collisions"])
        assert_within_ranges(channels_of(mixture, CHANNELS))

    def test_with_works_give_back_the_variables(self, mixture):
        c = channels_of(mixture, channels_for((*STATE, *WORKS)))
        names = ("u", "w", "rotational_energy", *WORKS)
        variables = dict(zip(names, simulated_variables(mixture, names).T, strict=True))
        rest = 1.0 - c["v"] ** 2
        normal = c["normal_hat"] ** 6 * rest
        u = c["u_hat"] * np.sqrt(rest - normal)
        w = c["w_hat"] * np.sqrt(rest - normal - u**2)
        left = rest - normal - u**2 - w**2
        energy = c["energy_hat"] * left
        returned = dict(zip(names, (u, w, energy, normal, left - energy), strict=True))
        for name in names:
            np.testing.assert_allclose(
                returned[name], variables[name], rtol=0.0, atol=2e-6, err_msg=name
            )

    @pytest.mark.parametrize("alpha_deg", [1e-3, 45.0, 90.0])
    def test_of_spheres_that_lose_nothing_stay_in_range(self, alpha_deg):
        law = {"law": "constant", "value": 1.0, "source": "a test"}
        pair = {"restitution": law, "resistance": {**law, "value": 0.0}}
        elastic = CONFIG.with_changes({"pair": pair, "domain": {"extrapolate": True}})
        spheres, alpha1 = elastic.population.restricted_to("sphere"), np.radians(alpha_deg)
        simulation = simulate(elastic, alpha1, 150.0, 100, seed=2, population=spheres)
        assert np.square(simulation.state[:, :3]).sum(axis=1).max() > 1.0 - 1e-9
        c = channels_of(simulation, CHANNELS)
        assert_within_ranges(c)
        np.testing.assert_allclose(c["v"], np.sin(alpha1), rtol=1e-6)
        u = c["u_hat"] * np.sqrt(1.0 - c["v"] ** 2)
        np.testing.assert_allclose(u, np.cos(alpha1), rtol=1e-6, atol=1e-6)

    def test_spread_collisions_over_their_unit_and_nothing_else(self, mixture):
        """Uniform between its ends, whatever the number; false alarm 1e-6."""
        one, other = (channels_of(mixture, CHANNELS[:8], seed=seed) for seed in (1, 2))
        for name in CHANNELS[:8]:
            assert np.array_equal(one[name], other[name]) == (name != "collisions"), name
        c = one["collisions"]
        spread = (c - np.floor(c) - 0.01) / 0.98
        bound = np.sqrt(np.log(2.0 / 1e-6) / (2.0 * COUNT))
        assert kstest(spread, "uniform").statistic < bound
        assert abs(np.corrcoef(spread, mixture.collisions == 1)[0, 1]) < 4.9 / np.sqrt(COUNT)
        # single precision does not round to the next number
        np.testing.assert_array_equal(np.floor(c.astype(np.float32)), np.floor(c))
        # a spread over nine tenths of the unit is refused
        assert kstest(0.9 * spread, "uniform").statistic > bound
