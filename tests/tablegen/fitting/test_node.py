"""One node: its arrays, and draws from it against direct simulation of the very same condition."""

import numpy as np
import pytest
from wrong_tables import independent_channels, independent_columns

from sampler.table import Table
from tablegen.accuracy import classifier_auc, correlation_error, ks_distances
from tablegen.assembly import assemble
from tablegen.config import load_config
from tablegen.fitting.axes import make_axes
from tablegen.fitting.marginals import SCORE_MAX
from tablegen.fitting.node import MAP_KNOTS, VARIATE_MAX, fit_node, mirror_signs, variate_knots
from tablegen.simulate import make_condition, simulate

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
    return simulate(config.pair, population, condition, count, seed=4, stream=stream, threads=1)


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
            "scores": ((2, 6, MAP_KNOTS), "<f4"),
            "first_of_class": ((2,), "<u2"),
            "alias_probability": ((4,), "<f4"),
            "alias_index": ((4,), "<u2"),
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
        for rows in (node.quantiles[:, 3:], node.scores[:, 3:]):
            np.testing.assert_array_equal(rows, -rows[..., ::-1])
        plain = fit_node(node_config(**SMALL | {"mirror": False}), ALPHA_DEG, SPEED)
        for rows in (plain.quantiles[:, 3:], plain.scores[:, 3:]):
            assert (rows != -rows[..., ::-1]).any()

    def test_spare_components_are_never_drawn(self):
        """A hundred particles cannot feed 64 components: the rest of the places stay empty."""
        config = node_config(samples_per_node=100, components=64, quantile_knots=33)
        node = fit_node(config, ALPHA_DEG, SPEED)
        spare = (node.mean == 0).all(axis=1)
        assert 50 <= spare.sum() < 64
        assert (node.alias_probability[spare] == 0.0).all()
        assert not spare[node.alias_index].any()
        Table(assemble(config, make_axes(config), [node]))

    def test_knots_and_signs(self):
        knots = variate_knots()
        assert knots.shape == (MAP_KNOTS,)
        np.testing.assert_array_equal(knots, -knots[::-1])
        assert knots[-1] == VARIATE_MAX > SCORE_MAX
        np.testing.assert_array_equal(mirror_signs(True), [1, 1, 1, -1, -1, -1])
        np.testing.assert_array_equal(mirror_signs(False), np.ones(6))


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
        other = simulate(config.pair, config.population, condition, N, seed=4, threads=1)
        assert ks_distances(self.draws(table), other.state).max() > self.KS_BOUND
