"""One node: its arrays, and draws from it against direct simulation of the same condition."""

from dataclasses import replace

import numpy as np
import pytest
from corrupt_tables import independent_channels, independent_columns

from sampler.formats.channels import STATE, VARIABLES, WORKS
from sampler.table import Table
from tablegen.accuracy.metrics import Settings, auc, correlation_error, ks_distances
from tablegen.config.config import load_config
from tablegen.fitting.node import fit_node, node_stream, to_steps
from tablegen.simulation.scene_variables import simulated_variables
from tablegen.simulation.simulate import simulate
from tablegen.tables.assembly import assemble
from tablegen.tables.axes import make_axes

ALPHA_DEG, SPEED = 35.0, 150.0
N, N_NODE = 20_000, 12_000
USUAL = {"samples_per_node": N_NODE, "components": 32, "quantile_knots": 129}

#: N draws from the law of N_NODE states are compared with N fresh states. The difference of two
#: empirical distribution functions is a Brownian bridge of variance 1/N + 1/N + 1/N_NODE: six
#: components exceed x with probability 12 exp(-2 x^2 / variance) = 1e-6, and 0.004 are for the
#: interpolation between knots. The bounds of the correlation and the AUC leave six standard errors.
KS_BOUND = np.sqrt(np.log(12.0 / 1e-6) * (2.0 / N + 1.0 / N_NODE) / 2.0) + 0.004
CORRELATION_BOUND, AUC_BOUND = 0.12, 0.63


def node_config(columns=STATE, **table):
    """The shipped pair at one condition."""
    domain = {"alpha_deg": [ALPHA_DEG] * 2, "speed": [SPEED] * 2, "variables": list(columns)}
    return load_config("corundum-steel").with_changes(
        {"spin": False, "domain": domain, "table": table}
    )


def one_node_contents(config):
    return assemble(config, make_axes(config), [fit_node(config, ALPHA_DEG, SPEED)])


def draw(table, count=N):
    return table.sample(np.radians(ALPHA_DEG), SPEED, seed=6, index=np.arange(count))


def simulate_node(config, count=N, alpha_deg=ALPHA_DEG, seed=4, stream=77):
    keys = {"seed": seed, "stream": stream, "threads": 1}
    return simulate(config, np.radians(alpha_deg), SPEED, count, **keys)


def test_spare_components_are_never_drawn():
    """A hundred particles are too few for 64 components: some places stay empty."""
    config = node_config(samples_per_node=100, components=64, quantile_knots=33)
    node = fit_node(config, ALPHA_DEG, SPEED)
    spare = (node.mean == 0).all(axis=1)
    assert 50 <= spare.sum() < 64
    assert not node.alias_probability[spare].any()
    assert not spare[node.alias_index].any()


def test_numbers_beyond_the_steps_of_a_file_are_an_error():
    assert to_steps([-8.0, 0.5]).tolist() == [-32768, 2048]
    with pytest.raises(OverflowError):
        to_steps(8.0)


def test_draws_match_the_simulation():
    config = node_config(**USUAL)
    contents, direct = one_node_contents(config), simulate_node(config).state
    drawn = draw(Table(contents))
    assert ks_distances(drawn, direct).max() < KS_BOUND
    assert correlation_error(drawn, direct).value < CORRELATION_BOUND
    assert auc(drawn, direct, Settings()).value < AUC_BOUND
    # refused: columns without dependence, components without dependence, another condition
    shuffled = independent_columns(drawn, seed=1)
    assert correlation_error(shuffled, direct).value > CORRELATION_BOUND
    assert auc(shuffled, direct, Settings()).value > AUC_BOUND
    independent = draw(Table(independent_channels(contents)))
    assert correlation_error(independent, direct).value > CORRELATION_BOUND
    other = simulate_node(config, alpha_deg=ALPHA_DEG + 5.0).state
    assert ks_distances(drawn, other).max() > KS_BOUND


@pytest.mark.parametrize("columns", [("u", "v"), VARIABLES[:8], (*STATE, *WORKS)], ids=len)
def test_draws_of_a_scene_match_the_simulation(columns):
    config = node_config(columns, **USUAL)
    table = Table(one_node_contents(config))
    assert table.columns == columns
    drawn, direct = draw(table), simulated_variables(simulate_node(config), columns)
    assert ks_distances(drawn, direct).max() < KS_BOUND
    assert correlation_error(drawn, direct).value < CORRELATION_BOUND
    moved = drawn + 0.3 * drawn.std(axis=0) * (np.arange(len(columns)) == 0)
    assert ks_distances(moved, direct).max() > KS_BOUND
    if "collisions" in columns:
        assert (np.square(drawn[:, :3]).sum(axis=1) + drawn[:, 6] < 1.0).all()
        np.testing.assert_array_equal(drawn[:, 7], np.round(drawn[:, 7]))
    if WORKS[0] in columns:
        assert drawn[:, -len(WORKS) :].min() > 0.0


def test_draws_have_the_marginals_of_the_sample():
    """The sample is known, so the noise is that of the draws.

    They exceed the root with p = 1e-6 in five columns; 0.003 are for knots and 16-bit numbers.
    """
    columns, count = ("v", "omega_x", "omega_y", "omega_z", "collisions"), 400_000
    bound = np.sqrt(np.log(10.0 / 1e-6) / (2.0 * count)) + 0.003
    table = {"samples_per_node": 20_000, "components": 24, "quantile_knots": 129}
    config = node_config(columns, **table)
    stream = node_stream(ALPHA_DEG, SPEED)
    node_sample = simulate_node(config, 20_000, seed=config.table.seed, stream=stream)
    sample = simulated_variables(node_sample, columns)
    contents = one_node_contents(config)
    assert ks_distances(draw(Table(contents), count), sample).max() < bound
    # refused: another mixture, and the mixture without its reflections
    for name, change in (("mean", 400), ("reflection", -4096)):
        path = f"dependence/{name}"
        values = np.clip(contents[path].astype(int) + change, 0 if change < 0 else -32768, 32767)
        changed = {**contents.datasets, path: values.astype(np.int16)}
        wrong = Table(replace(contents, datasets=changed))
        assert ks_distances(draw(wrong, count), sample).max() > bound
