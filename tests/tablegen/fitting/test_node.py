"""One node: its arrays, and draws from it against direct simulation of the very same condition."""

import numpy as np
import pytest
from corrupt_tables import independent_channels, independent_columns

from sampler.formats.channels import STATE, VARIABLES, WORKS
from sampler.table import Table
from tablegen.accuracy.metrics import classifier_auc, correlation_error, ks_distances
from tablegen.accuracy.scene_variables import simulated_variables
from tablegen.config.config import load_config
from tablegen.fitting.node import fit_node, fitted_channels
from tablegen.simulation.simulate import make_condition, simulate_condition
from tablegen.tables.assembly import assemble
from tablegen.tables.axes import make_axes

ALPHA_DEG, SPEED = 35.0, 150.0
N, N_NODE = 20_000, 12_000
SMALL = {"samples_per_node": 1000, "components": 4, "quantile_knots": 33, "mirror": True}


def node_config(**table):
    """The shipped pair at one condition."""
    domain = {"alpha_deg": [ALPHA_DEG, ALPHA_DEG], "speed": [SPEED, SPEED]}
    return load_config("corundum-steel").with_changes({"domain": domain, "table": table})


def one_node_table(config):
    return Table(assemble(config, make_axes(config), [fit_node(config, ALPHA_DEG, SPEED)]))


def simulated(config, count, stream):
    condition = make_condition(np.radians(ALPHA_DEG), SPEED)
    population = config.population
    return simulate_condition(
        config.pair, population, condition, count, seed=4, stream=stream, threads=1
    )


@pytest.fixture(scope="module")
def config():
    return node_config(samples_per_node=N_NODE, components=32, quantile_knots=129, mirror=True)


@pytest.fixture(scope="module")
def table(config):
    return one_node_table(config)


@pytest.fixture(scope="module")
def direct(config):
    return simulated(config, N, 77).state


class TestArrays:
    def test_shapes_and_types(self):
        node = fit_node(node_config(**SMALL), ALPHA_DEG, SPEED)
        found = {name: (array.shape, array.dtype.str) for name, array in node._asdict().items()}
        assert found == {
            "quantiles": ((2, 6, 33), "<f4"),
            "first_of_class": ((2,), "<u2"),
            "alias_probability": ((4,), "<u2"),
            "alias_index": ((4,), "<u2"),
            "reflection": ((4,), "<i2"),
            "mean": ((4, 6), "<i2"),
            "cholesky": ((4, 21), "<i2"),
        }
        assert all(np.isfinite(array).all() for array in node)

    def test_are_a_function_of_the_configuration_and_the_condition(self):
        config = node_config(**SMALL)
        first = fit_node(config, ALPHA_DEG, SPEED)
        for a, b in zip(first, fit_node(config, ALPHA_DEG, SPEED), strict=True):
            np.testing.assert_array_equal(a, b)
        others = {
            "seed": fit_node(node_config(**SMALL, seed=2), ALPHA_DEG, SPEED),
            "angle": fit_node(config, ALPHA_DEG + 1.0, SPEED),
            "speed": fit_node(config, ALPHA_DEG, SPEED + 1.0),
        }
        for what, other in others.items():
            assert not np.array_equal(first.quantiles, other.quantiles), what
            assert not np.array_equal(first.mean, other.mean), what

    def test_mirrored_channels_are_odd(self):
        node = fit_node(node_config(**SMALL), ALPHA_DEG, SPEED)
        rows = node.quantiles[:, 3:]
        np.testing.assert_array_equal(rows, -rows[..., ::-1])
        np.testing.assert_array_equal(node.reflection, 2048)
        plain = fit_node(node_config(**SMALL | {"mirror": False}), ALPHA_DEG, SPEED)
        rows = plain.quantiles[:, 3:]
        assert (rows != -rows[..., ::-1]).any()
        assert (plain.reflection != 2048).any()

    def test_spare_components_are_never_drawn(self):
        """A hundred particles cannot feed 64 components: the rest of the places stay empty."""
        config = node_config(samples_per_node=100, components=64, quantile_knots=33)
        node = fit_node(config, ALPHA_DEG, SPEED)
        spare = (node.mean == 0).all(axis=1)
        assert 50 <= spare.sum() < 64
        assert (node.alias_probability[spare] == 0).all()
        assert not spare[node.alias_index].any()
        Table(assemble(config, make_axes(config), [node]))

    def test_channels_of_a_scene(self):
        found = fitted_channels(node_config(**SMALL))
        np.testing.assert_array_equal(found.signs, [1, 1, 1, -1, -1, -1])
        np.testing.assert_array_equal(found.mirror, found.signs)
        np.testing.assert_array_equal(fitted_channels(node_config()).mirror, np.ones(6))
        plane = fitted_channels(node_config(**SMALL).with_changes({"domain": {"dimension": 2}}))
        assert plane.names == ("v", "u_hat", "omega_z")
        assert not plane.symmetric


class TestSpheres:
    def test_every_draw_is_the_one_rebound_that_there_is(self):
        """A sphere has no randomness: the law is one point, and the fit must bear that."""
        shapes = dict.fromkeys(("ellipsoid", "prism", "truncated-prism", "tetrahedron"), 0.0)
        config = node_config(**SMALL).with_changes(
            {"population": {"shapes": shapes | {"sphere": 1.0}}}
        )
        expected = simulated(config, 1, 0).state[0]
        assert expected[1] > 0.1
        states = one_node_table(config).sample(
            np.radians(ALPHA_DEG), SPEED, seed=1, index=range(500)
        )
        # float32 in the table
        np.testing.assert_allclose(states, np.tile(expected, (500, 1)), rtol=0.0, atol=1e-6)


#: Scenes, and the columns that their tables have.
SCENES = {
    "plane": ({"dimension": 2}, ("u", "v", "omega_z")),
    "two": ({"components": ["v", "u"]}, ("u", "v")),
    "no spin": ({"components": ["u", "v", "w"]}, ("u", "v", "w")),
    "spin only": ({"components": ["omega_x", "omega_z"]}, ("omega_x", "omega_z")),
    "everything": ({"components": list(VARIABLES[:8])}, VARIABLES[:8]),
    "works": ({"components": [*STATE, *WORKS]}, (*STATE, *WORKS)),
}


class TestScenes:
    """Draws of the variables of a scene, against the simulation; the bound of `TestDraws`."""

    @pytest.mark.parametrize("scene", SCENES)
    def test_draws_match_the_simulation(self, scene):
        domain, columns = SCENES[scene]
        table = {"samples_per_node": N_NODE, "components": 32, "quantile_knots": 129}
        config = node_config(**table).with_changes({"domain": domain})
        made = one_node_table(config)
        assert made.columns == columns
        drawn = made.sample(np.radians(ALPHA_DEG), SPEED, seed=6, index=np.arange(N))
        direct = simulated_variables(simulated(config, N, 77), columns)
        assert ks_distances(drawn, direct).max() < TestDraws.KS_BOUND
        assert correlation_error(drawn, direct) < TestDraws.CORRELATION_BOUND
        # Refused: the same columns out of step with each other, and one of them moved.
        if scene != "spin only":  # whose two components are uncorrelated
            shuffled = independent_columns(drawn, seed=1)
            assert correlation_error(shuffled, direct) > TestDraws.CORRELATION_BOUND
        moved = drawn + 0.3 * drawn.std(axis=0) * (np.arange(len(columns)) == 0)
        assert ks_distances(moved, direct).max() > TestDraws.KS_BOUND

    def test_energies_and_collisions_are_possible_ones(self):
        domain = {"components": list(VARIABLES[:8])}
        config = node_config(**SMALL).with_changes({"domain": domain})
        states = one_node_table(config).sample(np.radians(ALPHA_DEG), SPEED, seed=1, index=range(N))
        energy, collisions = states[:, 6], states[:, 7]
        assert (energy > 0.0).all()
        assert (np.square(states[:, :3]).sum(axis=1) + energy < 1.0).all()
        np.testing.assert_array_equal(collisions, np.round(collisions))
        assert collisions.min() == 1.0
        assert collisions.max() > 3.0

    def test_works_are_what_the_energies_lack(self):
        domain = {"components": ["u", "v", "w", "rotational_energy", *WORKS]}
        config = node_config(**SMALL).with_changes({"domain": domain})
        states = one_node_table(config).sample(np.radians(ALPHA_DEG), SPEED, seed=1, index=range(N))
        kept = np.square(states[:, :3]).sum(axis=1) + states[:, 3]
        np.testing.assert_allclose(kept + states[:, 4:].sum(axis=1), 1.0, rtol=0.0, atol=1e-14)
        assert states[:, 4:].min() > 0.0


class TestDraws:
    """Draws from a node against the simulation that it stands for, with other random numbers.

    The law of the node comes from N_NODE simulated states, and N draws are compared with N fresh
    states. The gap between two empirical distribution functions is a Brownian bridge of variance
    1/N + 1/N + 1/N_NODE: it exceeds x with probability 2 exp(-2 x^2 / variance). `KS_BOUND` is
    where six components do so with probability 1e-6, and 0.004 for the interpolation between
    knots. A correlation has a standard error of about 0.02, the AUC one of 0.004 and a
    bias of 0.08 because the node holds 32 components: six standard errors are left to both.
    """

    KS_BOUND = np.sqrt(np.log(12.0 / 1e-6) * (2.0 / N + 1.0 / N_NODE) / 2.0) + 0.004
    CORRELATION_BOUND = 0.12
    AUC_BOUND = 0.63

    def draws(self, table):
        return table.sample(np.radians(ALPHA_DEG), SPEED, seed=6, index=np.arange(N))

    def test_match_the_simulation(self, table, direct):
        drawn = self.draws(table)
        assert ks_distances(drawn, direct).max() < self.KS_BOUND
        assert correlation_error(drawn, direct) < self.CORRELATION_BOUND
        assert classifier_auc(drawn, direct) < self.AUC_BOUND

    def test_independent_columns_are_refused(self, table, direct):
        shuffled = independent_columns(self.draws(table), seed=1)
        assert ks_distances(shuffled, direct).max() < self.KS_BOUND
        assert correlation_error(shuffled, direct) > self.CORRELATION_BOUND
        assert classifier_auc(shuffled, direct) > self.AUC_BOUND

    def test_node_without_dependence_is_refused(self, table, direct):
        drawn = self.draws(Table(independent_channels(table.contents)))
        assert correlation_error(drawn, direct) > self.CORRELATION_BOUND
        assert classifier_auc(drawn, direct) > self.AUC_BOUND

    def test_simulation_of_another_condition_is_refused(self, table, config):
        condition = make_condition(np.radians(ALPHA_DEG + 5.0), SPEED)
        other = simulate_condition(config.pair, config.population, condition, N, seed=4, threads=1)
        assert ks_distances(self.draws(table), other.state).max() > self.KS_BOUND
