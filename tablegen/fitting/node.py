"""One node of a table: simulate the condition, fit the law, pack the arrays.

A node is a pure function of the configuration and its number, so nodes can be made in any order,
on any number of workers, with the same bytes.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from sampler.channels import CHANNELS, FIRST_MIRRORED, to_channels
from tablegen.config import Config
from tablegen.fitting.alias import alias_table
from tablegen.fitting.marginals import SCORE_MAX, quantile_knots, score_knots
from tablegen.fitting.mixture import Mixture, fit_mixture
from tablegen.fitting.scores import normal_scores, score_maps
from tablegen.simulate import simulate_configured

#: EM iterations on the whole sample; the gain of more is within the noise of the classifier.
EM_ITERATIONS = 20

#: Knots of the score maps, in the mixture's variates. A fitted variate beyond the last one has
#: the score of the last one.
MAP_KNOTS = 129
VARIATE_MAX = 5.5


class NodeArrays(NamedTuple):
    """Arrays of one node, as the table file stores them."""

    quantiles: NDArray[np.float32]
    scores: NDArray[np.float32]
    alias_probability: NDArray[np.float32]
    alias_index: NDArray[np.uint16]
    mean: NDArray[np.float32]
    cholesky: NDArray[np.float32]


def variate_knots() -> NDArray[np.float64]:
    """Variates at the knots of the score maps, exactly symmetric about zero."""
    half = np.linspace(0.0, VARIATE_MAX, MAP_KNOTS // 2 + 1)
    return np.concatenate([-half[:0:-1], half])


def mirror_signs(mirror: bool) -> NDArray[np.float64]:
    """Signs of the channels under reflection in the impact plane; all ones without mirror."""
    signs = np.ones(len(CHANNELS))
    if mirror:
        signs[FIRST_MIRRORED:] = -1.0
    return signs


def _pack_mixture(mixture: Mixture, components: int) -> tuple[NDArray[np.float64], ...]:
    """Weights, means and packed Cholesky factors, padded with components of weight zero."""
    count, dimension = mixture.mean.shape
    rows, columns = np.tril_indices(dimension)
    weight = np.zeros(components)
    mean = np.zeros((components, dimension))
    factor = np.repeat(np.eye(dimension)[None], components, axis=0)
    weight[:count] = mixture.weight
    mean[:count] = mixture.mean
    factor[:count] = np.linalg.cholesky(mixture.covariance)
    return weight, mean, factor[:, rows, columns]


def fit_node(config: Config, alpha_deg: float, speed: float, number: int) -> NodeArrays:
    """Simulate and fit one node.

    Parameters
    ----------
    config : Config
    alpha_deg, speed : float
        Impact angle [degrees] and speed [m/s] of the node.
    number : int
        Its place in the grid, row by row; the stream of its random numbers.

    Returns
    -------
    NodeArrays
    """
    table = config.table
    simulation = simulate_configured(
        config,
        alpha_deg,
        speed,
        table.samples_per_node,
        seed=table.seed,
        stream=number,
        threads=1,
    )
    channels = to_channels(simulation.state)
    mirror = mirror_signs(table.mirror)
    rng = np.random.Generator(np.random.Philox(key=[table.seed, number]))
    # one BLAS thread: the nodes are the parallel work, and sums keep their order
    with threadpool_limits(limits=1, user_api="blas"):
        scores = normal_scores(channels, mirror)
        mixture = fit_mixture(scores, table.components, rng, mirror, EM_ITERATIONS)
        weight, mean, factor = _pack_mixture(mixture, table.components)
        maps = score_maps(mixture, variate_knots(), SCORE_MAX)
    probability, alias = alias_table(weight)
    knots = quantile_knots(channels, score_knots(table.quantile_knots), mirror)
    return NodeArrays(
        quantiles=knots.astype(np.float32),
        scores=maps.astype(np.float32),
        alias_probability=probability,
        alias_index=alias,
        mean=mean.astype(np.float32),
        cholesky=factor.astype(np.float32),
    )
