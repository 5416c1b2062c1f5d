"""Whatever numbers a table has within its bounds, the library opens it, and draws are finite.

The numbers of these tables are random, often at the ends of what is allowed, and mean nothing.
"""

import numpy as np
import pytest
from synthetic_table import make_contents, table_of

from sampler import InputError, Table
from sampler.formats.bounds import ALPHA_DEG, MOST_NUMBER, QUANTILES, ROUNDING, SPEED, VARIATE_MAX
from sampler.formats.channels import STATE, VARIABLES, WORKS, channels_for

N_DRAWS = 200


def numbers_between(rng, low, high, shape):
    """Numbers of the closed interval, many at its ends, of all orders of magnitude."""
    share = rng.choice([0.0, 1.0, rng.uniform()], shape) * 10.0 ** rng.choice([0, -3, -9], shape)
    return np.clip(low + share * (high - low), low, high)


def axis(rng, bounds, nodes):
    """Nodes, ends and coordinate of an axis; the numbers of the nodes may begin anywhere."""
    if nodes == 1:
        node = numbers_between(rng, *bounds, 1)
        return node, node[[0, 0]], np.zeros(int(rng.integers(2, 9)))
    width, end = 10.0 ** rng.uniform(-7.0, 0.0), bounds[1] * 10.0 ** rng.choice([0.0, -2.0, -7.0])
    ends = np.array([max(end * (1.0 - width), bounds[0]), end])
    grid = int(rng.integers(nodes, nodes + 30))
    at = np.sort(rng.choice(grid, nodes, replace=False))
    numbers = np.arange(nodes) + (rng.integers(1, 20) if at[0] > 0 else 0)
    places = [-1, *at, grid]  # beyond the nodes as in a table that was pruned
    coordinate = np.interp(np.arange(grid), places, [-1e-3, *numbers, numbers[-1] + 20])
    return np.linspace(*ends, grid)[at], ends, coordinate


def random_quantiles(rng, marginals, shape):
    """Quantile functions with jumps, up to the last numbers within their bounds."""
    quantiles = np.empty((*shape[:-1], len(marginals), shape[-1]), dtype=np.float32)
    for k, name in enumerate(marginals):
        low, high = (np.float32(end) for end in QUANTILES[name])
        low, high = np.nextafter(low, np.float32(1)), np.nextafter(high, np.float32(0))
        quantiles[..., k, :] = np.sort(numbers_between(rng, low, high, shape), axis=-1)
    return quantiles


def random_contents(seed, variables):
    """A table of random numbers, or `TableError` if they are not allowed."""
    rng = np.random.default_rng(seed)
    marginals = channels_for(variables)
    n, shape = len(marginals), tuple(int(k) for k in rng.integers(1, 4, 2))
    classes, components, knots = (int(k) for k in rng.integers((1, 1, 2), (4, 6, 20)))
    alpha, speed = (axis(rng, *given) for given in ((ALPHA_DEG, shape[0]), (SPEED, shape[1])))
    most = float(np.exp(rng.uniform(*np.log(VARIATE_MAX))))
    factors = rng.choice([-32768, 32767, 1], (*shape, components, n * (n + 1) // 2))
    factors[..., [row * (row + 3) // 2 for row in range(n)]] = rng.choice([1, 32767])
    starts = np.sort(rng.integers(0, components + 1, (*shape, classes)), axis=-1)
    starts[..., 0] = 0
    return table_of(
        variables,
        marginals,
        alpha,
        speed,
        np.linspace(-most, most, knots),
        random_quantiles(rng, marginals, (*shape, classes, knots)),
        first_of_class=starts,
        alias_probability=rng.integers(0, 65536, (*shape, components)),
        alias_index=rng.integers(0, components, (*shape, components)),
        reflection=rng.integers(0, 4097, (*shape, components)),
        mean=rng.choice([-32768, 0, 32767], (*shape, components, n)),
        cholesky=factors,
    )


def random_conditions(contents, rng):
    """Angles and speeds on and between the nodes, and at the ends."""
    places = []
    for nodes in (np.radians(contents["axes/alpha_deg"]), contents["axes/speed"]):
        between = nodes[0] + rng.uniform(size=N_DRAWS) * (nodes[-1] - nodes[0])
        places.append(
            np.where(rng.uniform(size=N_DRAWS) < 0.5, rng.choice(nodes, N_DRAWS), between)
        )
    return places


@pytest.mark.parametrize(
    "variables", [STATE, VARIABLES[:8], (*STATE, *WORKS)], ids=["six", "eight", "works"]
)
def test_every_table_opens_and_every_draw_is_finite(variables):
    for seed in range(60):
        contents = random_contents(seed, variables)
        rng, index = np.random.default_rng(seed), np.arange(N_DRAWS, dtype=np.uint64)
        table = Table(contents)
        states = table.sample(*random_conditions(contents, rng), seed=3, index=index)
        assert sum(table.counts.values()) == 0
        assert np.isfinite(states).all(), seed
        energy = (states[:, :3] ** 2).sum(axis=1)
        if len(variables) > 6:
            energy += states[:, 6:8].sum(axis=1) if "work_shear" in variables else states[:, 6]
            assert (states[:, 6:8] >= 0.0).all(), seed
        # the last digit of a sum of squares
        assert ((states[:, 1] > 0.0) & (states[:, 1] < 1.0) & (energy <= 1.0 + 1e-15)).all(), seed


def steep(most):
    """Contents whose coordinate rises by `most` right behind a node."""
    contents = random_contents(7, STATE)
    nodes, datasets = len(contents["axes/alpha_deg"]), dict(contents.datasets)
    ends = 20.0 * np.array([1.0, 1.0 + nodes * 1e-8])
    datasets["axes/alpha_span_deg"] = ends
    datasets["axes/alpha_deg"] = np.linspace(*ends, nodes + 1)[:-1]
    datasets["axes/alpha_coordinate"] = np.array([*range(nodes), nodes - 1.0 + most])
    return make_contents(datasets)


def test_a_node_at_a_jump_must_be_whole_in_radians_too():
    """Its number is computed anew from radians, and must be the same but for rounding."""
    assert ROUNDING / 1e-8 * 100.0 < 0.02 < ROUNDING / 1e-8 * 1e6
    Table(steep(100.0))
    with pytest.raises(InputError, match=r"axes/alpha_coordinate: .*: the number of the node"):
        steep(MOST_NUMBER / 2.0)
