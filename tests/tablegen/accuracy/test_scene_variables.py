"""Components and channels of simulated states, against closed forms and their own inverse."""

import numpy as np
import pytest
from scipy.stats import kstest

from sampler.formats.channels import CHANNELS, RANGES, STATE, VARIABLES, WORKS, channels_for
from tablegen.accuracy.scene_variables import simulated_channels, simulated_variables
from tablegen.config.config import load_config
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


class TestComponents:
    def test_columns_come_in_the_order_that_is_asked_for(self, mixture):
        names = ("collisions", "omega_y", "u", "rotational_energy")
        found = simulated_variables(mixture, names)
        assert found.shape == (COUNT, 4)
        assert found.dtype == np.float64
        np.testing.assert_array_equal(found[:, 0], mixture.collisions)
        np.testing.assert_array_equal(found[:, 1], mixture.state[:, 4])
        np.testing.assert_array_equal(found[:, 2], mixture.state[:, 0])
        np.testing.assert_array_equal(found[:, 3], mixture.energy[:, 1])
        np.testing.assert_array_equal(simulated_variables(mixture, STATE), mixture.state)

    def test_rotational_energy_of_a_sphere(self):
        """With the moment of inertia 2/5 m a^2, and the energy before the impact m V^2 / 2."""
        found = simulated_variables(simulated("sphere", count=3), VARIABLES)
        spin = np.square(found[:, 3:6]).sum(axis=1)
        assert spin.min() > 0.01
        np.testing.assert_allclose(found[:, 6], 0.4 * spin, rtol=1e-12)
        np.testing.assert_array_equal(found[:, 7], 1.0)


class TestChannels:
    def test_give_back_the_components(self, mixture):
        c = channels_of(mixture, CHANNELS[:8])
        found = dict(zip(VARIABLES, simulated_variables(mixture, VARIABLES).T, strict=True))
        for name in ("v", "omega_x", "omega_y", "omega_z"):
            np.testing.assert_array_equal(c[name], found[name])
        u = c["u_hat"] * np.sqrt(1.0 - c["v"] ** 2)
        w = c["w_hat"] * np.sqrt(1.0 - c["v"] ** 2 - u**2)
        left = 1.0 - c["v"] ** 2 - u**2 - w**2
        np.testing.assert_allclose(u, found["u"], rtol=0.0, atol=1e-14)
        np.testing.assert_allclose(w, found["w"], rtol=0.0, atol=1e-14)
        energy = c["energy_hat"] * left
        np.testing.assert_allclose(energy, found["rotational_energy"], rtol=0.0, atol=2e-6)
        np.testing.assert_array_equal(np.floor(c["collisions"]), found["collisions"])

    def test_with_works_give_back_the_components(self, mixture):
        c = channels_of(mixture, channels_for((*STATE, *WORKS)))
        names = ("u", "w", "rotational_energy", *WORKS)
        found = dict(zip(names, simulated_variables(mixture, names).T, strict=True))
        rest = 1.0 - c["v"] ** 2
        normal = c["normal_hat"] ** 6 * rest
        u = c["u_hat"] * np.sqrt(rest - normal)
        w = c["w_hat"] * np.sqrt(rest - normal - u**2)
        left = rest - normal - u**2 - w**2
        energy = c["energy_hat"] * left
        made = dict(zip(names, (u, w, energy, normal, left - energy), strict=True))
        for name in names:
            np.testing.assert_allclose(made[name], found[name], rtol=0.0, atol=2e-6, err_msg=name)

    def test_the_normal_share_grows_with_the_root_of_a_grazing_angle(self):
        """Nearly: between nodes a table is linear in that root."""
        median = [
            np.median(channels_of(simulated("ellipsoid", alpha_deg, 5000), CHANNELS)["normal_hat"])
            for alpha_deg in (1.0, 4.0)
        ]
        assert median[1] / median[0] == pytest.approx(2.0, rel=0.1)

    def test_lie_within_their_ranges_in_single_precision(self, mixture):
        c = channels_of(mixture, CHANNELS)
        for name, (low, high) in RANGES.items():
            stored = c[name].astype(np.float32)
            assert low < stored.min() <= stored.max() < high, name

    @pytest.mark.parametrize("alpha_deg", [1e-3, 45.0, 90.0])
    def test_of_spheres_that_lose_nothing_are_those_of_almost_nothing(self, alpha_deg):
        law = {"law": "constant", "value": 1.0, "source": "a test"}
        resistance = {**law, "value": 0.0}
        elastic = CONFIG.with_changes(
            {
                "pair": {"restitution": law, "resistance": resistance},
                "domain": {"extrapolate": True},
            }
        )
        spheres = elastic.population.restricted_to("sphere")
        alpha1 = np.radians(alpha_deg)
        found = simulate(elastic, alpha1, 150.0, 100, seed=2, population=spheres)
        assert np.square(found.state[:, :3]).sum(axis=1).max() > 1.0 - 1e-9
        c = channels_of(found, CHANNELS)
        for name, (low, high) in RANGES.items():
            stored = c[name].astype(np.float32)
            assert low < stored.min() <= stored.max() < high, name
        np.testing.assert_allclose(c["v"], np.sin(alpha1), rtol=1e-6)
        u = c["u_hat"] * np.sqrt(1.0 - c["v"] ** 2)
        np.testing.assert_allclose(u, np.cos(alpha1), rtol=1e-6, atol=1e-6)

    def test_a_sphere_that_does_not_turn_keeps_a_share_above_zero(self):
        straight = simulated("sphere", alpha_deg=90.0, count=3)
        assert straight.energy[:, 1].max() < 1e-12
        share = channels_of(straight, ("energy_hat",))["energy_hat"]
        assert (share > 0.0).all()
        assert share.max() <= 1e-6
        # nor does anything act along the wall
        assert channels_of(straight, ("normal_hat",))["normal_hat"].min() == 1.0 - 2.0**-24

    def test_collisions_are_spread_over_their_unit(self, mixture):
        """Uniform between its ends, whatever the number; false alarm 1e-6."""
        c = channels_of(mixture, ("collisions",))["collisions"]
        spread = (c - np.floor(c) - 0.01) / 0.98
        bound = np.sqrt(np.log(2.0 / 1e-6) / (2.0 * COUNT))
        assert kstest(spread, "uniform").statistic < bound
        single = mixture.collisions == 1
        assert abs(np.corrcoef(spread, single)[0, 1]) < 4.9 / np.sqrt(COUNT)
        # single precision does not round to the next number
        np.testing.assert_array_equal(np.floor(c.astype(np.float32)), np.floor(c))
        # Refused: a spread over nine tenths of the unit.
        assert kstest(0.9 * spread, "uniform").statistic > bound

    def test_random_numbers_spread_collisions_and_nothing_else(self, mixture):
        one, other = (channels_of(mixture, CHANNELS[:8], seed=seed) for seed in (1, 2))
        for name in CHANNELS[:8]:
            assert np.array_equal(one[name], other[name]) == (name != "collisions"), name
        few = channels_of(mixture, ("v", "w_hat"))
        np.testing.assert_array_equal(few["w_hat"], one["w_hat"])
