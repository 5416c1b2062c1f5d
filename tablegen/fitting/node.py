"""One node of a table: simulate the condition, fit the law, pack the arrays.

A node is a pure function of the configuration and its condition, so nodes can be made in any
order, on any number of workers, with the same bytes.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from sampler.channels import CHANNELS, FIRST_MIRRORED, to_channels
from sampler.encoding import from_steps, to_steps
from tablegen.config import Config
from tablegen.fitting.alias import alias_table
from tablegen.fitting.classes import CLASSES, class_of, shared_out
from tablegen.fitting.marginals import SCORE_MAX, quantile_knots, score_knots
from tablegen.fitting.mixture import Mixture, fit_mixture
from tablegen.fitting.resolution import Resolution, resolution
from tablegen.fitting.scores import normal_scores, score_maps
from tablegen.simulate import simulate_configured
from tablegen.workshop import Stopwatch, stable_number

#: Knots of the score maps, in the mixture's variates. A fitted variate beyond the last one has
#: the score of the last one.
MAP_KNOTS = 65
VARIATE_MAX = 5.5

#: Points of the sample that the mixture is fitted to, for each component: more gain nothing.
_POINTS_PER_COMPONENT = 800

#: Shape of the score maps of one class.
_MAPS = (len(CHANNELS), MAP_KNOTS)


class NodeArrays(NamedTuple):
    """Arrays of one node, as the table file stores them."""

    quantiles: NDArray[np.float32]
    scores: NDArray[np.float32]
    first_of_class: NDArray[np.uint16]
    alias_probability: NDArray[np.float32]
    alias_index: NDArray[np.uint16]
    mean: NDArray[np.int16]
    cholesky: NDArray[np.int16]


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


def _pack_mixture(
    mixture: Mixture, components: int
) -> tuple[NDArray[np.float64], NDArray[np.int16], NDArray[np.int16]]:
    """Weights, means and packed Cholesky factors, padded with components of weight zero."""
    count, dimension = mixture.mean.shape
    rows, columns = np.tril_indices(dimension)
    weight = np.zeros(components)
    mean = np.zeros((components, dimension))
    factor = np.repeat(np.eye(dimension)[None], components, axis=0)
    weight[:count] = mixture.weight
    mean[:count] = mixture.mean
    factor[:count] = np.linalg.cholesky(mixture.covariance)
    return weight, to_steps(mean), to_steps(factor[:, rows, columns])


def _as_stored(mixture: Mixture) -> Mixture:
    """Give the mixture that the rounded numbers stand for."""
    factor = from_steps(to_steps(np.linalg.cholesky(mixture.covariance)))
    covariance = factor @ factor.transpose(0, 2, 1)
    return replace(mixture, mean=from_steps(to_steps(mixture.mean)), covariance=covariance)


def node_stream(alpha_deg: float, speed: float) -> int:
    """Stream of the random numbers of the node at a condition, below 2**31."""
    return stable_number(f"node {alpha_deg!r} {speed!r}", 31)


def fit_node(
    config: Config,
    alpha_deg: float,
    speed: float,
    size: Resolution | None = None,
    watch: Stopwatch | None = None,
) -> NodeArrays:
    """Simulate and fit one node.

    Parameters
    ----------
    config : Config
    alpha_deg, speed : float
        Impact angle [degrees] and speed [m/s] of the node.
    size : Resolution, optional
        By default what the configuration names or its accuracy needs.
    watch : Stopwatch, optional
        Counts the time of simulation and fit.

    Returns
    -------
    NodeArrays
    """
    seed, stream = config.table.seed, node_stream(alpha_deg, speed)
    size, watch = size or resolution(config), watch or Stopwatch()
    simulation = simulate_configured(
        config, alpha_deg, speed, size.samples, seed=seed, stream=stream, threads=1
    )
    watch.stage("simulation")
    channels = to_channels(simulation.state)
    rng = np.random.Generator(np.random.Philox(key=[seed, stream]))
    # one BLAS thread: the nodes are the parallel work, and sums keep their order
    with threadpool_limits(limits=1, user_api="blas"):
        node = _fit_classes(
            channels, class_of(simulation.collisions), size, mirror_signs(config.table.mirror), rng
        )
    watch.stage("fit")
    return node


def _fit_classes(
    channels: NDArray[np.float64],
    kind: NDArray[np.int64],
    size: Resolution,
    mirror: NDArray[np.float64],
    rng: np.random.Generator,
) -> NodeArrays:
    """Fit every class of a sample and put them together."""
    knots = score_knots(size.knots)
    count = [int(np.sum(kind == k)) for k in range(len(CLASSES))]
    shares = shared_out(size.components, count)
    mixtures, quantiles, scores = [], [], []
    for k, share in enumerate(shares):
        if share == 0:
            # never drawn from here, but averaged with nodes that have such rebounds
            quantiles.append(quantile_knots(channels, knots, mirror))
            scores.append(np.broadcast_to(np.clip(variate_knots(), knots[0], knots[-1]), _MAPS))
            continue
        part = channels[kind == k]
        points = normal_scores(part, mirror)[: _POINTS_PER_COMPONENT * share]
        mixture = fit_mixture(points, share, rng, mirror)
        weight, mean, factor = _pack_mixture(mixture, share)
        mixtures.append((weight * count[k], mean, factor))
        quantiles.append(quantile_knots(part, knots, mirror))
        scores.append(score_maps(_as_stored(mixture), variate_knots(), SCORE_MAX))
    weight, mean, factor = (np.concatenate(parts) for parts in zip(*mixtures, strict=True))
    probability, alias = alias_table(weight)
    return NodeArrays(
        quantiles=np.stack(quantiles).astype(np.float32),
        scores=np.stack(scores).astype(np.float32),
        first_of_class=np.cumsum([0, *shares[:-1]]).astype(np.uint16),
        alias_probability=probability,
        alias_index=alias,
        mean=mean,
        cholesky=factor,
    )
