"""Statistics of draws against the law in the table, each with a wrong law that it refuses.

Seeds are fixed. Each comparison would refuse a right sampler with probability 1e-6, the whole
file with less than 1e-4.
"""

import numpy as np
import pytest
from scipy.special import ndtr, ndtri
from synthetic_table import channel_quantiles, class_parts, make_contents

import sampler

N = 100_000
#: Kolmogorov's bound: P(D > bound) < 2 exp(-2 n bound^2) = 1e-6.
KS_BOUND = np.sqrt(np.log(2.0 / 1e-6) / (2.0 * N))
#: Interpolation error of the made-up table's quantiles (65 knots).
MAP_ERROR = 0.0035


def _shares(contents, i, j):
    """Probability of each class at a node, by undoing the alias table."""
    stay = contents["dependence/alias_probability"][i, j] / 65536.0
    weight = stay.copy()
    np.add.at(weight, contents["dependence/alias_index"][i, j], 1.0 - stay)
    parts = class_parts(contents["dependence/first_of_class"][i, j], len(weight))
    return np.array([weight[part].sum() for part in parts]) / len(weight)


def _scores(contents, states, weights):
    """Normal scores of draws under the law of a node, or under the one class between nodes.

    The marginals are those that the made-up table was made from, not those that it stores.
    """
    u, v, w, omega_x, omega_y, omega_z = states.T
    u_hat = u / np.sqrt(1.0 - v**2)
    w_hat = w / np.sqrt(1.0 - v**2 - u**2)
    channels = (v, u_hat, omega_z, w_hat, omega_x, omega_y)
    n_classes = contents["marginals/quantiles"].shape[2]
    shares = [1.0] if n_classes == 1 else _shares(contents, *np.argwhere(weights)[0])
    p = ndtr(np.linspace(-5.0, 5.0, 2001))
    probability = np.zeros((6, len(states)))
    for kind, share in enumerate(shares):
        nodes = [(w, channel_quantiles(p, i, j, kind)) for (i, j), w in np.ndenumerate(weights)]
        quantiles = sum(w * q for w, q in nodes)
        for k, x in enumerate(channels):
            probability[k] += share * np.interp(x, quantiles[k], p)
    return ndtri(np.clip(probability, 1e-6, 1.0 - 1e-6))


def _ks(scores):
    """Distance of each row to the standard normal law; ties at the ends of the table count 0."""
    p = np.sort(ndtr(scores), axis=1)
    n = p.shape[1]
    upper = np.arange(1, n + 1) / n - p
    lower = p - np.arange(n) / n
    return np.maximum(upper.max(axis=1), lower.max(axis=1))


def _at_node(i, j):
    weights = np.zeros((3, 3))
    weights[i, j] = 1.0
    return weights


def _node_draws(table, i, j, seed=1):
    alpha1 = np.deg2rad(table.alpha_nodes_deg[i])
    return table.sample(alpha1, table.speed_nodes[j], seed=seed, index=np.arange(N))


def _without_reflection(contents):
    datasets = dict(contents.datasets)
    datasets["dependence/reflection"] = np.zeros_like(datasets["dependence/reflection"])
    return sampler.Table(make_contents(datasets))


@pytest.mark.parametrize(("i", "j"), [(0, 0), (2, 2)])
def test_marginals_at_a_node(standard_contents, standard_table, i, j):
    scores = _scores(standard_contents, _node_draws(standard_table, i, j), _at_node(i, j))
    assert (_ks(scores) < KS_BOUND).all()
    # Refused: a law that is off by a twentieth of a standard deviation, or by 5 % in width.
    assert (_ks(scores + 0.05) > KS_BOUND).all()
    assert (_ks(scores * 1.05) > KS_BOUND).all()


def test_marginals_between_nodes(standard_contents, standard_table):
    """The quantile function between nodes is the average with the bilinear weights."""
    contents = standard_contents
    # Half-way in the coordinate of each axis: an independent inversion of the tabulated one.
    grid = np.deg2rad(np.linspace(20.0, 90.0, len(contents["axes/alpha_coordinate"])))
    alpha1 = np.interp(0.5, contents["axes/alpha_coordinate"], grid)
    grid = np.linspace(50.0, 300.0, len(contents["axes/speed_coordinate"]))
    speed = np.interp(1.25, contents["axes/speed_coordinate"], grid)
    weights = np.zeros((3, 3))
    weights[:2, 1:] = np.outer([0.5, 0.5], [0.75, 0.25])
    states = standard_table.sample(alpha1, speed, seed=3, index=np.arange(N))
    assert (_ks(_scores(contents, states, weights)) < KS_BOUND).all()
    weights[:2, 1:] = np.outer([0.5, 0.5], [0.25, 0.75])
    assert (_ks(_scores(contents, states, weights)) > KS_BOUND).any()


def test_marginals_of_a_mixture(contents, table):
    """Component choice, reflection and score map together give the stored marginals."""
    scores = _scores(contents, _node_draws(table, 1, 2), _at_node(1, 2))
    assert (_ks(scores) < KS_BOUND + MAP_ERROR).all()
    # Refused: the same without the reflection, which the map presumes.
    plain = _without_reflection(contents)
    scores = _scores(contents, _node_draws(plain, 1, 2), _at_node(1, 2))
    assert (_ks(scores)[3:] > KS_BOUND + MAP_ERROR).any()


def test_correlations_of_the_scores(standard_contents, standard_table):
    contents = standard_contents
    factor = np.zeros((6, 6))
    factor[np.tril_indices(6)] = contents["dependence/cholesky"][1, 1, 0] / 4096.0
    scores = _scores(contents, _node_draws(standard_table, 1, 1), _at_node(1, 1))
    # Standard error at most 1/sqrt(N); 15 correlations at 1e-6 in all need 5.4 of them.
    bound = 5.4 / np.sqrt(N)
    expected = factor @ factor.T
    assert np.abs(expected - np.eye(6)).max() > 0.2
    assert np.abs(np.corrcoef(scores) - expected).max() < bound
    # Refused: independent marginals, which have the same histograms.
    rng = np.random.default_rng(0)
    shuffled = np.array([rng.permutation(row) for row in scores])
    assert np.abs(np.corrcoef(shuffled) - expected).max() > bound
