"""Quantiles at the mixture's own variates: draws from a node have the marginals of its sample.

The sample is simulated again, so it is known point by point, and draws are compared with it and
not with its law: the noise is that of the draws alone.
"""

from dataclasses import replace

import numpy as np
import pytest

from sampler.formats.channels import MIRRORED
from sampler.table import Table
from tablegen.accuracy.metrics import ks_distances
from tablegen.accuracy.scene_variables import simulated_variables
from tablegen.config.config import load_config
from tablegen.fitting.node import fit_node, node_stream
from tablegen.simulation.simulate import simulate
from tablegen.tables.assembly import assemble
from tablegen.tables.axes import make_axes

ALPHA_DEG, SPEED = 60.0, 200.0
N = 400_000
#: Components that are channels themselves: their laws are marginals, whatever the dependence.
CHANNELS = ("v", "omega_x", "omega_y", "omega_z", "collisions")
#: Draws differ from the law of the table by more than the root with probability 1e-6 in the worst
#: of five columns; 0.003 are for 129 knots and 16-bit numbers.
BOUND = np.sqrt(np.log(10.0 / 1e-6) / (2.0 * N)) + 0.003


def node_config(mirror):
    return load_config("corundum-steel").with_changes(
        {
            "domain": {
                "alpha_deg": [ALPHA_DEG, ALPHA_DEG],
                "speed": [SPEED, SPEED],
                "components": list(CHANNELS),
            },
            "table": {
                "samples_per_node": 20_000,
                "components": 24,
                "quantile_knots": 129,
                "mirror": mirror,
            },
        }
    )


def drawn(contents):
    return Table(contents).sample(np.radians(ALPHA_DEG), SPEED, seed=1, index=np.arange(N))


@pytest.fixture(scope="module")
def config():
    return node_config(mirror=False)


@pytest.fixture(scope="module")
def sample(config):
    """The very particles that the node was made from."""
    keys = {"seed": config.table.seed, "stream": node_stream(ALPHA_DEG, SPEED), "threads": 1}
    count = config.table.samples_per_node
    simulation = simulate(config, np.radians(ALPHA_DEG), SPEED, count, **keys)
    return simulated_variables(simulation, CHANNELS)


@pytest.fixture(scope="module")
def contents(config):
    return assemble(config, make_axes(config), [fit_node(config, ALPHA_DEG, SPEED)])


def test_draws_have_the_marginals_of_the_sample(contents, sample):
    assert ks_distances(drawn(contents), sample).max() < BOUND


@pytest.mark.parametrize(
    ("path", "shift"),
    [
        ("dependence/mean", 400),
        ("dependence/reflection", 400),
        ("dependence/alias_probability", 20_000),
        ("marginals/quantiles", np.float32(0.01)),
    ],
)
def test_another_mixture_or_other_quantiles_are_refused(contents, sample, path, shift):
    """Quantiles belong to the mixture of the node, with its reflections and weights."""
    values, highest = contents[path], {"reflection": 4096, "alias_probability": 65535}
    limit = highest.get(path.partition("/")[2], 32767)
    moved = np.minimum(values.astype(np.float64) + shift, limit).astype(values.dtype)
    if path == "marginals/quantiles":
        moved[..., 1:, :] = values[..., 1:, :]  # v only, which has room
    wrong = replace(contents, datasets={**contents.datasets, path: moved})
    assert ks_distances(drawn(wrong), sample).max() > BOUND


def without_reflection(contents):
    reflection = np.zeros_like(contents["dependence/reflection"])
    return replace(contents, datasets={**contents.datasets, "dependence/reflection": reflection})


def test_exact_symmetry_has_the_marginals_of_the_sample_with_its_reflection(sample):
    config = node_config(mirror=True)
    contents = assemble(config, make_axes(config), [fit_node(config, ALPHA_DEG, SPEED)])
    signs = np.array([-1.0 if name in MIRRORED else 1.0 for name in CHANNELS])
    doubled = np.concatenate([sample, sample * signs])
    assert ks_distances(drawn(contents), doubled).max() < BOUND
    # Refused: the same components, never reflected.
    assert ks_distances(drawn(without_reflection(contents)), doubled).max() > BOUND
